"""`avsec validate`: is a sensor of a recording attacked, and which one?"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from avsec_gym import console
from avsec_gym.commands.fit_choice import FitChoice
from avsec_gym.commands.fit_remarks import origin, remarks
from avsec_gym.commands.judged_frames import JudgedFrames
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError
from avsec_gym.storage.text_files import read_text

if TYPE_CHECKING:
    from avsec_gym.attacks.optical_attack import OpticalAttack
    from avsec_gym.commands.judged_by import JudgedBy
    from avsec_gym.sensor_system import Sensor, SensorSystem
    from avsec_gym.validation.recordings import Recordings
    from avsec_gym.validation.validation_folder import ValidationFolder

_USUAL_OUT = Path("runs/validate")
_PARTS = ("validator", "depth", "attack")
"""Entries of the record that may name files."""


@dataclass(frozen=True)
class Validate:
    """Check the sensors of a recording against each other, frame by frame.

    A line for each frame, a picture for each alarm, a summary; what was stopped goes on, and a
    frame that has changed since is judged again.
    """

    kitti_raw: Path | None = None
    """A drive in KITTI's raw layout, a day of drives, or a folder of days; or the tracking or the
    odometry benchmark.  Parts may be missing.  Default: drives of the procedural world, made on
    first use."""
    kitti: Path | None = None
    """Instead: a folder in KITTI's object layout, with image_2, image_3 and velodyne."""
    sensors: tuple[str, ...] = ()
    """S_0 to S_n: lidar, if any, then cameras' numbers from right to left, the reference last.
    Default: those that --thresholds or --likelihood was made of, else all that see depth, but for
    those that few frames have."""
    ids: tuple[str, ...] = ()
    """Only these frames, such as 000107, or 2011_09_26_drive_0052_sync/0000000005 where there are
    several drives.  Each has its picture, alarm or not."""
    thresholds: Path | None = None
    """A threshold table of such sensors, written by an earlier run to OUT/thresholds.json; or the
    word shipped, for the package's own.  Default: see --clean."""
    likelihood: Path | None = None
    """Instead of thresholds: a likelihood model, which gives a probability for each sensor; or the
    word shipped, for the package's own."""
    validator: str | None = None
    """Instead of thresholds: any validator by its name, one of a plug-in's too, or JSON with
    arguments.  --rate, --criterion and --depth then have no meaning."""
    fit_likelihood: bool = False
    """Instead of thresholds: make a likelihood model of the first part of the recording, see
    --clean, written to OUT/likelihood.json.  Each clean frame is attacked in every way."""
    clean: float | None = None
    """Share of the frames, the first ones, that thresholds or likelihoods are made from: they must
    be without an attack.  They are not judged.  Default: 0.25 where these are 1 / r frames or
    more; else none, if the package ships thresholds of such sensors, fitted on procedural drives of
    KITTI's rig; else 0.25."""
    rate: float = 0.01
    """Designated false alarm rate r, from 0 to 1."""
    criterion: Literal["error", "any"] = "any"
    """What raises an alarm: the disparity error E alone, as in the thesis, or any of the four
    shares, each with a threshold of its own.  A likelihood always weighs all of them."""
    depth: str = "sgbm"
    """How disparities of two cameras are found: a name, or JSON with arguments."""
    attack: str | None = None
    """Attack the frames that are judged, to see whether it is detected: JSON such as
    '{"name": "thesis", "sensors": ["lidar", 3]}' or '{"name": "facula", "camera": 3}'."""
    seed: int = 0
    """Seed of the attacks."""
    limit: int | None = None
    """Only the first frames."""
    out: Path | None = None
    """Folder for frames.jsonl, thresholds.json or likelihood.json, and pictures of alarms.
    Default: runs/validate, or runs/validate_2 and so on if that is of something else."""
    locate: bool = field(
        default=True,
        metadata={
            "help": "Do not look for the damage in the sensors that are named, which takes time."
        },
    )
    """Whether damage is looked for in the sensors that are named, with those that are sound."""
    rrd: bool = False
    """Also write, beside each picture, a recording for the Rerun viewer (extra `rerun`): images,
    scan and damage in space."""
    json: bool = False
    """JSON lines instead of words, the summary last."""

    def run(self) -> int:
        """Do it; the exit code."""
        self._check()
        choice = self._choice
        named = choice.named(self._sensors)
        recordings = self._recordings(self._sensors if named is None else named.system.sensors)
        recordings = recordings.first(self.limit)
        if recordings.remark:
            console.say(f"avsec: left out: {recordings.remark}")
        self._check_attack(recordings.system)
        by = choice.judged_by(recordings, self.ids, is_named=named is not None)
        with self._locked(recordings, by) as folder:
            # Where frames are named, what others lack does not matter.
            lacking = {} if self.ids else recordings.lacking
            left_out = {id: f"it lacks {what}" for id, what in lacking.items()}
            if named is None:
                fitted = choice.fitted(by, recordings, folder.out)
                left_out |= fitted.on.data.get("left_out", {})
            validator = named or fitted
            decides = origin(validator)
            for remark in (
                by.remark,
                *remarks(validator, choice.file, recordings.root, by.judged),
                decides and f"what decides here was {decides}",
            ):
                if remark:
                    console.say(f"avsec: {remark}")
            judged = JudgedFrames(
                by.judged,
                validator,
                folder,
                self._attack,
                self.seed,
                self.locate,
                self.json,
                decides,
                bool(self.ids),
                self.rrd,
            )
            judged.judge(left_out)
            return judged.report(left_out)

    def _check(self) -> None:
        if self.rrd:
            from avsec_gym.drawing.rerun_stream import check_rerun

            check_rerun()
        # Options that exclude each other.
        for one, other in (
            ("kitti", "kitti_raw"),
            ("thresholds", "likelihood"),
            ("thresholds", "fit_likelihood"),
            ("likelihood", "fit_likelihood"),
            ("validator", "thresholds"),
            ("validator", "likelihood"),
            ("validator", "fit_likelihood"),
            ("validator", "clean"),
            ("ids", "limit"),
        ):
            if getattr(self, one) and getattr(self, other):
                names = (name.replace("_", "-") for name in (one, other))
                raise ConfigurationError("--{} and --{}: give one".format(*names))
        for name in ("rate", "criterion", "depth"):
            usual = Validate.__dataclass_fields__[name].default
            if self.validator is not None and getattr(self, name) != usual:
                raise ConfigurationError(
                    f"--{name} is none of --validator's: it takes its arguments as JSON"
                )
        if (self.likelihood or self.fit_likelihood) and self.criterion != "any":
            raise ConfigurationError("--criterion chooses among thresholds, not with likelihoods")
        # Numbers out of their ranges.
        for name, good in (
            ("clean", self.clean is None or 0 < self.clean < 1),
            ("rate", 0 <= self.rate <= 1),
            ("limit", self.limit is None or self.limit >= 1),
            ("seed", self.seed >= 0),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        if self.clean is not None and (self.thresholds or self.likelihood):
            raise ConfigurationError(
                "--clean states what is fitted on, --thresholds and --likelihood that something is "
                "fitted already: give one"
            )
        # A mistyped name is an error before anything is measured.
        _ = self._attack, self._choice.pair_depth

    def _check_attack(self, system: SensorSystem) -> None:
        if self._attack is None:
            return
        judged, attacked = system.sensors, sorted(self._attack.sensors, key=str)
        if not attacked or not set(attacked) <= set(judged):
            names = " ".join(map(str, attacked)) or "no sensor"
            raise ConfigurationError(
                f"--attack attacks {names}; the sensors {' '.join(map(str, judged))} are judged:"
                " attack some of these, or ask for others with --sensors"
            )

    @cached_property
    def _attack(self) -> OpticalAttack | None:
        from avsec_gym.registry import Kind, make

        if self.attack is None:
            return None
        attack: OpticalAttack = make(Kind.OPTICAL_ATTACK, named_part(self.attack, "--attack"))
        return attack

    @property
    def _sensors(self) -> tuple[Sensor, ...]:
        return tuple(int(sensor) if sensor.isdecimal() else sensor for sensor in self.sensors)

    @cached_property
    def _choice(self) -> FitChoice:
        return FitChoice(
            self.thresholds,
            self.likelihood,
            self.validator,
            self.fit_likelihood,
            self.clean,
            self.rate,
            self.criterion,
            self.depth,
            self.seed,
        )

    def _recordings(self, sensors: Sequence[Sensor]) -> Recordings:
        from avsec_gym.validation.recordings import object_recordings, raw_recordings
        from avsec_gym.world.export import default_suite

        if self.kitti is not None:
            return object_recordings(self.kitti, sensors or None)
        return raw_recordings(self.kitti_raw or default_suite("raw"), sensors or None)

    @contextmanager
    def _locked(self, recordings: Recordings, by: JudgedBy) -> Iterator[ValidationFolder]:
        """The folder of the results, which no other process writes meanwhile."""
        from avsec_gym import __version__
        from avsec_gym.commands.named_files import named_files
        from avsec_gym.commands.recorded_stamps import frame_stamps
        from avsec_gym.storage.folder_lock import locked_folder
        from avsec_gym.validation.fitted_on import FORMAT
        from avsec_gym.validation.validation_folder import ValidationFolder, usual_folder

        place = self.kitti or self.kitti_raw
        # The name of a default suite's folder has the fingerprint of the world.
        record = {
            "format": FORMAT,
            "version": __version__,
            "recording": f"default suite {recordings.root.name}"
            if place is None
            else str(place.resolve()),
            "sensors": list(recordings.system.sensors),
            "clean_frames": len(by.clean),
            "rate": self.rate,
            "criterion": self.criterion,
            "depth": None
            if self.thresholds or self.likelihood or self.validator
            else self._choice.pair_depth.settings,
            "attack": self.attack and named_part(self.attack, "--attack"),
            "seed": self.seed,
            "locate": self.locate,
        }
        if by.clean:
            stamps = "".join(frame_stamps(by.clean, recordings.system).values())
            record["clean_recorded"] = hashlib.sha256(stamps.encode()).hexdigest()
        if self.fit_likelihood:
            record["fit_likelihood"] = True
        if self.validator is not None:
            record["validator"] = named_part(self.validator, "--validator")
        if self.ids:
            record["ids"] = [recorded.id for recorded in by.judged]
        for name in ("thresholds", "likelihood"):
            file = getattr(self, name)
            if file is not None and not self._choice.shipped:
                record[name] = hashlib.sha256(read_text(file).encode()).hexdigest()
        if by.shipped is not None:
            record["shipped"] = hashlib.sha256(read_text(by.shipped).encode()).hexdigest()
        if files := named_files([record[name] for name in _PARTS if name in record]):
            record["files"] = files
        with locked_folder(self.out or usual_folder(_USUAL_OUT, record)) as out:
            yield ValidationFolder(out, record)
