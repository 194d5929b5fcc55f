"""Several connected vehicles at the same instants: an object layout for each, one truth for all."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, Integers
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.actors import Instant
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Scan, Sweep, render
from avsec_gym.world.drives import MOST_DRIVE_FRAMES, DriveScenes, drive_scenes
from avsec_gym.world.export.connected_world import ConnectedWorld, write_meetings
from avsec_gym.world.export.frame_files import write_object_files
from avsec_gym.world.export.instants import instant_of, write_instant
from avsec_gym.world.export.measured_poses import clock_offsets, measured_pose, pose_errors
from avsec_gym.world.export.recipe import Sensors
from avsec_gym.world.motion import later, motion_of
from avsec_gym.world.roadside_lidar import roadside_pose, roadside_scan
from avsec_gym.world.traffic.egos import EGO_SPACING

MOST_VEHICLES = 100
"""Most vehicles at one instant."""
_LONGEST_APART = 0.1
"""Seconds between two vehicles' triggers: a sensor's period."""


@dataclass(frozen=True)
class Connection:
    """How connected vehicles stand to one another, and what they know of it.

    Args:
        spacing: Least and greatest distance of the other vehicles from the first, metres: the
            nearer, the more objects are seen by two or more.
        clocks_apart: Longest time between two vehicles' triggers, seconds, at most 0.1.
        position_noise: Standard deviation of measured positions along x and along y, metres.
        heading_noise: Standard deviation of measured headings, degrees.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    spacing: tuple[float, float] = EGO_SPACING
    clocks_apart: float = 0.0
    position_noise: float = 0.2
    heading_noise: float = 0.2

    def __post_init__(self) -> None:
        least, most = self.spacing
        if not (least >= 5.0 and least + 5.0 <= most <= 100.0):
            raise ConfigurationError(
                "vehicles stand 5 to 100 m apart, with a range of 5 m or more, such as 15 60; got "
                f"{least:g} {most:g}"
            )
        if not 0.0 <= self.clocks_apart <= _LONGEST_APART:
            raise ConfigurationError(
                f"clocks are 0 to {_LONGEST_APART} s apart, got {self.clocks_apart:g}"
            )
        if not (0.0 <= self.position_noise <= 10.0 and 0.0 <= self.heading_noise <= 20.0):
            raise ConfigurationError(
                "poses have noise of 0 to 10 m and 0 to 20 degrees, got "
                f"{self.position_noise:g} and {self.heading_noise:g}"
            )


@dataclass(frozen=True, eq=False)
class ConnectedVehicles:
    """Instants; equal ids of ``vehicle_0``, ... are one instant.

    Args:
        count: Number of instants.
        seed: Seed of the set.
        sensors: The sensors of every vehicle.
        vehicles: Number of vehicles, 2 to `MOST_VEHICLES`.
        drive_frames: Number of successive instants, 0.1 s apart, at each place; with 1, each
            instant has a place of its own.
        connection: How the vehicles stand to one another, and what they know of it.
        assets: The part of the assets that all places and actors are made of.
        roadside: Whether a fixed LiDAR on a pole beside the road looks on, as ``vehicle_N`` after
            the vehicles, without images and labels; it knows its own pose.  All other files are
            what they are without it.

    Raises:
        ConfigurationError: Another number of vehicles, or of instants at a place; a LiDAR beside
            the road where no scans are written.
    """

    count: int
    seed: int = 0
    sensors: Sensors = field(default_factory=Sensors)
    vehicles: int = 3
    drive_frames: int = 1
    connection: Connection = Connection()
    assets: Assets = Assets.ALL
    roadside: bool = False

    def __post_init__(self) -> None:
        if self.roadside and not self.sensors.lidar:
            raise ConfigurationError("a LiDAR beside the road writes scans: it needs LiDARs")
        whole_number("vehicles", self.vehicles, 2, MOST_VEHICLES)
        whole_number("drive_frames", self.drive_frames, 1, MOST_DRIVE_FRAMES)

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return {
            "suite": "connected",
            "seed": self.seed,
            "assets": str(self.assets),
            "vehicles": self.vehicles,
            "drive_frames": self.drive_frames,
            **asdict(self.connection) | {"spacing": list(self.connection.spacing)},
            **self.sensors.to_json(self._cameras, Sweep.ROLLING),
            # Data sets without it have the manifests that they always had.
            **({"roadside": True} if self.roadside else {}),
        }

    @property
    def last_files(self) -> str:
        """See `Recipe`."""
        return f"vehicle_{self.vehicles - 1}/training/label_2/*.txt"

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        """See `Recipe`: of the last vehicle."""
        return f"vehicle_{self.vehicles - 1}/training/label_2/{number:06d}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        drive, frame = divmod(number, self.drive_frames)
        connection, sensors = self.connection, self.sensors
        spacing = connection.spacing
        scenes = drive_scenes(
            self.seed, drive, self.drive_frames, self.vehicles, sensors.rig, spacing, self.assets
        )
        posed, id = scenes[frame], f"{number:06d}"
        instant = posed.instant
        # Each vehicle looks at its own time, at the world as it is then.
        looking = self.vehicles + self.roadside
        offsets = clock_offsets(self.seed, drive, looking, connection.clocks_apart).tolist()
        beside = [self._look_on(root, id, scenes, frame, offsets[-1])] if self.roadside else []
        points: list[Integers] = []
        for vehicle, own in enumerate(instant.egos):
            seen = later(posed, offsets[vehicle])
            sweep = sensors.sweep or Sweep.ROLLING
            capture = render(
                seen, ego=vehicle, cameras=self._cameras, lidar=sensors.scanner, sweep=sweep
            )
            points.append(_points_on(instant, capture.scan))
            # True and measured pose of its velodyne.
            folder = root / f"vehicle_{vehicle}" / "training"
            pose = seen.vehicle_to_world[vehicle] @ seen.rig.velodyne_pose
            error = pose_errors(self.seed, drive, vehicle, frame + 1)[frame]
            noise = (connection.position_noise, connection.heading_noise)
            _write_pose(folder / "pose" / f"{id}.txt", pose)
            measured = measured_pose(pose, error, *noise)
            _write_pose(folder / "measured_pose" / f"{id}.txt", measured)
            # The truth of all comes before the last vehicle's label, which ends the instant.
            if vehicle == self.vehicles - 1:
                truth = instant_of(instant, drive, frame, offsets, [*points, *beside])
                write_instant(root / "objects" / f"{id}.json", truth)
            notes = {
                "actor": int(instant.actors.id[own]),
                "ego_speed": round(float(instant.actors.speed[own]), 3),
                "ego_turn_rate": round(motion_of(instant, own).turn_rate, 6),
                "time": round(0.1 * frame + offsets[vehicle], 4),
                "sweep": str(sweep),
            }
            write_object_files(folder, id, seen, capture, notes=notes)
        return []

    def _look_on(
        self, root: Path, id: str, scenes: DriveScenes, frame: int, offset: float
    ) -> Integers:
        """Write what the LiDAR beside the road scans; its number of points on each actor."""
        posed, pose = scenes[frame], roadside_pose(scenes.world)
        lidar = self.sensors.scanner
        assert lidar is not None, "a LiDAR beside the road comes with LiDARs"
        scan = roadside_scan(later(posed, offset), pose, lidar, self.sensors.sweep or Sweep.ROLLING)
        folder = root / f"vehicle_{self.vehicles}" / "training"
        for name in ("pose", "measured_pose"):
            _write_pose(folder / name / f"{id}.txt", pose)
        seen = SensorFrame(id, posed.rig.calibration, {}, scan.points)
        write_object_frame(folder, seen, overwrite=True)
        return _points_on(posed.instant, scan)

    def finish(self, root: Path) -> None:
        """See `Recipe`: how much the vehicles see of the same objects."""
        if self.sensors.lidar:
            write_meetings(root, ConnectedWorld(root))

    @property
    def _cameras(self) -> tuple[int, ...]:
        return self.sensors.or_usual(2, 3)


def _points_on(instant: Instant, scan: Scan | None) -> Integers:
    """Number of points of a scan on each actor, shape (N,)."""
    ids = np.zeros(0, int) if scan is None else scan.object_id
    return np.bincount(ids[ids >= 0], minlength=len(instant.actors)).astype(np.int64)


def _write_pose(path: Path, pose: Floats) -> None:
    words = " ".join(repr(value) for value in np.round(pose[:3], 9).ravel().tolist())
    write_text(path, words + "\n", overwrite=True)
