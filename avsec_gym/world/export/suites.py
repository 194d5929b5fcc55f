"""The suites by name, and those of single frames: street, highway, mixed."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti.label_folders import frame_ids
from avsec_gym.road_type import RoadType
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.assets import Assets
from avsec_gym.world.capture import Sweep, render
from avsec_gym.world.earlier import earlier, plausible_ego_speed
from avsec_gym.world.export.connected import ConnectedVehicles, Connection
from avsec_gym.world.export.frame_files import write_object_files
from avsec_gym.world.export.raw_drives import RawDrives
from avsec_gym.world.export.recipe import Recipe, Sensors
from avsec_gym.world.export.scene_file import read_scene_file
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.motion import with_ego_speed
from avsec_gym.world.posed_scenes import posed_scene_of_layout

SUITES = ("street", "highway", "mixed", "connected", "raw")
"""Names of the suites."""
MOST_FRAMES = 1_000_000
"""Most frames of a suite: KITTI's ids of single frames have six digits."""

_AGAIN = "Remove the label file of its frame and run the command again: the frame is made anew."
_VALIDATION = 4
"""Every so manieth frame is for validation."""
_MOST_PREVIOUS = 3
_STEP = 0.1
_ROAD_TYPES = {"street": RoadType.STREET, "highway": RoadType.HIGHWAY, "mixed": None}


def suite_recipe(
    suite: str,
    frames: int,
    seed: int = 0,
    *,
    sensors: Sensors | None = None,
    previous: int = 0,
    vehicles: int = 3,
    drive_frames: int | None = None,
    connection: Connection | None = None,
    assets: Assets = Assets.ALL,
    roadside: bool = False,
) -> Recipe:
    """How to make a suite.

    Args:
        suite: Name of the suite, one of `SUITES`.
        frames: Number of frames, 1 to `MOST_FRAMES`; of instants where several vehicles look.
        seed: Seed of the set.
        sensors: The sensors that are written; KITTI's if None.
        previous: Number of earlier frames before each frame (street, highway, mixed).
        vehicles: Number of vehicles with sensors (connected).
        drive_frames: Number of frames of each drive (raw: 50 if None; connected: 1 if None, each
            instant at a place of its own).
        connection: How connected vehicles stand to one another, and what they know of it; as
            usual if None (connected).
        assets: The part of the assets that all places and actors are made of.
        roadside: Whether a fixed LiDAR beside the road looks on (connected).

    Raises:
        ConfigurationError: An unknown suite, or a number that cannot be.
    """
    sensors = sensors or Sensors()
    whole_number("frames", frames, 1, MOST_FRAMES)
    whole_number("seed", seed, 0)
    if suite == "raw":
        each = 50 if drive_frames is None else drive_frames
        return RawDrives(frames, seed, sensors, each, assets)
    if suite == "connected":
        each = 1 if drive_frames is None else drive_frames
        known = connection or Connection()
        return ConnectedVehicles(frames, seed, sensors, vehicles, each, known, assets, roadside)
    if suite in _ROAD_TYPES:
        return LayoutFrames(suite, frames, seed, sensors, previous, assets)
    raise ConfigurationError(f"{suite!r} is no suite; there are {', '.join(SUITES)}")


@dataclass(frozen=True, eq=False)
class LayoutFrames:
    """A frame for each layout of a set, in KITTI's object layout.

    Args:
        suite: Name of the suite: ``street``, ``highway`` or ``mixed``.
        count: Number of frames.
        seed: Seed of the set of layouts.
        sensors: The sensors that are written.
        previous: Number of earlier frames before each frame, 0 to 3.
        assets: The part of the assets that all places and actors are made of.

    Raises:
        ConfigurationError: Another number of earlier frames.
    """

    suite: str
    count: int
    seed: int = 0
    sensors: Sensors = field(default_factory=Sensors)
    previous: int = 0
    assets: Assets = Assets.ALL
    last_files: str = field(default="training/label_2/*.txt", init=False)

    def __post_init__(self) -> None:
        if not 0 <= self.previous <= _MOST_PREVIOUS:
            raise ConfigurationError(
                f"a frame has 0 to {_MOST_PREVIOUS} earlier frames, got {self.previous}"
            )

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return {
            "suite": self.suite,
            "seed": self.seed,
            "assets": str(self.assets),
            "previous": self.previous,
            **self.sensors.to_json(self._cameras, Sweep.INSTANT),
        }

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        """See `Recipe`."""
        return f"training/label_2/{number:06d}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        layout = generate_layout(number, _ROAD_TYPES[self.suite], set_seed=self.seed)
        posed = posed_scene_of_layout(layout, self.sensors.rig, self.assets)
        speed = plausible_ego_speed(posed)
        sweep = self.sensors.sweep or Sweep.INSTANT
        before = tuple(
            render(earlier(posed, _STEP * step, speed), cameras=self._cameras, lidar=None)
            for step in range(1, self.previous + 1)
        )
        write_object_files(
            root / "training",
            f"{number:06d}",
            posed,
            render(
                with_ego_speed(posed, speed),
                cameras=self._cameras,
                lidar=self.sensors.scanner,
                sweep=sweep,
            ),
            previous=before,
            notes={"layout": layout.id, "ego_speed": round(speed, 3)},
        )
        return []

    def finish(self, root: Path) -> None:
        """See `Recipe`."""
        write_lists(root)

    @property
    def _cameras(self) -> tuple[int, ...]:
        return self.sensors.or_usual(2, 3)


def write_lists(root: Path) -> None:
    """Write ``ImageSets`` and ``road_type.csv`` for the frames of an object layout."""
    training = root / "training"
    ids = frame_ids(training / "label_2", ".txt")
    validation = [id for id in ids if int(id) % _VALIDATION == _VALIDATION - 1]
    lists = {
        "train": [id for id in ids if id not in set(validation)],
        "val": validation,
        "trainval": ids,
    }
    for name, chosen in lists.items():
        text = "".join(f"{id}\n" for id in chosen)
        write_text(root / "ImageSets" / f"{name}.txt", text, overwrite=True)
    rows = ["img_name,label"]
    for id in ids:
        scene = training / "scene" / f"{id}.json"
        road_type = read_scene_file(scene, remedy=_AGAIN)["road_type"]
        rows.append(f"{id}.png,{int(road_type == RoadType.STREET)}")
    write_text(training / "road_type.csv", "\n".join(rows) + "\n", overwrite=True)
