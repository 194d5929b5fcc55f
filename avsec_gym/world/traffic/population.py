"""The road users at the beginning, and the route on which each travels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats, Integers
from avsec_gym.world.traffic.routes import Route


class Traveller(NamedTuple):
    """A road user that follows a route."""

    category: str
    dimensions: tuple[float, float, float]
    """Height, width, length, metres."""
    route: int
    place: float
    """Place of the centre on the route, metres."""
    speed: float
    desired: float
    """The desired speed on a free road, m/s."""
    weave: tuple[float, float, float]
    """Amplitude (m), wavelength (m), phase (radians) of the small lateral motion."""
    left: float = 0.0
    """Distance kept to the left of the route, metres."""
    pause: tuple[float, float] = (np.inf, np.inf)
    """Seconds between which it stops."""
    opens: float = 0.0
    """Seconds from which it is willing to pass its gate."""
    polite: bool = True
    """Passes its gate only if no other has to brake for it."""
    started: bool = False
    """Is passing its gate already."""
    ego: int = -1
    """Number of a sensor vehicle, -1 for all others."""

    @property
    def front(self) -> float:
        """Place of its front on the route."""
        return self.place + 0.5 * self.dimensions[2]

    @property
    def rear(self) -> float:
        """Place of its rear on the route."""
        return self.place - 0.5 * self.dimensions[2]


class Bystander(NamedTuple):
    """A person or thing that stands still for good."""

    category: str
    dimensions: tuple[float, float, float]
    pose: tuple[float, float, float]
    """x, y, heading."""


@dataclass(frozen=True, eq=False)
class Population:
    """All travellers and bystanders of a site at time 0.

    Args:
        routes: Routes that are travelled.
        neighbours: Routes of the lanes to the left and right in the direction of travel, -1 for
            none, shape (R, 2).
        travellers: Road users that move, or may.
        bystanders: Road users and things that stand for good.
        egos: The sensor vehicles: indices into travellers followed by bystanders.
        appearance: Seeds of the looks, travellers first, shape (N,).
        phase: Phase of gait and pedals, in the same order.
    """

    routes: tuple[Route, ...]
    neighbours: Integers
    travellers: tuple[Traveller, ...]
    bystanders: tuple[Bystander, ...]
    egos: tuple[int, ...]
    appearance: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    phase: Floats = field(default_factory=lambda: np.zeros(0))

    def __len__(self) -> int:
        return len(self.travellers) + len(self.bystanders)
