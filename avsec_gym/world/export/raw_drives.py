"""Drives in KITTI's raw layout, and beside them the truth that KITTI lacks."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import read_labels, write_labels
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.raw import VELODYNE
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.timestamps import write_timestamps
from avsec_gym.kitti.writing import write_drive_records, write_raw_frame
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Sweep, render
from avsec_gym.world.drives import MOST_DRIVE_FRAMES, STEP, DriveScenes, drive_scenes
from avsec_gym.world.export.frame_files import label_lines, write_truth
from avsec_gym.world.export.recipe import Sensors
from avsec_gym.world.export.scene_file import actors_of, read_scene_file
from avsec_gym.world.export.tracks import Sighting, tracklets_of

DATE = "2026_01_01"
"""Date of all drives."""

_NOON = np.datetime64("2026-01-01T12:00", "ns")
_AGAIN = "Remove the label file of its frame and run the command again: the frame is made anew."
_BETWEEN_DRIVES = np.timedelta64(10, "m")


@dataclass(frozen=True, eq=False)
class RawDrives:
    """Drives of one ego vehicle, 10 frames each second.

    Args:
        count: Number of frames; the last drive has what is left.
        seed: Seed of the set.
        sensors: The sensors that are written.
        drive_frames: Number of frames of each drive, 1 to `MOST_DRIVE_FRAMES`.
        assets: The part of the assets that all places and actors are made of.

    Raises:
        ConfigurationError: Another number of frames in a drive, or a rig without inertial unit.
    """

    count: int
    seed: int = 0
    sensors: Sensors = field(default_factory=Sensors)
    drive_frames: int = 50
    assets: Assets = Assets.ALL
    last_files: str = field(default=f"{DATE}/*/label_02/data/*.txt", init=False)

    def __post_init__(self) -> None:
        whole_number("drive_frames", self.drive_frames, 1, MOST_DRIVE_FRAMES)
        _ = self.sensors.rig.imu_pose  # Refuses a rig without.

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return {
            "suite": "raw",
            "seed": self.seed,
            "assets": str(self.assets),
            "drive_frames": self.drive_frames,
            **self.sensors.to_json(self._cameras, Sweep.ROLLING),
        }

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        """See `Recipe`."""
        drive, frame = divmod(number, self.drive_frames)
        return f"{DATE}/{_name(drive)}/label_02/data/{frame:010d}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        drive, frame = divmod(number, self.drive_frames)
        folder = root / DATE / _name(drive)
        posed = self._scenes(drive)[frame]
        sweep = self.sensors.sweep or Sweep.ROLLING
        scanner = self.sensors.scanner
        capture = render(posed, cameras=self._cameras, lidar=scanner, sweep=sweep)
        scan = None if capture.scan is None else capture.scan.points
        sensed = SensorFrame(f"{frame:010d}", posed.rig.calibration, capture.images, scan)
        write_raw_frame(folder, frame, sensed, overwrite=True)

        def place(kind: str, suffix: str) -> Path:
            return folder / f"{kind}_02" / "data" / f"{frame:010d}{suffix}"

        labels, speed = label_lines(capture), float(posed.instant.actors.speed[0])
        write_truth(place, labels, posed, capture, {"ego_speed": round(speed, 3)})
        write_labels(place("label", ".txt"), labels, overwrite=True)
        return []

    def finish(self, root: Path) -> None:
        """See `Recipe`: calibration, and what belongs to each drive as a whole."""
        rig = self.sensors.rig
        write_raw_calibration(root / DATE, rig.calibration, image_size=rig.size, overwrite=True)
        for folder in sorted((root / DATE).glob("*_sync")):
            drive = int(folder.name.split("_")[-2]) - 1
            self._finish_drive(folder, drive)

    def _finish_drive(self, folder: Path, drive: int) -> None:
        scenes = self._scenes(drive)
        labels = sorted((folder / "label_02" / "data").glob("*.txt"))
        sightings = {int(path.stem): _sightings(folder, path) for path in labels}
        count = max(sightings) + 1
        imu = scenes.world.ego_poses[:, 0] @ scenes.rig.imu_pose
        times = _NOON + drive * _BETWEEN_DRIVES + _nanoseconds(STEP) * np.arange(count)
        sensors = ["oxts", *(f"image_{camera:02d}" for camera in self._cameras)]
        write_drive_records(
            folder,
            # Rates at the last frame shall not depend on where an unfinished drive ends.
            oxts=oxts_from_poses(imu, period=STEP)[:count],
            timestamps=dict.fromkeys(sensors, times),
            tracklets=tracklets_of(scenes, sightings),
            overwrite=True,
        )
        if self.sensors.lidar:
            turn = _nanoseconds(0.5 * STEP)
            for end, shift in (("", 0 * turn), ("_start", -turn), ("_end", turn)):
                path = folder / VELODYNE / f"timestamps{end}.txt"
                write_timestamps(path, times + shift, overwrite=True)

    def _scenes(self, drive: int) -> DriveScenes:
        return drive_scenes(
            self.seed, drive, self.drive_frames, rig=self.sensors.rig, assets=self.assets
        )

    @property
    def _cameras(self) -> tuple[int, ...]:
        return self.sensors.or_usual(0, 1, 2, 3)


def _name(drive: int) -> str:
    return f"{DATE}_drive_{drive + 1:04d}_sync"


def _nanoseconds(seconds: float) -> np.timedelta64:
    return np.timedelta64(round(seconds * 1e9), "ns")


def _sightings(folder: Path, path: Path) -> list[Sighting]:
    """Who is labelled in a frame, from its label and scene files."""
    boxes = read_labels(path)
    place = folder / "scene_02" / "data" / f"{path.stem}.json"
    actors = actors_of(read_scene_file(place, remedy=_AGAIN))
    if actors is None or len(actors) != len(boxes):
        raise DataError("The scene is not that of the labels.", path=place, remedy=_AGAIN)
    assert boxes.occlusion is not None, "labels have it"
    assert boxes.truncation is not None, "labels have it"
    return [
        Sighting(actor, int(occlusion), float(truncation))
        for actor, occlusion, truncation in zip(
            actors, boxes.occlusion, boxes.truncation, strict=True
        )
    ]
