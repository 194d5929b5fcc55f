"""`avsec validate`: is a sensor of a recording attacked, and which one?"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym.commands import console
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.text_files import read_text, write_text

if TYPE_CHECKING:
    from avsec_gym.frame import SensorFrame
    from avsec_gym.sensor_system import Sensor, SensorSystem
    from avsec_gym.validation.moments import Moment, Recordings
    from avsec_gym.validation.validation_folder import ValidationFolder
    from avsec_gym.validation.validator import Validator

_REMARKS = 5
"""So many moments left out are told one by one."""
_RATES = {
    "alarms without an attack": "alarms_without_attack",
    "attacks noticed": "attacks_noticed",
    "attacked sensors named exactly": "attacks_named",
}


@dataclass(frozen=True)
class Validate:
    """Let the sensors of a recording judge each other, moment by moment.

    A line for each moment, a picture for each alarm, a summary; what was stopped goes on.
    """

    kitti_raw: Path | None = None
    """A drive in KITTI's raw layout, a day of drives, or a folder of days; any part may lack.
    Default: drives of the procedural world, made on first use."""
    kitti: Path | None = None
    """Instead: a folder in KITTI's object layout, with image_2, image_3 and velodyne."""
    sensors: tuple[str, ...] = ()
    """S_0 to S_n: lidar, if any, then cameras' numbers from right to left, the reference last.
    Default: all that are there and see depth."""
    thresholds: Path | None = None
    """A threshold table of such sensors, written by an earlier run to OUT/thresholds.json.
    Default: it is made from the first part of the recording, see --clean."""
    likelihood: Path | None = None
    """Instead of thresholds: a likelihood model, which gives a probability for each sensor."""
    clean: float = 0.25
    """Share of the moments, the first ones, that thresholds are made from: nobody may have
    attacked them.  They are not judged."""
    rate: float = 0.01
    """Designated false alarm rate r, from 0 to 1."""
    criterion: Literal["error", "any"] = "any"
    """What raises an alarm: the disparity error E alone, as in the thesis, or any of the four
    shares, each with a threshold of its own.  The likelihood always weighs all of them."""
    depth: str = "sgbm"
    """How disparities of two cameras are found: a name, or JSON with arguments."""
    attack: str | None = None
    """Attack the moments that are judged, to see whether it is noticed: JSON such as
    '{"name": "thesis", "sensors": ["lidar", 3]}' or '{"name": "facula", "camera": 3}'."""
    seed: int = 0
    """Of the attack."""
    limit: int | None = None
    """Only the first moments."""
    out: Path = Path("runs/validate")
    """Folder for moments.jsonl, thresholds.json and pictures of alarms."""
    json: bool = False
    """JSON lines instead of words, the summary last."""

    def run(self) -> int:
        """Do it; the exit code."""
        self._check()
        recordings = self._recordings()
        moments = recordings.moments[: self.limit]
        clean = [] if self._is_fitted else moments[: max(1, round(self.clean * len(moments)))]
        judged = moments[len(clean) :]
        if not judged:
            raise ConfigurationError(
                f"of {len(moments)} moments none is left to be judged: lower --clean, raise "
                "--limit, or give --thresholds of an earlier run"
            )
        folder = self._folder(recordings, len(clean))
        skipped = dict(recordings.lacking)
        validator = self._validator(folder, recordings, clean, skipped)
        self._judge(folder, validator, judged, skipped)
        return self._report(folder, skipped)

    def _check(self) -> None:
        for one, other in (("kitti", "kitti_raw"), ("thresholds", "likelihood")):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise ConfigurationError(f"--{one} and --{other.replace('_', '-')}: give one")
        if self.likelihood is not None and self.criterion != "any":
            raise ConfigurationError("--criterion chooses among thresholds: not with --likelihood")
        for name, good in (
            ("clean", 0 < self.clean < 1),
            ("rate", 0 <= self.rate <= 1),
            ("limit", self.limit is None or self.limit >= 1),
            ("seed", self.seed >= 0),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")

    @property
    def _is_fitted(self) -> bool:
        return self.thresholds is not None or self.likelihood is not None

    def _recordings(self) -> Recordings:
        from avsec_gym.validation.moments import object_recordings, raw_recordings
        from avsec_gym.world.export import default_suite

        sensors = [_sensor(text) for text in self.sensors] or None
        if self.kitti is not None:
            return object_recordings(self.kitti, sensors)
        return raw_recordings(self.kitti_raw or default_suite("raw"), sensors)

    def _folder(self, recordings: Recordings, clean: int) -> ValidationFolder:
        from avsec_gym.validation.validation_folder import ValidationFolder

        place = self.kitti or self.kitti_raw
        record = {
            "recording": "default suite raw" if place is None else str(place.resolve()),
            "sensors": list(recordings.system.sensors),
            "clean_moments": clean,
            "rate": self.rate,
            "criterion": self.criterion,
            "depth": None if self._is_fitted else self.depth,
            "attack": self.attack,
            "seed": self.seed,
        }
        for name in ("thresholds", "likelihood"):
            file = getattr(self, name)
            if file is not None:
                record[name] = hashlib.sha256(read_text(file).encode()).hexdigest()
        return ValidationFolder(self.out, record)

    def _validator(
        self,
        folder: ValidationFolder,
        recordings: Recordings,
        clean: Sequence[Moment],
        skipped: dict[str, str],
    ) -> Validator:
        from avsec_gym.validation.likelihood_validator import LikelihoodValidator
        from avsec_gym.validation.pair_depth import PairDepth
        from avsec_gym.validation.threshold_validator import ThresholdValidator
        from avsec_gym.validation.thresholds import measured_thresholds
        from avsec_gym.validation.validation_folder import THRESHOLDS

        if self.likelihood is not None:
            return LikelihoodValidator(self.likelihood, self.rate)
        system, own = recordings.system, folder.out / THRESHOLDS
        if self.thresholds is None and not own.exists():
            frames = (
                frame for _, frame in _frames(clean, system, "measuring clean moments", skipped)
            )
            depth = PairDepth(named_part(self.depth, "--depth"))
            data = {"first": clean[0].id, "last": clean[-1].id, "moments": len(clean)}
            measured_thresholds(frames, system, depth, data).write(own)
        if clean and 0 < len(clean) * self.rate < 1:
            console.say(
                f"avsec: {len(clean)} clean moments are few for r = {self.rate}: thresholds are "
                "their largest errors, as for r = 0"
            )
        return ThresholdValidator(self.thresholds or own, self.rate, self.criterion)

    def _judge(
        self,
        folder: ValidationFolder,
        validator: Validator,
        judged: Sequence[Moment],
        skipped: dict[str, str],
    ) -> None:
        from avsec_gym.attacks.optical_attack import TamperedFrame
        from avsec_gym.registry import Kind, make
        from avsec_gym.report.validation_picture import save_validation_picture
        from avsec_gym.validation.validation_folder import row_of

        attack = self.attack and make(Kind.OPTICAL_ATTACK, named_part(self.attack, "--attack"))
        for row in folder.rows.values():
            self._tell(row)
        left = [moment for moment in judged if moment.id not in folder.rows]
        for moment, frame in _frames(left, validator.system, "validating", skipped):
            number = judged.index(moment)
            tampered = attack.attack(frame, (self.seed, number)) if attack else TamperedFrame(frame)
            begun = time.perf_counter()
            validation = validator.validate(tampered.frame)
            row = row_of(moment.id, validation, tampered.attacked, time.perf_counter() - begun)
            if validation.alarm:
                name = moment.id.replace("/", "_")
                save_validation_picture(validation, folder.out / "alarms" / f"{name}.png")
            folder.add(row)
            self._tell(row)

    def _tell(self, row: Mapping[str, Any]) -> None:
        from avsec_gym.report.validation_picture import named

        if self.json:
            console.print_json_line(row)
            return
        largest = max(row["errors"].values(), default=0.0)
        said = "sound"
        if row["alarm"]:
            names = ", ".join(map(named, row["attacked"])) or "some sensor, which one is open"
            said = f"ALARM: {names}"
        console.print_line(
            f"{row['id']}  {said}  (largest E {largest:.3f}, {row['seconds']:.2f} s)"
        )

    def _report(self, folder: ValidationFolder, skipped: Mapping[str, str]) -> int:
        from avsec_gym.validation.validation_folder import summary

        for id, reason in list(skipped.items())[:_REMARKS]:
            console.say(f"avsec: left out: {id}: {reason}")
        if len(skipped) > _REMARKS:
            console.say(f"avsec: left out: {len(skipped) - _REMARKS} more moments")
        found = summary(folder.rows)
        found["left_out"] = len(skipped)
        write_text(folder.out / "summary.json", json.dumps(found, indent=1) + "\n", overwrite=True)
        if self.json:
            console.print_json_line({"summary": found})
        else:
            rows = [
                [
                    title,
                    f"{one['count']} of {one['of']}",
                    console.percent(one["rate"], one["interval"]),
                ]
                for title, key in _RATES.items()
                if (one := found[key])["of"]
            ]
            console.print_table(
                f"{found['moments']} moments, {found['alarms']} alarms; {folder.out}",
                ["", "moments", "% (95 %)"],
                rows,
            )
        return console.DONE_IN_PART if skipped else console.DONE


def _frames(
    moments: Sequence[Moment], system: SensorSystem, what: str, skipped: dict[str, str]
) -> Iterator[tuple[Moment, SensorFrame]]:
    """Read one after the other, with progress; what is broken is left out."""
    with console.progress(what) as shown:
        for done, moment in enumerate(moments, start=1):
            try:
                frame = moment.frame()
                for camera in system.cameras:
                    frame.image(camera)
                if system.has_lidar:
                    _ = frame.points
            except DataError as error:
                skipped[moment.id] = str(error)
            else:
                yield moment, frame
            shown(done, len(moments))


def _sensor(text: str) -> Sensor:
    return int(text) if text.isdigit() else text
