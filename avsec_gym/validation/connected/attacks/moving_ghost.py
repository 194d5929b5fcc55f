"""`MovingGhost`: a ghost that lasts over the instants of a drive, and moves like a vehicle."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from avsec_gym.argument_checks import label, number
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.attacks.tampered_scan import holds_lidar
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.chosen_places import GhostArea
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject, PlacedGhost
from avsec_gym.validation.connected.attacks.seen_objects import upright_pose
from avsec_gym.validation.connected.proposals.ground_map import ground_map
from avsec_gym.validation.connected.recordings import RecordedInstant

_FASTEST, _LONGEST_STEP = 60.0, 10.0
_OVERHEAD = 5.0
"""Metres above a ghost's bottom up to which it ends where the victim's LiDAR comes."""
_REACH = 60.0
"""Metres around the victim in which the ground is looked for."""


@dataclass(frozen=True, eq=False)
class MovingGhost:
    """A ghost that is pasted at one place, and from then on drives where its victim headed.

    It keeps its own shape and heading in the world, and stands on the ground at each instant.  At a
    single instant it is a `PastedObject`.

    Args:
        vehicle: Number of the victim; None: drawn.
        distance: Least and greatest distance from its LiDAR at first, metres.
        where: Where it begins, as of `PastedObject`.
        speed: The ghost's speed, m/s; None: that of the victim when it begins, so that it stays
            ahead.
        step: Seconds between two instants of a drive.
        scan: The scan that is pasted, as of `PastedObject`.
        fewest: The fewest points of the pasted object, as of `PastedObject`.
        rays_lost: Whether the victim's rays that meet the ghost are lost, as of `PastedObject`.
        laser: The limits of the spoofing laser, as of `PastedObject`.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
        DataError: The file of a scan is missing or broken.
    """

    vehicle: int | None = None
    distance: tuple[float, float] = (8.0, 25.0)
    where: GhostArea = "path"
    speed: float | None = None
    step: float = 0.1
    scan: ObjectScan | str | Path | None = None
    fewest: int = 50
    rays_lost: bool = False
    laser: str | None = None
    name: str = "moving_ghost"
    _paste: PastedObject = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.speed is not None:
            number("speed", self.speed, 0.0, _FASTEST)
        number("step", self.step, 1e-3, _LONGEST_STEP)
        label("name", self.name)
        paste = PastedObject(
            self.vehicle,
            self.distance,
            None,
            self.scan,
            self.fewest,
            self.rays_lost,
            self.where,
            self.laser,
        )
        object.__setattr__(self, "_paste", paste)
        object.__setattr__(self, "distance", paste.distance)

    def attack(self, instant: RecordedInstant, seed: Seed = 0) -> AttackedInstant | None:
        """See `InstantAttack.attack`: the attack's first instant."""
        begun = self.begin(instant, seed)
        return None if begun is None else begun.attack(instant, 0.0)

    def begin(self, instant: RecordedInstant, seed: Seed = 0) -> GhostOnItsWay | None:
        """See `LastingAttack.begin`."""
        placed = self._paste.placed(instant, seed)
        if placed is None:
            return None
        pose = instant.true_pose(placed.victim)
        speed = _speed(instant, placed.victim) if self.speed is None else self.speed
        ahead = pose[:2, 0] / np.hypot(*pose[:2, 0])
        return GhostOnItsWay(self._paste, placed, pose @ placed.pose, speed * ahead)


@dataclass(frozen=True, eq=False)
class GhostOnItsWay:
    """A ghost that has begun to move.

    Args:
        paste: The object that puts it into scans.
        begun: The ghost at its first instant.
        in_world: Its pose in the world then, shape (4, 4).
        velocity: Its velocity along the world's x and y, m/s, shape (2,).
    """

    paste: PastedObject
    begun: PlacedGhost
    in_world: Floats
    velocity: Floats

    def attack(self, instant: RecordedInstant, seconds: float) -> AttackedInstant | None:
        """See `AttackUnderWay.attack`; None where the victim has driven into it, or saw nothing."""
        victim, scan = self.begun.victim, self.begun.scan
        moved = self.in_world.copy()
        moved[:2, 3] += self.velocity * seconds
        pose = np.linalg.inv(instant.true_pose(victim)) @ moved
        x, y = pose[:2, 3].tolist()
        places = instant.scans[victim].compensated().points[:, :3].astype(np.float64)
        places = places[np.isfinite(places).all(axis=1)]
        places = places[(np.abs(places[:, :2]) < _REACH).all(axis=1)]
        if not len(places) or np.hypot(x, y) > _REACH:
            return None
        bottom = float(ground_map(places, _REACH).height(np.array([[x, y]]))[0])
        upright = upright_pose(x, y, bottom, float(np.arctan2(pose[1, 0], pose[0, 0])))
        # Over a low ghost, too, the victim has driven.
        if holds_lidar(upright, (_OVERHEAD, *scan.dimensions[1:])):
            return None
        return self.paste.paste(instant, PlacedGhost(victim, scan, upright))


def _speed(instant: RecordedInstant, vehicle: int) -> float:
    """A vehicle's speed, by the truth where there is one, else by its own odometry, m/s."""
    if instant.truth is not None:
        return instant.truth.vehicles[vehicle].speed
    return instant.scans[vehicle].sweep.speed
