"""`avsec validate`: is a sensor of a recording attacked, and which one?"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from avsec_gym.commands import console
from avsec_gym.commands.judged_moments import JudgedMoments
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti.text_files import read_text

if TYPE_CHECKING:
    from avsec_gym.attacks.optical_attack import OpticalAttack
    from avsec_gym.sensor_system import Sensor, SensorSystem
    from avsec_gym.validation.evidence.pair_depth import PairDepth
    from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
    from avsec_gym.validation.moments import Moment, Recordings
    from avsec_gym.validation.threshold_validator import ThresholdValidator
    from avsec_gym.validation.validation_folder import ValidationFolder

_USUAL_OUT = Path("runs/validate")


@dataclass(frozen=True)
class Validate:
    """Let the sensors of a recording judge each other, moment by moment.

    A line for each moment, a picture for each alarm, a summary; what was stopped goes on.
    """

    kitti_raw: Path | None = None
    """A drive in KITTI's raw layout, a day of drives, or a folder of days; parts may be missing.
    Default: drives of the procedural world, made on first use."""
    kitti: Path | None = None
    """Instead: a folder in KITTI's object layout, with image_2, image_3 and velodyne."""
    sensors: tuple[str, ...] = ()
    """S_0 to S_n: lidar, if any, then cameras' numbers from right to left, the reference last.
    Default: those that --thresholds or --likelihood was made of, else all that see depth, but for
    those that few moments have."""
    thresholds: Path | None = None
    """A threshold table of such sensors, written by an earlier run to OUT/thresholds.json.
    Default: it is made from the first part of the recording, see --clean."""
    likelihood: Path | None = None
    """Instead of thresholds: a likelihood model, which gives a probability for each sensor."""
    fit_likelihood: bool = False
    """Instead of thresholds: make a likelihood model of the first part of the recording, see
    --clean, written to OUT/likelihood.json.  Each clean moment is attacked in every way."""
    clean: float = 0.25
    """Share of the moments, the first ones, that thresholds or likelihoods are made from: nobody
    may have attacked them.  They are not judged."""
    rate: float = 0.01
    """Designated false alarm rate r, from 0 to 1."""
    criterion: Literal["error", "any"] = "any"
    """What raises an alarm: the disparity error E alone, as in the thesis, or any of the four
    shares, each with a threshold of its own.  A likelihood always weighs all of them."""
    depth: str = "sgbm"
    """How disparities of two cameras are found: a name, or JSON with arguments."""
    attack: str | None = None
    """Attack the moments that are judged, to see whether it is noticed: JSON such as
    '{"name": "thesis", "sensors": ["lidar", 3]}' or '{"name": "facula", "camera": 3}'."""
    seed: int = 0
    """Of the attacks."""
    limit: int | None = None
    """Only the first moments."""
    out: Path | None = None
    """Folder for moments.jsonl, thresholds.json or likelihood.json, and pictures of alarms.
    Default: runs/validate, or runs/validate_2 and so on if that is of something else."""
    locate: bool = field(
        default=True,
        metadata={
            "help": "Do not look for the damage in the sensors that are named, which takes time."
        },
    )
    """Whether damage is looked for in the sensors that are named, with those that are sound."""
    json: bool = False
    """JSON lines instead of words, the summary last."""

    def run(self) -> int:
        """Do it; the exit code."""
        self._check()
        fitted = self._fitted()
        sensors = self._sensors if fitted is None else fitted.system.sensors
        recordings = self._recordings(sensors).first(self.limit)
        if recordings.remark:
            console.say(f"avsec: left out: {recordings.remark}")
        moments = recordings.moments
        clean = [] if fitted else moments[: max(1, round(self.clean * len(moments)))]
        judged = moments[len(clean) :]
        if not judged:
            raise ConfigurationError(
                f"of {len(moments)} moments none is left to be judged: lower --clean, raise "
                "--limit, or give --thresholds or --likelihood of an earlier run"
            )
        self._check_attack(recordings.system)
        folder = self._folder(recordings, len(clean))
        left_out = {id: f"it lacks {what}" for id, what in recordings.lacking.items()}
        validator = fitted or self._fit(folder.out, recordings, clean, left_out)
        for remark in (validator.remark, self._seen_before(validator, recordings, judged)):
            if remark:
                console.say(f"avsec: {remark}")
        said = JudgedMoments(
            judged, validator, folder, self._attack, self.seed, self.locate, self.json
        )
        said.judge(left_out)
        return said.report(left_out)

    def _check(self) -> None:
        for one, other in (
            ("kitti", "kitti_raw"),
            ("thresholds", "likelihood"),
            ("thresholds", "fit_likelihood"),
            ("likelihood", "fit_likelihood"),
        ):
            if getattr(self, one) and getattr(self, other):
                names = (name.replace("_", "-") for name in (one, other))
                raise ConfigurationError("--{} and --{}: give one".format(*names))
        if (self.likelihood or self.fit_likelihood) and self.criterion != "any":
            raise ConfigurationError("--criterion chooses among thresholds, not with likelihoods")
        for name, good in (
            ("clean", 0 < self.clean < 1),
            ("rate", 0 <= self.rate <= 1),
            ("limit", self.limit is None or self.limit >= 1),
            ("seed", self.seed >= 0),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        # What is mistyped is told before anything is measured.
        _ = self._attack, self._depth

    def _check_attack(self, system: SensorSystem) -> None:
        if self._attack is None:
            return
        judged, attacked = system.sensors, sorted(self._attack.sensors, key=str)
        if not attacked or not set(attacked) <= set(judged):
            names = " ".join(map(str, attacked)) or "nobody"
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

    @cached_property
    def _depth(self) -> PairDepth:
        from avsec_gym.validation.evidence.pair_depth import PairDepth

        what = named_part(self.depth, "--depth")
        return PairDepth(what) if isinstance(what, str) else PairDepth.from_settings(what)

    @property
    def _sensors(self) -> tuple[Sensor, ...]:
        return tuple(int(one) if one.isdigit() else one for one in self.sensors)

    def _fitted(self) -> ThresholdValidator | LikelihoodValidator | None:
        """Of an earlier run."""
        from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
        from avsec_gym.validation.threshold_validator import ThresholdValidator

        file = self.thresholds or self.likelihood
        if file is None:
            return None
        validator: ThresholdValidator | LikelihoodValidator
        if self.thresholds is not None:
            validator = ThresholdValidator(file, self.rate, self.criterion)
        else:
            validator = LikelihoodValidator(file, self.rate)
        fitted_on = validator.system.sensors
        if self._sensors not in ((), fitted_on):
            fitted, asked = (" ".join(map(str, one)) for one in (fitted_on, self._sensors))
            raise ConfigurationError(
                f"{file} was fitted on the sensors {fitted}, not {asked}: leave --sensors out, or "
                "name a file of these; without any, one is made from the first moments"
            )
        return validator

    def _recordings(self, sensors: Sequence[Sensor]) -> Recordings:
        from avsec_gym.validation.moments import object_recordings, raw_recordings
        from avsec_gym.world.export import default_suite

        if self.kitti is not None:
            return object_recordings(self.kitti, sensors or None)
        return raw_recordings(self.kitti_raw or default_suite("raw"), sensors or None)

    def _folder(self, recordings: Recordings, clean: int) -> ValidationFolder:
        from avsec_gym.validation.fitted_on import FORMAT
        from avsec_gym.validation.validation_folder import ValidationFolder, differences

        place = self.kitti or self.kitti_raw
        record = {
            "format": FORMAT,
            "recording": "default suite raw" if place is None else str(place.resolve()),
            "sensors": list(recordings.system.sensors),
            "clean_moments": clean,
            "rate": self.rate,
            "criterion": self.criterion,
            "depth": None if self.thresholds or self.likelihood else self._depth.settings,
            "attack": self.attack and named_part(self.attack, "--attack"),
            "seed": self.seed,
            "locate": self.locate,
        }
        if self.fit_likelihood:
            record["fit_likelihood"] = True
        for name in ("thresholds", "likelihood"):
            file = getattr(self, name)
            if file is not None:
                record[name] = hashlib.sha256(read_text(file).encode()).hexdigest()
        if self.out is not None:
            return ValidationFolder(self.out, record)
        for number in count(1):
            out = _USUAL_OUT.with_name(_USUAL_OUT.name + (f"_{number}" if number > 1 else ""))
            if not differences(out, record):
                break
        return ValidationFolder(out, record)

    def _fit(
        self, out: Path, recordings: Recordings, clean: Sequence[Moment], left_out: dict[str, str]
    ) -> ThresholdValidator | LikelihoodValidator:
        """On the first moments."""
        from avsec_gym.commands.clean_moments import CleanMoments
        from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
        from avsec_gym.validation.threshold_validator import ThresholdValidator
        from avsec_gym.validation.validation_folder import LIKELIHOOD, SAMPLES, THRESHOLDS

        own = CleanMoments(clean, recordings.system, self._depth, recordings.root)
        if self.fit_likelihood:
            left_out |= own.likelihood(out / LIKELIHOOD, out / SAMPLES, self.seed)
            return LikelihoodValidator(out / LIKELIHOOD, self.rate)
        left_out |= own.thresholds(out / THRESHOLDS, out / SAMPLES)
        return ThresholdValidator(out / THRESHOLDS, self.rate, self.criterion)

    def _seen_before(
        self,
        validator: ThresholdValidator | LikelihoodValidator,
        recordings: Recordings,
        judged: Sequence[Moment],
    ) -> str:
        """Where a file of an earlier run was made of moments that it is to judge; or nothing."""
        from avsec_gym.commands.clean_moments import fitted_among

        both = fitted_among(validator.on.data, recordings.root, judged)
        if not both:
            return ""
        return (
            f"{both} of the {len(judged)} moments were among those that "
            f"{self.thresholds or self.likelihood} was made of: that they raise no alarm says "
            "little"
        )
