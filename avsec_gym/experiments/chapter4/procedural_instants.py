"""Instants of connected vehicles of the procedural world, scanned in memory.

`avsec world make --suite connected` writes the same instants to disk, with images, which no method
here looks at and which take nearly all of the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.settings import (
    FITTED,
    JUDGED,
    MOST_VEHICLES,
    ConnectedCondition,
    Part,
)
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Lidar, Sweep, renderer_of, scan_of
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import clock_offsets, instant_of, measured_pose, pose_errors
from avsec_gym.world.motion import later
from avsec_gym.world.posed_scenes import PosedScene

ASSETS: dict[Part, Assets] = {FITTED: Assets.TRAIN, JUDGED: Assets.JUDGE}
FIRST_SET: dict[Part, int] = {FITTED: 5000, JUDGED: 6000}
"""Number of the set of places that seed 0 has; the package's fit and model are of none of them."""


class ScannedPlace:
    """A place with its sensor vehicles, scanned once for each setting of their clocks.

    Args:
        seed: Seed of the run.
        part: `FITTED` or `JUDGED`, which share no place and no assets.
        number: Number of the place.
        vehicles: Number of vehicles with sensors.
    """

    def __init__(self, seed: int, part: Part, number: int, vehicles: int = MOST_VEHICLES) -> None:
        self._set, self._number, self._vehicles = FIRST_SET[part] + seed, number, vehicles
        [self.posed] = drive_scenes(self._set, number, 1, vehicles, assets=ASSETS[part])
        """What is there at the instant."""
        self._scanned: dict[tuple[float, int], OwnScan] = {}

    def instant(self, condition: ConnectedCondition) -> RecordedInstant:
        """The instant as the first vehicles of the place measure it.

        The errors of poses are the same draws under all conditions, scaled.

        Args:
            condition: Errors of poses, clocks, and the number of vehicles.
        """
        apart = condition.clocks_apart
        offsets = clock_offsets(self._set, self._number, self._vehicles, apart).tolist()
        own = [self._scan(apart, each, offsets[each]) for each in range(condition.vehicles)]
        exact = instant_of_scans(self.posed, own, offsets, self._number, 0, f"{self._number:06d}")
        scans = tuple(
            replace(scan, pose=self._measured(vehicle, scan.pose, condition))
            for vehicle, scan in enumerate(exact.scans)
        )
        return replace(exact, scans=scans)

    def _measured(self, vehicle: int, pose: Floats, condition: ConnectedCondition) -> Floats:
        error = pose_errors(self._set, self._number, vehicle, 1)[0]
        return measured_pose(pose, error, condition.noise, condition.noise)

    def _scan(self, apart: float, vehicle: int, seconds: float) -> OwnScan:
        """The scan of a vehicle, which conditions with the same clocks have in common."""
        if (apart, vehicle) not in self._scanned:
            self._scanned[apart, vehicle] = own_scan(self.posed, vehicle, seconds)
        return self._scanned[apart, vehicle]


@dataclass(frozen=True, eq=False)
class OwnScan:
    """What a vehicle's LiDAR sees.

    Args:
        points: The points, as `VehicleScan` has them.
        pose: The LiDAR's true pose when the vehicle looks, shape (4, 4).
        on_actors: The number of points on each actor.
    """

    points: NDArray[np.float32]
    pose: Floats
    on_actors: NDArray[np.int64]


def own_scan(posed: PosedScene, vehicle: int, seconds: float) -> OwnScan:
    """What a vehicle's LiDAR sees at its own time, of the world as it is then.

    Args:
        posed: What is there at the instant.
        vehicle: Number of the vehicle.
        seconds: When it looks after the instant.
    """
    seen = later(posed, seconds)
    scan = scan_of(seen, vehicle, Lidar(), Sweep.ROLLING, renderer_of(seen, vehicle))
    pose = seen.vehicle_to_world[vehicle] @ seen.rig.velodyne_pose
    return OwnScan(scan.points, pose, _counts(scan.object_id, len(posed.instant.actors)))


def scanned_instant(
    posed: PosedScene, offsets: Sequence[float], drive: int, frame: int, id: str
) -> RecordedInstant:
    """All vehicles' scans of an instant, with their true poses.

    Args:
        posed: What is there at the instant.
        offsets: When each vehicle looks after the instant, seconds, one for each vehicle.
        drive: Number of the drive, or of the place of an instant by itself.
        frame: Number of the instant in its drive.
        id: Name of the instant.
    """
    own = [own_scan(posed, vehicle, seconds) for vehicle, seconds in enumerate(offsets)]
    return instant_of_scans(posed, own, offsets, drive, frame, id)


def instant_of_scans(
    posed: PosedScene,
    own: Sequence[OwnScan],
    offsets: Sequence[float],
    drive: int,
    frame: int,
    id: str,
) -> RecordedInstant:
    """The instant of the first vehicles' scans, with their true poses.

    Args:
        posed: What is there at the instant.
        own: The scans of the first vehicles.
        offsets: When each vehicle looks, as for `scanned_instant`.
        drive: Number of the drive, or of the place of an instant by itself.
        frame: Number of the instant in its drive.
        id: Name of the instant.
    """
    actors = len(posed.instant.actors)
    # Who does not scan has no points on anything.
    points = [scan.on_actors for scan in own]
    points += [np.zeros(actors, np.int64) for _ in offsets[len(own) :]]
    truth = instant_of(posed.instant, drive, frame, offsets, points)
    scans = tuple(
        VehicleScan(scan.points, scan.pose, seconds, RollingSweep(truth.speed, truth.turn_rate))
        for scan, seconds, truth in zip(own, offsets, truth.vehicles, strict=False)
    )
    return RecordedInstant(id, scans, truth, tuple(scan.pose for scan in scans))


def _counts(object_id: NDArray[np.int32], actors: int) -> NDArray[np.int64]:
    """Number of points on each actor."""
    counts = np.bincount(object_id[object_id >= 0], minlength=actors)
    return counts.astype(np.int64)
