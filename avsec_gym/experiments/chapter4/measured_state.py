"""What is kept of an instant in one state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, BY_RAYS, SENT_BY, DecidedBy, Namer
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.result import Naming
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class KnownAttack:
    """What is known of an attack before any method is asked.

    Args:
        witnesses: The number of vehicles with which the victim's scan can be compared there, see
            `CleanRays.witnesses`; 0: undecidable.
        distance: Its distance from the victim, metres.
        category: KITTI's name of what was removed; empty for a ghost.
    """

    witnesses: int
    distance: float
    category: str = ""


@dataclass(frozen=True, eq=False)
class MeasuredState:
    """An instant without an attack, or under one.

    Args:
        place: Name of the place, which stands in one instant only.
        attack: The attack; None without one: not every scan offers something.
        decidable: Whether each region is decidable, shape (R,), by what decides it.  Without an
            attack these are all regions, under one those about what was attacked.
        scores: The score of each region, by method; -inf where nothing was compared, shape (R,).
        probabilities: The fitted probability of an attack of each region, by method, shape (R,).
        named: The `Naming` of each region, by who names, shape (R,); empty without an attack.
        honest: The number of vehicles that are named in any region without being attacked.
        distances: Distances of pairs of surfaces, metres, shape (D,): of all pairs, under an
            attack those of the victim (equation 4.1).
        pairs: The number of such pairs, compared or not.
        witnesses_by_rays: The number of vehicles with which the counts of the method of rays, under
            all errors, compare the victim there enough to decide; 0 without an attack.
        seconds: CPU time of all vehicles and the base station after the proposals, by method.
        sent: The bytes that each vehicle sent, by kind of message, shape (V,); empty under an
            attack.
        from_station: The bytes that the base station sent to all, by kind; empty under an attack.
    """

    place: str
    attack: KnownAttack | None
    decidable: Mapping[DecidedBy, NDArray[np.bool_]]
    scores: Mapping[Method, Floats]
    probabilities: Mapping[Method, Floats]
    named: Mapping[Namer, NDArray[np.int64]]
    honest: Mapping[Namer, int]
    distances: Floats
    pairs: int
    witnesses_by_rays: int
    seconds: Mapping[Method, float]
    sent: Mapping[str, NDArray[np.int64]]
    from_station: Mapping[str, int]

    @property
    def regions(self) -> int:
        """R, the number of regions."""
        return len(self.decidable[BY_GEOMETRY])

    @property
    def covered(self) -> bool:
        """Whether some region is about what was attacked."""
        return self.attack is not None and self.regions > 0

    def witnesses(self, by: DecidedBy) -> int:
        """The number of witnesses of the attack; 0 without one."""
        if self.attack is None or by == BY_RAYS:
            return self.witnesses_by_rays
        return self.attack.witnesses

    def is_decidable(self, by: DecidedBy = BY_GEOMETRY) -> bool:
        """Whether one of the regions is decidable."""
        return bool(self.decidable[by].any())

    def highest(self, method: Method, by: DecidedBy = BY_GEOMETRY) -> float:
        """The highest score of the decidable regions; -inf without any."""
        return float(self.scores[method][self.decidable[by]].max(initial=-np.inf))

    def naming(self, namer: Namer) -> Naming:
        """The naming in the region about the attack that has the highest score."""
        if not self.regions:
            return Naming.NO_ALARM
        method: Method = "surfaces" if namer == "thesis" else namer
        return Naming(int(self.named[namer][self.scores[method].argmax()]))

    def nbytes(self, method: Method) -> NDArray[np.int64]:
        """The bytes that a method has each vehicle send, its proposals among it, shape (V,)."""
        kinds = [self.sent[kind] for kind in SENT_BY[method] if kind in self.sent]
        return np.sum(kinds, axis=0) if kinds else np.zeros(0, np.int64)
