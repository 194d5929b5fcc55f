"""`avsec world`: procedural data sets in KITTI's layouts, and digital twins of real frames."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError

if TYPE_CHECKING:
    from avsec_gym.world.export import Recipe


_MEANT = {
    "raw": ("drive_frames",),
    "connected": (
        "drive_frames",
        "vehicles",
        "spacing",
        "clocks_apart",
        "position_noise",
        "heading_noise",
        "roadside",
    ),
}
"""Options that belong to some suites only; all others have `--previous`."""


@dataclass(frozen=True)
class WorldMake:
    """Write a procedural data set: images, scans, labels, and the truth beside them.

    A run that was stopped goes on where it was; more --frames continue a data set.
    """

    suite: Literal["street", "highway", "mixed", "connected", "raw"]
    """Single frames on streets, highways, or both as in the labelled scenarios; several vehicles
    at the same instants; or drives of 10 frames each second."""
    out: Path
    """Folder of the data set: new, empty, or with the same data set."""
    frames: int = 100
    """How many; for `connected` instants, each seen by all vehicles."""
    seed: int = 0
    """Names the data set: same seed, same bytes."""
    assets: Literal["train", "judge", "all"] = "all"
    """Which part of the designs of vehicles, houses, plants, people and textures: that for
    training, that for judging, which share no design, or both."""
    workers: int | None = None
    """Number of processes; each takes about 1 GB.  Default: 2, or 1 on one processor."""
    cameras: tuple[int, ...] = ()
    """Numbers from 0 to 3.  Default: 2 and 3; all four for `raw`."""
    rig: tuple[float, ...] = ()
    """How far right of camera 0 each camera stands, metres, such as 0 0.54 -0.27 0.27.  Default:
    KITTI's."""
    width: int | None = None
    """Width of the images, pixels, such as a detector's own; the height follows. Default: 1242."""
    no_lidar: bool = False
    """Write no scans."""
    previous: int = 0
    """Frames 0.1 s apart before each frame, 0 to 3 (prev_2, ...; street, highway, mixed)."""
    sweep: Literal["instant", "rolling", "compensated"] | None = None
    """What scans do with the 0.1 s of a turn: nothing; each pulse at its own time, as in KITTI's
    raw data; or the same with the vehicle's own motion compensated.  Default: rolling for
    `connected` and `raw`, else instant."""
    drive_frames: int | None = None
    """Frames of a drive (raw, connected).  Default: 50; 1 for `connected`, whose instants then
    have a place of their own each."""
    vehicles: int = 3
    """The number of vehicles with sensors (connected)."""
    spacing: tuple[float, float] = (15.0, 60.0)
    """Least and greatest distance of the other vehicles from the first, metres: the nearer, the
    more objects are seen by two or more (connected)."""
    clocks_apart: float = 0.0
    """Longest time between the triggers of two vehicles, seconds, up to 0.1 (connected)."""
    position_noise: float = 0.2
    """Standard deviation of measured positions along x and along y, metres (connected)."""
    heading_noise: float = 0.2
    """Standard deviation of measured headings, degrees (connected)."""
    roadside: bool = False
    """A fixed LiDAR on a pole beside the road looks on, as one more witness (connected)."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.rig import camera_rig, kitti_rig, resized_rig
        from avsec_gym.world.assets import Assets
        from avsec_gym.world.export import Connection, Sensors, Sweep, suite_recipe

        rig = camera_rig(self.rig) if self.rig else kitti_rig()
        if self.width is not None:
            rig = resized_rig(rig, self.width)
        meant = _MEANT.get(self.suite, ("previous",))
        for name in dict.fromkeys(["previous", *_MEANT["raw"], *_MEANT["connected"]]):
            usual = type(self).__dataclass_fields__[name].default
            if getattr(self, name) != usual and name not in meant:
                option = "--" + name.replace("_", "-")
                raise ConfigurationError(f"{option} does not belong to --suite {self.suite}")
        sweep = None if self.sweep is None else Sweep(self.sweep)
        recipe = suite_recipe(
            self.suite,
            self.frames,
            self.seed,
            sensors=Sensors(self.cameras, not self.no_lidar, rig, sweep),
            previous=self.previous,
            vehicles=self.vehicles,
            drive_frames=self.drive_frames,
            connection=Connection(
                self.spacing, self.clocks_apart, self.position_noise, self.heading_noise
            ),
            assets=Assets(self.assets),
            roadside=self.roadside,
        )
        return _make(recipe, self.out, self.workers, "world.make" if self.json else None)


@dataclass(frozen=True)
class WorldTwin:
    """Render the very layout of real labelled frames: same objects, calibration and ids."""

    kitti: Path
    """Root of the KITTI object data (the folder that holds `training`)."""
    out: Path
    """Folder of the data set: new, empty, or with the same data set."""
    ids: tuple[str, ...] = ()
    """Frames, such as 000107 000274.  Default: all that have label and calibration."""
    split: str | None = None
    """The frames of ImageSets/SPLIT.txt, such as val, that have label and calibration."""
    limit: int | None = None
    """Only the first frames."""
    seed: int = 0
    """Seed of what labels leave open: looks, surroundings, light."""
    style: Literal["city", "residential", "campus", "highway", "rural"] | None = None
    """How the places are built up.  Default: drawn to suit each frame."""
    road_type: Literal["street", "highway"] | None = None
    """Road type of the places. Default: that of the style; street without one."""
    assets: Literal["train", "judge", "all"] = "all"
    """Which part of the designs of vehicles, houses, plants, people and textures: that for
    training, that for judging, which share no design, or both."""
    workers: int | None = None
    """Number of processes; each takes about 1 GB.  Default: 2, or 1 on one processor."""
    cameras: tuple[int, ...] = (2, 3)
    """Numbers from 0 to 3."""
    no_lidar: bool = False
    """Write no scans."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.road_type import RoadType
        from avsec_gym.world.assets import Assets
        from avsec_gym.world.export import Twins, twin_ids
        from avsec_gym.world.site import Style

        if self.limit is not None and self.limit < 1:
            raise ConfigurationError(f"--limit is 1 or more, got {self.limit}")
        if self.seed < 0:
            raise ConfigurationError(f"--seed is 0 or more, got {self.seed}")
        style = None if self.style is None else Style(self.style)
        road_type = self.road_type or (
            None if style is None else "highway" if style is Style.HIGHWAY else "street"
        )
        if style is not None and (style is Style.HIGHWAY) != (road_type == "highway"):
            raise ConfigurationError(f"--style {style} is no --road-type {road_type}")
        data = KittiObject(self.kitti)
        ids = twin_ids(data, self.ids, self.split)[: self.limit]
        recipe = Twins(
            self.kitti,
            ids,
            self.seed,
            style,
            None if road_type is None else RoadType(road_type),
            self.cameras,
            not self.no_lidar,
            Assets(self.assets),
        )
        return _make(recipe, self.out, self.workers, "world.twin" if self.json else None)


@dataclass(frozen=True)
class WorldVerify:
    """Compare a data set with its manifest."""

    root: Annotated[Path, tyro.conf.Positional]
    """Folder of the data set."""
    json: bool = False
    """Print JSON."""

    def run(self) -> int:
        """Do it; the exit code: 1 where a file is missing or changed."""
        from avsec_gym.storage.regular_files import is_there
        from avsec_gym.world.export import changed_files

        if not is_there(self.root):
            raise DataError("There is no such folder.", path=self.root, remedy="Check the path.")
        changed = changed_files(self.root, full=True)
        if self.json:
            console.print_json("world.verify", {"root": str(self.root), "changed": changed})
        for name in changed:
            console.say(f"missing or changed: {name}")
        if not changed and not self.json:
            console.say("every file agrees with the manifest")
        return console.BAD_DATA if changed else console.DONE


def _make(recipe: Recipe, out: Path, workers: int | None, schema: str | None) -> int:
    from avsec_gym.world.export import make_data_set

    begun = time.monotonic()
    with console.progress("rendering") as shown:
        report = make_data_set(recipe, out, workers=workers, on_progress=shown)
    seconds = time.monotonic() - begun
    for remark in report.remarks:
        console.say(f"note: {remark}")
    if schema is not None:
        summary = {
            "root": str(report.root),
            "frames": report.made + report.kept,
            "made": report.made,
            "kept": report.kept,
            "left_out": report.left_out,
            "seconds": round(seconds, 1),
            "remarks": list(report.remarks),
        }
        console.print_json(schema, summary)
    else:
        console.say(
            f"{report.root}: {report.made} frames made in {seconds:.0f} s, {report.kept} kept"
        )
    return console.DONE_IN_PART if report.left_out else console.DONE
