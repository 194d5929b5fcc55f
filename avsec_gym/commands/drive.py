"""`avsec drive`: sets of scenes in closed loop, under several settings side by side."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_folder, is_there

if TYPE_CHECKING:
    from avsec_gym.drives.drive_folder import DriveFolder
    from avsec_gym.drives.one_drive import DriveTask
    from avsec_gym.drives.setting import DriveSetting

_USUAL_OUT = Path("runs/drive")
_LAYOUTS, _DRIVES = "layouts", "drives"
_USUAL_COUNT = {_LAYOUTS: 30, _DRIVES: 10}


@dataclass(frozen=True)
class DriveInTraffic:
    """Drive on in traffic, by what the car believes, under several settings side by side.

    The planner replans every half second from where the car really is. Without options:
    procedural drives, by a car that knows the truth and by one that sees nothing. Prints a table;
    writes a row and a film for each drive, and a page with film strips of what went wrong.
    """

    scenarios: str | None = None
    """Which scenes: `drives` (procedural, the world's own road, with sensors), `layouts`
    (procedural, straight lanes), a folder of labelled scenarios, of KITTI labels or of CommonRoad
    files; or JSON with arguments, such as '{"source": "kitti_tracking", "root": FOLDER}'.  Default:
    drives."""
    ids: tuple[str, ...] = ()
    """Only these scenes, by their ids."""
    limit: int | None = None
    """Only the first scenes.  Default: 30 layouts, 10 drives, all of a folder."""
    intention: Literal["straight", "left", "right", "all"] = "straight"
    """Where to go; all: each way that a scene has a lane for."""
    settings: tuple[str, ...] = ()
    """What the car is: truth, blind, error-model, lidar, stereo (with their usual detectors),
    detector, attacked, defended; or JSON with a
    name and arguments of avsec/ClosedLoop-v0, such as '{"name": "far", "perception": "blind"}', and
    a driver of its own, such as '{"name": "follower", "perception": "truth", "driver": "idm"}'.
    Default: truth and blind, and those that the options below are for."""
    detector: str | None = None
    """Detector of the settings detector, attacked and defended: a name, or JSON with arguments.
    Default: the environment's."""
    attack: str | None = None
    """The attack of the settings attacked and defended, likewise."""
    validator: str | None = None
    """Validator of the setting defended, likewise."""
    classifier: str | None = None
    """Classifier of the cars with sensors: finds what moves; likewise."""
    selector: str | None = None
    """Selector of the cars with sensors: finds the road's type; likewise."""
    response: Literal["stop", "drop", "repair"] = "stop"
    """Response of the setting defended: what the car does at an alarm."""
    handover: float | None = None
    """Seconds that the car of the setting defended stands by alarms until a human takes over, and
    the drive ends.  Default: it stands there until the time is over."""
    error_model: tuple[str, ...] = ()
    """Error model of the setting error-model: a file of `avsec error-model fit`, or the name of a
    shipped one, such as stereo_rcnn. Of several, each is a setting of its own name."""
    planner: str = "astar"
    """Planner of all settings: a name, or JSON with arguments."""
    driver: str = "planner"
    """Who drives in all settings: planner, or idm, highway-env's own (IDM, and MOBIL for the lane
    change that the intention asks for); or JSON: '{"name": "planner", "replanning": 0.2}'."""
    motion: Literal["truth", "static", "classifier"] = "truth"
    """Motion of all settings: how the planner takes believed objects to move.  Cars with a
    classifier take them as that one answers."""
    traffic: str = "recorded"
    """What others do: `recorded`, they play their tracks; `reacting`, vehicles in a lane are driven
    by highway-env's IDM; or JSON: '{"name": "reacting", "share": 0.5}', a share of these, or
    '{"name": "reacting", "ids": [3, 7]}', actors by their ids."""
    duration: float = 8.0
    """Seconds that a drive takes at most."""
    people: bool = field(default=True, metadata={"help": "Without pedestrians and cyclists."})
    """Whether pedestrians and cyclists are there."""
    seed: int = 0
    """Seed of the scenes, of what is drawn in them, and of attacks."""
    out: Path | None = None
    """Folder of the results: new or empty, or see --resume.  Default: runs/drive, or
    runs/drive_2 and so on if there is something."""
    resume: bool = False
    """Go on with the same drives where they were stopped; where all that are there are others, that
    is an error, and where there are none they begin."""
    jobs: int = 1
    """Number of processes; the results are the same."""
    pictures: int = 20
    """Most scenes with a bad end that the page shows as film strips, with what the left camera
    showed where a car has one; 0: no strips, no clip. Images of all drives are kept, some 0.3 MB
    for each with the planner; with 0 none are, and a drive that was made so has none later."""
    video: Literal["gif", "mp4"] = "gif"
    """The clip of the most telling scene; mp4 needs the extra `video`."""
    rrd: bool = False
    """Also write that scene as a recording for Rerun (extra `rerun`)."""
    json: bool = False
    """Print the summary as JSON instead of a table."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.closed_loop.recorded.sources import KITTI_RAW, KITTI_TRACKING
        from avsec_gym.commands.drive_results import PAGE, DrivePictures, write_drive_results
        from avsec_gym.commands.drive_table import drive_report, print_settings, steps_per_second
        from avsec_gym.drives.driving import make_drives
        from avsec_gym.drives.summary import by_recording, by_scene, summaries
        from avsec_gym.storage.folder_lock import locked_folder

        self._check()
        settings = self._settings()
        scenarios = self._scenarios()
        # All settings are made once, so that what cannot work is refused before anything is done.
        environments = [setting.environment(scenarios) for setting in settings]
        tasks = self._tasks(environments[0], settings)
        record = self._record(scenarios, settings)
        out = self._out(record)
        with locked_folder(out), console.progress("driving") as shown:
            folder = self._folder(out, record)
            make_drives(
                tasks, settings, scenarios, folder,
                jobs=self.jobs, views=self.pictures > 0, on_progress=shown,
            )  # fmt: skip
            recorded = scenarios.get("source") in (KITTI_TRACKING, KITTI_RAW)
            names = [setting.name for setting in settings]
            cluster = by_recording if recorded else by_scene
            summary = summaries(folder.rows.values(), names, cluster)
            pictures = DrivePictures(self.pictures, self.video, self.rrd)
            write_drive_results(folder, summary, record, pictures)
        speeds = steps_per_second(folder, summary)
        if self.json:
            console.print_json("drive", drive_report(out, summary, speeds))
        else:
            print_settings(summary, speeds)
            console.say(f"avsec: {out / PAGE} shows the drives, {out} holds them")
        return console.DONE

    def _check(self) -> None:
        for name, good in (
            ("limit", self.limit is None or self.limit >= 1),
            ("seed", self.seed >= 0),
            ("jobs", self.jobs >= 1),
            ("pictures", self.pictures >= 0),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        if self.ids and self.limit is not None:
            raise ConfigurationError("--ids and --limit: give one")
        if self.out is not None and is_there(self.out) and not is_folder(self.out):
            raise DataError("This is a file.", path=self.out, remedy="Name a folder with --out.")
        if self.video == "mp4":
            from avsec_gym.drawing.video import check_video

            check_video()
        if self.rrd:
            from avsec_gym.drawing.rerun_stream import check_rerun

            check_rerun()

    def _settings(self) -> list[DriveSetting]:
        from avsec_gym.commands.drive_settings import DriveParts
        from avsec_gym.commands.named_part import named_part

        named = {
            name: named_part(text, f"--{name}")
            for name in ("detector", "attack", "validator", "classifier", "selector", "planner")
            if (text := getattr(self, name)) is not None
        }
        sensing: dict[str, Any] = {
            name: part for name, part in named.items() if name in ("classifier", "selector")
        }
        if self.validator is not None:
            sensing["response"] = self.response
        elif self.response != type(self).response:
            raise ConfigurationError("--response belongs to --validator")
        own = {} if self.handover is None else {"handover": self.handover}
        shared = {
            "planner": named["planner"],
            "motion": self.motion,
            "traffic": named_part(self.traffic, "--traffic"),
            "duration": self.duration,
            "driver": named_part(self.driver, "--driver"),
        }
        parts = DriveParts(
            named.get("detector"),
            named.get("attack"),
            named.get("validator"),
            self.error_model,
            sensing,
            shared,
            own,
        )
        return parts.settings(self.settings)

    def _scenarios(self) -> Any:
        """The scenes as the environment takes them."""
        from avsec_gym.commands.named_part import named_part

        given = named_part(self.scenarios or _DRIVES, "--scenarios")
        arguments = given if isinstance(given, dict) else {"source": given}
        arguments = {"seed": self.seed, "people": self.people, **arguments}
        number = self.limit
        if number is None and not self.ids:
            number = _USUAL_COUNT.get(str(arguments.get("source")))
        return arguments if number is None else {"count": number, **arguments}

    def _tasks(self, environment: Any, settings: list[DriveSetting]) -> list[DriveTask]:
        """Scene after scene, all settings of each; the seed is the same under every setting."""
        from avsec_gym.drives.one_drive import DriveTask

        scenes = environment.unwrapped.scenes
        ways: list[tuple[str, str]] = []
        with console.progress("looking at scenes") as shown:
            wanted = self.ids or scenes.ids
            for number, id in enumerate(wanted, start=1):
                if self.ids or self.intention != "straight":
                    there = [str(each) for each in scenes.scene(id).intentions]
                else:
                    there = ["straight"]
                own = there if self.intention == "all" else [self.intention]
                ways += [(id, way) for way in own if way in there]
                shown(number, len(wanted))
        if not ways:
            raise ConfigurationError(
                f"no scene has a lane for the intention {self.intention}: name another --intention"
            )
        return [
            DriveTask(setting.name, id, way, self.seed + number)
            for number, (id, way) in enumerate(ways)
            for setting in settings
        ]

    def _record(self, scenarios: Any, settings: list[DriveSetting]) -> dict[str, Any]:
        """Everything that decides the results."""
        from avsec_gym import __version__
        from avsec_gym.closed_loop.error_model.shipped import error_model_file
        from avsec_gym.closed_loop.loop_scenes import NAMED
        from avsec_gym.commands.named_files import named_files
        from avsec_gym.storage.regular_files import read_bytes
        from avsec_gym.world.assets import Assets

        record: dict[str, Any] = {
            "version": __version__,
            "scenarios": scenarios,
            "ids": list(self.ids),
            "intention": self.intention,
            "seed": self.seed,
            "settings": {setting.name: setting.record for setting in settings},
        }
        if self.error_model:
            files = [error_model_file(model) for model in self.error_model]
            contents = b"".join(read_bytes(file, most=2**30) for file in files)
            record["error_model"] = hashlib.sha256(contents).hexdigest()
        # A source or part of its own name is no folder that happens to be called so, too.
        own = (*NAMED, *Assets)
        places = {name: value for name, value in scenarios.items() if value not in own}
        if named := named_files([places, record["settings"]]):
            record["files"] = named
        return record

    def _out(self, record: dict[str, Any]) -> Path:
        """The folder that was named, or the first that is free, or that is to be gone on with.

        Raises:
            DataError: Drives are to be gone on with, and all that are there are others.
        """
        from avsec_gym.drives.drive_folder import differences, has_drives

        if self.out is not None:
            return self.out
        others: list[str] = []
        for number in count(1):
            out = _USUAL_OUT.with_name(_USUAL_OUT.name + (f"_{number}" if number > 1 else ""))
            if not has_drives(out):
                break
            newest, others = out, differences(out, record) if self.resume else []
            if self.resume and not others:
                break
        if others:
            raise DataError(
                f"The newest drives are others: {'; '.join(others)}.",
                path=newest,
                remedy="Give the options that they were begun with, or begin new ones without "
                "--resume.",
            )
        return out

    def _folder(self, out: Path, record: dict[str, Any]) -> DriveFolder:
        from avsec_gym.drives.drive_folder import DriveFolder, has_drives

        if has_drives(out) and not self.resume:
            raise DataError(
                "There are drives here already.",
                path=out,
                remedy="Go on with the same ones by --resume, or name another --out.",
            )
        return DriveFolder(out, record)
