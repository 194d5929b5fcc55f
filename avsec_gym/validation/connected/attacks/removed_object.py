"""`RemovedObject`: a real object is missing from one vehicle's scan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from avsec_gym.argument_checks import label, number, one_of, whole_number
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.tampered_scan import RemovedRays, remove_object
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, with_scan
from avsec_gym.validation.connected.attacks.pasted_object import (
    check_vehicle,
    drawn_vehicle,
)
from avsec_gym.validation.connected.attacks.seen_objects import (
    SeenObject,
    box_in_world,
    seen_objects,
)
from avsec_gym.validation.connected.recordings import RecordedInstant

_NEAREST, _FARTHEST = 2.0, 200.0
"""Metres from the LiDAR."""
_MARGIN = 0.15
"""Metres beyond an object's box in which points are its own: boxes are labelled tightly."""
_SMEARED = 0.05
"""Seconds of motion by which a moving object may be smeared in a scan."""


@dataclass(frozen=True)
class RemovedObject:
    """An object's echoes are outshone, or delayed until they seem to come from the ground behind.

    Args:
        vehicle: Number of the victim; None: drawn.
        farthest: Objects farther from its LiDAR are left alone, metres.
        fewest: Points that the victim has on an object that is removed.
        rays: Whether its rays are ``lost``, or ``pushed`` to the ground behind; None: drawn.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    vehicle: int | None = None
    farthest: float = 40.0
    fewest: int = 30
    rays: RemovedRays | None = None
    name: str = "removal"

    def __post_init__(self) -> None:
        check_vehicle(self.vehicle)
        if self.rays is not None:
            one_of("rays", self.rays, get_args(RemovedRays))
        number("farthest", self.farthest, _NEAREST, _FARTHEST)
        whole_number("fewest", self.fewest, 1)
        label("name", self.name)

    def attack(self, instant: RecordedInstant, seed: Seed = 0) -> AttackedInstant | None:
        """See `InstantAttack.attack`."""
        begun = self.drawn(instant, seed)
        return None if begun is None else self.remove(instant, begun)

    def drawn(self, instant: RecordedInstant, seed: Seed = 0) -> DrawnRemoval | None:
        """What is removed, from whose scan; None where this instant offers nothing.

        Args:
            instant: What all vehicles scanned.
            seed: The seed of all that is drawn.
        """
        random = np.random.default_rng(seed)
        victim = drawn_vehicle(instant, self.vehicle, random)
        rays = self.rays or (("lost", "pushed")[int(random.integers(2))])
        found = [
            each
            for each in seen_objects(instant, victim, self.fewest)
            if _NEAREST < each.distance <= self.farthest
        ]
        if not found:
            return None
        return DrawnRemoval(victim, rays, found[int(random.integers(len(found)))])

    def remove(self, instant: RecordedInstant, drawn: DrawnRemoval) -> AttackedInstant:
        """An instant without the object.

        Args:
            instant: What all vehicles scanned.
            drawn: The object, as the victim saw it at this instant.
        """
        victim, chosen = drawn.victim, drawn.seen
        scan = instant.scans[victim]
        tampered = remove_object(
            scan.compensated().points,
            chosen.pose,
            chosen.dimensions,
            drawn.rays,
            margin=_MARGIN + _SMEARED * chosen.speed,
        )
        pushed = tampered.points[tampered.bogus]
        pushed[:, :3] = scan.sweep.rolled(pushed[:, :3].astype(np.float64))
        points = np.concatenate([scan.points[~tampered.lost], pushed])
        box = box_in_world(chosen.pose, chosen.dimensions, instant.true_pose(victim))
        return AttackedInstant(
            with_scan(instant, victim, points),
            victim,
            "removal",
            box,
            int(tampered.lost.sum()),
            chosen.category,
        )


@dataclass(frozen=True, eq=False)
class DrawnRemoval:
    """What is removed from one scan.

    Args:
        victim: Number of the victim.
        rays: Whether the object's rays are ``lost``, or ``pushed`` to the ground behind.
        seen: The object as the victim saw it.
    """

    victim: int
    rays: RemovedRays
    seen: SeenObject
