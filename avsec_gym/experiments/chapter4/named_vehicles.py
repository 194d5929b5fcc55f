"""Who is named in each region of an instant, by each method, and by the thesis' own rule."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.base_station import decide
from avsec_gym.validation.connected.rays.decision import NO_ATTACK
from avsec_gym.validation.connected.result import Naming


@dataclass(frozen=True, eq=False)
class NamedVehicles:
    """What is stated about R regions and V vehicles.

    Args:
        alarm: Whether each region alarms, shape (R,).
        named: Whether each vehicle is named in each region, shape (R, V).
    """

    alarm: NDArray[np.bool_]
    named: NDArray[np.bool_]

    @classmethod
    def of(cls, named: NDArray[np.int64], vehicles: int) -> NamedVehicles:
        """What a method decided.

        Args:
            named: The victim of each region, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
            vehicles: V, the number of vehicles.
        """
        return cls(named != NO_ATTACK, named[:, None] == np.arange(vehicles))

    @classmethod
    def of_thesis(cls, distances: Floats, theta: float) -> NamedVehicles:
        """What section 4.4.4 names by distances alone, whoever accuses; maybe several vehicles.

        Args:
            distances: Distances of the surfaces of all pairs, metres, shape (R, V, V).
            theta: The threshold, metres.
        """
        decisions = decide(distances, theta)
        named = np.zeros(distances.shape[:2], bool)
        for index, decision in enumerate(decisions):
            named[index, sorted(decision.attacked)] = True
        return cls(np.array([decision.alarm for decision in decisions], bool), named)

    def namings(self, victim: int) -> NDArray[np.int64]:
        """The `Naming` of each region, shape (R,); who is named beside the victim is another."""
        others = np.delete(self.named, victim, axis=1).any(axis=1)
        return np.select(
            [~self.alarm, others, self.named[:, victim]],
            [Naming.NO_ALARM, Naming.ANOTHER, Naming.VICTIM],
            Naming.CANNOT_TELL,
        ).astype(np.int64)

    def honest(self, victim: int | None = None) -> int:
        """The number of vehicles that are named in any region without being attacked.

        Args:
            victim: The number of the attacked vehicle; None: there is none.
        """
        honest = self.named if victim is None else np.delete(self.named, victim, axis=1)
        return int(honest.any(axis=0).sum())
