"""What an attack on connected vehicles is: an instant in, one of its scans tampered with out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import Seed
from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.frame import Points
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import AttackKind

_SAME_PLACE = 0.1
"""Intersection over union, from above, from which a region is about what was attacked."""


@dataclass(frozen=True, eq=False)
class AttackedInstant:
    """An instant at which one vehicle's LiDAR is attacked.

    Args:
        instant: What all vehicles scanned; the victim's scan is tampered with.
        victim: Number of the victim.
        kind: What was done.
        box: Where, in the world, one region.
        points: Number of points that were put there, where they stand last in the scan, or taken
            away.
        category: KITTI's name of what was removed; empty where it is not known.
    """

    instant: RecordedInstant
    victim: int
    kind: AttackKind
    box: Regions
    points: int
    category: str = ""

    @property
    def distance(self) -> float:
        """The distance from the victim's LiDAR along the ground, metres."""
        away = self.box.centre[0, :2] - self.instant.true_pose(self.victim)[:2, 3]
        return float(np.hypot(*away))

    def regions(self, regions: Regions) -> NDArray[np.bool_]:
        """Which regions are about what was attacked, shape (R,)."""
        overlap = rectangle_iou(seen_from_above(regions), seen_from_above(self.box))
        return np.asarray(overlap[:, 0] >= _SAME_PLACE)


@runtime_checkable
class InstantAttack(Protocol):
    """Anything that tampers with the scan of one of several vehicles."""

    @property
    def name(self) -> str:
        """The name of the attack in results."""
        ...

    def attack(self, instant: RecordedInstant, seed: Seed = 0) -> AttackedInstant | None:
        """The attacked instant; None where this one offers nothing to attack.

        The same instant and seed give the same points, in every process.
        """
        ...


class AttackUnderWay(Protocol):
    """An attack that has begun and lasts."""

    def attack(self, instant: RecordedInstant, seconds: float) -> AttackedInstant | None:
        """A later instant of the same drive, attacked; None where this one offers no way to.

        Args:
            instant: What all vehicles scanned then.
            seconds: Time since the attack began.
        """
        ...


@runtime_checkable
class LastingAttack(Protocol):
    """An `InstantAttack` that can also last over the instants of a drive."""

    @property
    def step(self) -> float:
        """Seconds between two instants of a drive."""
        ...

    def begin(self, instant: RecordedInstant, seed: Seed = 0) -> AttackUnderWay | None:
        """Begin the attack; None where this instant offers nothing to begin with.

        Args:
            instant: The first instant.
            seed: The seed of all that is drawn.
        """
        ...


def with_scan(instant: RecordedInstant, vehicle: int, points: Points) -> RecordedInstant:
    """An instant with other points of one vehicle."""
    scans = tuple(
        scan.with_points(points) if number == vehicle else scan
        for number, scan in enumerate(instant.scans)
    )
    return replace(instant, scans=scans)
