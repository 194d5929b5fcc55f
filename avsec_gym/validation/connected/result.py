"""`ConnectedResult`: what connected vehicles and their base station make of an instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.claims import Claims
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.traffic import SentMessages

AttackKind = Literal["ghost", "removal"]
"""Something is in a scan that is not there, or is missing from it that is."""


class Naming(IntEnum):
    """What a validator makes of an attack, by the regions that are about it."""

    NO_ALARM = 0
    """None of them alarms."""
    CANNOT_TELL = 1
    VICTIM = 2
    ANOTHER = 3


@dataclass(frozen=True)
class AccusedRegion:
    """A region that alarms.

    Args:
        index: The region's number among those of the instant.
        kind: What the best explanation is.
        probability: Probability of an attack.
        vehicle: The vehicle whose LiDAR is attacked, or `CANNOT_TELL`.
        share: Probability, if there is an attack, of this kind and vehicle; of the likeliest
            vehicle where that cannot be decided.
    """

    index: int
    kind: AttackKind
    probability: float
    vehicle: int
    share: float


@dataclass(frozen=True, eq=False)
class ConnectedResult:
    """The regions of an instant with what is decided of them, V vehicles and R regions.

    Args:
        id: Name of the instant.
        method: ``rays``, ``surfaces`` or ``learned``.
        regions: The complete set, world frame.
        score: How much speaks for an attack, shape (R,): log-likelihood ratio of the best
            explanation (rays), the largest distance in metres (surfaces) or the model's log odds
            (learned); -inf where nothing was compared.
        probability: Probability of an attack, shape (R,).
        decidable: Whether something was compared, shape (R,).
        ghost: Probability, if there is an attack, of a ghost in each vehicle's scan, shape (R, V).
        removal: Probability, if there is an attack, of an object removed from each vehicle's
            scan, shape (R, V).
        named: The victim, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
        traffic: The messages, with bytes and seconds.
        counts: What witness ``k`` reports of the claim of ``j``, shape (R, V, V, 3); None without
            rays.
        distances: Distances of the surfaces of all pairs, metres, shape (R, V, V); None without
            surfaces.
        claims: The vehicles' claims in the regions, by number; None without rays.
    """

    id: str
    method: str
    regions: Regions
    score: Floats
    probability: Floats
    decidable: NDArray[np.bool_]
    ghost: Floats
    removal: Floats
    named: NDArray[np.int64]
    traffic: SentMessages
    counts: NDArray[np.int64] | None = None
    distances: Floats | None = None
    claims: Mapping[int, Claims] | None = None

    @property
    def alarm(self) -> bool:
        """Whether some region alarms."""
        return bool((self.named != NO_ATTACK).any())

    @property
    def accused(self) -> tuple[int, ...]:
        """The vehicles that are named, by number; none at an alarm: which one cannot be decided."""
        return tuple(sorted(set(self.named[self.named >= 0].tolist())))

    @property
    def decidable_share(self) -> float | None:
        """Share of the regions in which something was compared; None without regions."""
        return float(self.decidable.mean()) if len(self.regions) else None

    @property
    def highest_score(self) -> float:
        """The highest score of all regions; -inf where nothing was compared."""
        return float(self.score.max(initial=-np.inf))

    @property
    def bytes_of_vehicles(self) -> tuple[int, ...]:
        """All bytes that each vehicle sent."""
        return tuple(each.total() for each in self.traffic.sent)

    @property
    def accusations(self) -> tuple[AccusedRegion, ...]:
        """The regions that alarm, the likeliest attack first."""
        found = np.flatnonzero(self.named != NO_ATTACK)
        return tuple(self._accusation(int(i)) for i in found[np.argsort(-self.probability[found])])

    def _accusation(self, index: int) -> AccusedRegion:
        vehicle = int(self.named[index])
        shares = np.stack([self.ghost[index], self.removal[index]])
        of_victims = shares if vehicle == CANNOT_TELL else shares[:, [vehicle]]
        kind: AttackKind = "ghost" if of_victims[0].max() >= of_victims[1].max() else "removal"
        return AccusedRegion(
            index, kind, float(self.probability[index]), vehicle, float(of_victims.max())
        )

    def to_json(self) -> dict[str, Any]:
        """A row for a file or a line of JSON; `vehicle` is null where it cannot be decided."""
        return {
            "id": self.id,
            "method": self.method,
            "alarm": self.alarm,
            "accused": list(self.accused),
            "regions": len(self.regions),
            "decidable": int(self.decidable.sum()),
            "score": self.highest_score if np.isfinite(self.highest_score) else None,
            "accusations": [
                {
                    "kind": each.kind,
                    "vehicle": None if each.vehicle == CANNOT_TELL else each.vehicle,
                    "probability": round(each.probability, 4),
                    "share": round(each.share, 4),
                    "centre": self.regions.centre[each.index].round(2).tolist(),
                    "size": self.regions.size[each.index].round(2).tolist(),
                    "heading": round(float(self.regions.heading[each.index]), 4),
                }
                for each in self.accusations
            ],
            **self.traffic.to_json(),
        }
