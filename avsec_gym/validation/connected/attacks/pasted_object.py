"""`PastedObject`: the scan of a real vehicle, pasted into one vehicle's cloud (section 4.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, get_args

import numpy as np

from avsec_gym.argument_checks import (
    flag,
    label,
    number,
    number_range,
    one_of,
    shown,
    whole_number,
)
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.object_scan import ObjectScan, cut_out_points, read_object_scan
from avsec_gym.attacks.tampered_scan import holds_lidar, inject_object
from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, with_scan
from avsec_gym.validation.connected.attacks.chosen_places import (
    GhostArea,
    other_observers,
    place_in_path,
    telling_rays,
)
from avsec_gym.validation.connected.attacks.seen_objects import (
    SeenObject,
    box_in_world,
    points_in_box,
    seen_objects,
    upright_pose,
)
from avsec_gym.validation.connected.attacks.spoofing_lasers import LASERS
from avsec_gym.validation.connected.proposals.ground_map import ground_map
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_TRIES = 60
"""Places that are drawn before there is none."""
_ROOM = 0.5
"""Metres kept free around a ghost."""
_NEAREST, _REACH = 0.1, 60.0
"""Metres from the LiDAR at which a ghost may be asked for."""
_FEET = 0.4
"""Metres above a ghost's bottom: what is lower is the ground's, on slopes, too."""
_TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class PastedObject:
    """A ghost: what some vehicle scanned of a real object stands in the victim's scan elsewhere.

    It stands on free ground, and turned such that the sides that were scanned face the victim's
    LiDAR, as they must to be seen.  Free is where no vehicle's rays ended on anything and, where
    there are labels, no object stands, seen or not: what really stands there is no ghost.  A place
    is drawn anywhere, as in the thesis, or chosen to matter: in the victim's path, or where the
    rays of the others show least of it, of a dozen free places.

    Args:
        vehicle: Number of the victim; None: drawn.
        distance: Least and greatest distance from its LiDAR, metres.
        bearing: Bearing from its LiDAR, radians to the left of ahead; None: drawn.
        scan: The scan that is pasted, or a file that `write_object_scan` wrote; None: that of an
            object of the instant, drawn.
        fewest: Points of an object of the instant that is pasted.
        where: ``anywhere``, ``path`` or ``blind_spot``.
        laser: The limits of a spoofing laser as a paper has them, ``cao_2019`` or ``sun_2020``, see
            `avsec_gym.validation.connected.attacks.spoofing_lasers`; None: all points are placed.
        rays_lost: Whether the victim's rays that meet the ghost are lost; in the thesis points are
            added.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
        DataError: The file is missing or broken.
    """

    vehicle: int | None = None
    distance: tuple[float, float] = (6.0, 40.0)
    bearing: float | None = None
    scan: ObjectScan | str | Path | None = None
    fewest: int = 50
    rays_lost: bool = False
    where: GhostArea = "anywhere"
    laser: str | None = None
    name: str = "paste"
    _scan: ObjectScan | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_vehicle(self.vehicle)
        distance = number_range("distance", self.distance, _NEAREST, _REACH, may_be_one=True)
        object.__setattr__(self, "distance", distance)
        if self.bearing is not None:
            object.__setattr__(self, "bearing", number("bearing", self.bearing, -_TURN, _TURN))
        whole_number("fewest", self.fewest, 1)
        flag("rays_lost", self.rays_lost)
        one_of("where", self.where, get_args(GhostArea))
        if self.laser is not None:
            one_of("laser", self.laser, tuple(LASERS))
        if self.bearing is not None and self.where != "anywhere":
            raise ConfigurationError(f"a bearing is for where='anywhere', not for {self.where!r}")
        label("name", self.name)
        given = self.scan
        if not isinstance(given, ObjectScan | str | Path | None):
            raise ConfigurationError(f"scan takes a file or an ObjectScan, got {shown(given)}")
        read = read_object_scan(given) if isinstance(given, str | Path) else given
        object.__setattr__(self, "_scan", read)

    def attack(self, instant: RecordedInstant, seed: Seed = 0) -> AttackedInstant | None:
        """See `InstantAttack.attack`."""
        placed = self.placed(instant, seed)
        return None if placed is None else self.paste(instant, placed)

    def placed(self, instant: RecordedInstant, seed: Seed = 0) -> PlacedGhost | None:
        """What would be pasted, and where; None where this instant offers nothing.

        Args:
            instant: What all vehicles scanned.
            seed: The seed of all that is drawn.
        """
        random = np.random.default_rng(seed)
        victim = drawn_vehicle(instant, self.vehicle, random)
        pasted = self._scan or _scan_of_some_object(instant, self.fewest, random)
        if pasted is None:
            return None
        pose = self._place(instant, victim, pasted, random)
        return None if pose is None else PlacedGhost(victim, pasted, pose)

    def paste(self, instant: RecordedInstant, placed: PlacedGhost) -> AttackedInstant:
        """An instant with the ghost, as far as the laser can place it.

        Args:
            instant: What all vehicles scanned.
            placed: The ghost, with its pose in the victim's frame at this instant.

        Raises:
            ConfigurationError: The LiDAR would be inside of the ghost.
        """
        scan, pasted = instant.scans[placed.victim], placed.scan
        tampered = inject_object(
            scan.compensated().points, pasted, placed.pose, rays_lost=self.rays_lost
        )
        bogus = tampered.points[tampered.bogus]
        if self.laser is not None:
            bogus = LASERS[self.laser].placeable(bogus)
        # It stands still: each of its points is where the head finds it.
        bogus[:, :3] = scan.sweep.rolled(bogus[:, :3].astype(np.float64))
        points = np.concatenate([scan.points[~tampered.lost], bogus])
        box = box_in_world(placed.pose, pasted.dimensions, instant.true_pose(placed.victim))
        attacked = with_scan(instant, placed.victim, points)
        return AttackedInstant(attacked, placed.victim, "ghost", box, len(bogus))

    def _place(
        self,
        instant: RecordedInstant,
        victim: int,
        pasted: ObjectScan,
        random: np.random.Generator,
    ) -> Floats | None:
        """A free place on the ground; None where there is none."""
        scan = instant.scans[victim]
        free = self._free_places(instant, victim, pasted, random)
        if self.where != "blind_spot":
            return next(free, None)
        others, pose = other_observers(instant, victim), instant.true_pose(victim)

        def telling(place: Floats) -> int:
            box = box_in_world(place, pasted.dimensions, pose)
            ghost = transform_points(place, pasted.points[:, :3].astype(np.float64))
            return telling_rays(others, ghost, box, pose, scan.time)

        # Of equal ones the first that was drawn.
        return min(islice(free, _CANDIDATES), key=telling, default=None)

    def _free_places(
        self,
        instant: RecordedInstant,
        victim: int,
        pasted: ObjectScan,
        random: np.random.Generator,
    ) -> Iterator[Floats]:
        """Poses on free ground in the victim's frame, as they are drawn, shape (4, 4) each."""
        scan, lidars = instant.scans[victim], _lidars(instant, victim)
        places = [
            _within_reach(each, lidar) for each, lidar in zip(instant.scans, lidars, strict=True)
        ]
        if not len(places[victim]):
            return
        ground = ground_map(places[victim], _REACH)
        # With labels, those are objects that the victim does not see, too.
        taken = [_rectangle(each, _ROOM) for each in seen_objects(instant, victim, fewest=0)]
        for _ in range(_TRIES):
            distance, turned = random.uniform(*self.distance), random.uniform(-np.pi, np.pi)
            bearing = turned if self.bearing is None else self.bearing
            x, y = distance * np.cos(bearing), distance * np.sin(bearing)
            if self.where == "path":
                x, y = place_in_path(scan.sweep, distance)
                bearing = np.arctan2(y, x)
            facing = bearing + np.pi - np.arctan2(pasted.seen_from[1], pasted.seen_from[0])
            bottom = float(ground.height(np.array([[x, y]]))[0])
            pose = upright_pose(x, y, bottom, facing)
            ghost = SeenObject(pose, pasted.dimensions, 0)
            near = np.array(taken).reshape(-1, 5)
            if rectangle_iou(_rectangle(ghost)[None], near).any():
                continue
            if any(holds_lidar(np.linalg.inv(lidar) @ pose, pasted.dimensions) for lidar in lidars):
                continue
            # Few returns of any vehicle above the ground: bushes and walls are no place for one.
            if all(
                points_in_box(each, pose, pasted.dimensions, feet=_FEET) <= _FEW for each in places
            ):
                yield pose


@dataclass(frozen=True, eq=False)
class PlacedGhost:
    """What is pasted, and where.

    Args:
        victim: Number of the victim.
        scan: The scan that is pasted.
        pose: The transform from the ghost's own frame to the victim's velodyne frame, shape (4, 4).
    """

    victim: int
    scan: ObjectScan
    pose: Floats


_CANDIDATES = 12
"""Free places of which the one is chosen that the others' rays show least of."""
_FEW = 3
"""So many stray returns of each vehicle may be where a ghost is put."""


def _lidars(instant: RecordedInstant, victim: int) -> list[Floats]:
    """Poses of all LiDARs in the victim's velodyne frame, by number, shape (4, 4) each."""
    to_victim = np.linalg.inv(instant.true_pose(victim))
    return [to_victim @ instant.true_pose(number) for number in range(len(instant.scans))]


def _within_reach(scan: VehicleScan, lidar: Floats) -> Floats:
    """A scan's returns around the victim, in its velodyne frame, metres, shape (M, 3).

    Args:
        scan: The scan.
        lidar: Pose of its LiDAR in that frame, shape (4, 4).
    """
    places = scan.compensated().points[:, :3].astype(np.float64)
    places = transform_points(lidar, places[np.isfinite(places).all(axis=1)])
    return np.ascontiguousarray(places[(np.abs(places[:, :2]) < _REACH).all(axis=1)])


def check_vehicle(vehicle: Any) -> None:
    """Check what was given as the number of a victim, before there are vehicles.

    Raises:
        ConfigurationError: It is no number of a vehicle.
    """
    if vehicle is not None:
        whole_number("vehicle", vehicle, 0)


def drawn_vehicle(
    instant: RecordedInstant, vehicle: int | None, random: np.random.Generator
) -> int:
    """The victim.

    Raises:
        ConfigurationError: There is no such vehicle.
    """
    drawn = int(random.integers(len(instant.scans)))
    if vehicle is not None and not 0 <= vehicle < len(instant.scans):
        raise ConfigurationError(
            f"there is no vehicle {vehicle} at {instant.id}, but 0 to {len(instant.scans) - 1}"
        )
    return drawn if vehicle is None else vehicle


def pasteable_scans(instant: RecordedInstant, most: int = 8, fewest: int = 50) -> list[ObjectScan]:
    """What the vehicles of an instant have on objects of the size of cars, most points first.

    Args:
        instant: What all vehicles scanned.
        most: Number of scans.
        fewest: Points of each.
    """
    found = sorted(_objects_to_paste(instant, fewest), key=lambda each: -each[1].points)
    scans = [_cut(scan, chosen) for scan, chosen in found[:most]]
    return [each for each in scans if each is not None]


def _scan_of_some_object(
    instant: RecordedInstant, fewest: int, random: np.random.Generator
) -> ObjectScan | None:
    """What some vehicle, the victim too, has on an object of the size of a car."""
    found = _objects_to_paste(instant, fewest)
    return _cut(*found[int(random.integers(len(found)))]) if found else None


def _objects_to_paste(
    instant: RecordedInstant, fewest: int
) -> list[tuple[VehicleScan, SeenObject]]:
    return [
        (instant.scans[vehicle], each)
        for vehicle in range(len(instant.scans))
        for each in seen_objects(instant, vehicle, fewest)
        if _SHORTEST <= each.dimensions[2] <= _LONGEST and each.distance > 3.0
    ]


def _cut(scan: VehicleScan, chosen: SeenObject) -> ObjectScan | None:
    return cut_out_points(
        scan.compensated().points,
        np.asarray(np.linalg.inv(chosen.pose)),
        chosen.dimensions,
        feet=0.1,
    )


_SHORTEST, _LONGEST = 3.0, 7.0
"""Metres: cars and vans, of which scans are cut out."""


def _rectangle(seen: SeenObject, margin: float = 0.0) -> Floats:
    """x, y, length, width, heading from above, shape (5,)."""
    _, width, length = seen.dimensions
    heading = np.arctan2(seen.pose[1, 0], seen.pose[0, 0])
    return np.array([*seen.pose[:2, 3], length + 2 * margin, width + 2 * margin, heading])
