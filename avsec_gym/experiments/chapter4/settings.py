"""The conditions, parts, states and rates of chapter 4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.traffic import MessageKind
from avsec_gym.validation.connected.validator import Method

Part = Literal["fitted", "judged"]
FITTED: Part = "fitted"
JUDGED: Part = "judged"
"""The two parts of a run: places that thresholds come from, made of the training assets, and places
that are judged, made of the others."""
State = Literal["clean", "ghost", "removal"]
CLEAN: State = "clean"
ATTACKS: tuple[AttackKind, ...] = get_args(AttackKind)
METHODS: tuple[Method, ...] = ("surfaces", "rays", "learned")
"""The thesis' method first; the last one learned to weigh what both state."""
Namer = Literal["thesis", "surfaces", "rays", "learned"]
NAMERS: tuple[Namer, ...] = get_args(Namer)
"""Who names: the thesis' own rule, and the methods, with whom two independent vehicles accuse."""
SENT_BY: dict[Method, tuple[MessageKind, ...]] = {
    "surfaces": (MessageKind.PROPOSALS, MessageKind.CROPS),
    "rays": (MessageKind.PROPOSALS, MessageKind.CLAIMS, MessageKind.COUNTS),
    "learned": tuple(MessageKind),
}
"""The messages of a vehicle that each method needs."""
DecidedBy = Literal["geometry", "rays"]
BY_GEOMETRY: DecidedBy = "geometry"
BY_RAYS: DecidedBy = "rays"
"""What makes a region decidable: rays of clean scans at true poses (`CleanRays`), for all methods
and conditions alike; or, beside it, the counts that the method of rays itself has received."""
STATES_OF: dict[Part, tuple[State, ...]] = {FITTED: (CLEAN,), JUDGED: (CLEAN, *ATTACKS)}

RATES = (0.01, 0.03, 0.1)
"""False positive rates of tables."""
CURVE_RATES = (0.0, 0.01, 0.02, 0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Designated false positive rates r of figure 4b."""
OPERATING_RATE = 0.03
"""The rate of what is stated at one rate..."""
EXACT_RATE = 0.01
"""... and where poses and clocks are exact."""
MOST_VEHICLES = 6
"""So many vehicles have sensors at every place; a condition takes the first of them."""


@dataclass(frozen=True)
class ConnectedCondition:
    """What the vehicles know of each other, and how many they are.

    Args:
        noise: Standard deviation of measured positions along x and along y, metres, and, of the
            same number, of measured headings in degrees.
        clocks_apart: Longest time between two vehicles' triggers, seconds.
        vehicles: Number of vehicles.
    """

    noise: float
    clocks_apart: float
    vehicles: int

    @property
    def name(self) -> str:
        """The condition's name in results, such as ``0.2 m, 0.2 deg, 100 ms, 3 vehicles``."""
        apart = f"{1000 * self.clocks_apart:g} ms"
        return f"{self.noise:g} m, {self.noise:g} deg, {apart}, {self.vehicles} vehicles"


EXACT = ConnectedCondition(0.0, 0.0, 3)
NOISY = ConnectedCondition(0.2, 0.0, 3)
USUAL = ConnectedCondition(0.2, 0.1, 3)
"""Poses and clocks as the goals of the project name them."""
FIVE = ConnectedCondition(0.2, 0.1, 5)
"""The same with five vehicles, of which three and more can be witnesses of one attack."""
CONDITIONS = (
    EXACT,
    NOISY,
    ConnectedCondition(0.5, 0.0, 3),
    USUAL,
    *(ConnectedCondition(0.2, 0.1, vehicles) for vehicles in (2, 4)),
    FIVE,
    ConnectedCondition(0.2, 0.1, MOST_VEHICLES),
)
"""One factor at a time: errors of poses, then clocks, then the number of vehicles."""
OPTIONS = {"conditions": [], "constants": "", "model": ""}
"""``conditions``: places in `CONDITIONS` that are measured, from 0; all if empty. ``constants``: a
file that `avsec connected --fit` wrote; the package's own if empty. ``model``: likewise, a file
that `avsec connected --method learned --fit` wrote."""
