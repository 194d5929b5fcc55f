"""Which validator `avsec validate` judges by: a named one, a file, a shipped fit, or one made here.

A recording with 1 / r clean frames or more is judged by a fit on these; one with fewer by what the
package ships, if that is of such a rig.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from avsec_gym import console
from avsec_gym.commands.fit_remarks import clean_data
from avsec_gym.commands.judged_by import (
    USUAL_SHARE,
    JudgedBy,
    judged_by_clean,
    judged_by_enough,
    judged_by_shipped,
)
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError
from avsec_gym.storage.regular_files import is_there

if TYPE_CHECKING:
    from avsec_gym.sensor_system import Sensor
    from avsec_gym.validation.evidence.pair_depth import PairDepth
    from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
    from avsec_gym.validation.recordings import Recordings
    from avsec_gym.validation.shipped import FitKind
    from avsec_gym.validation.threshold_validator import ThresholdValidator
    from avsec_gym.validation.validator import Validator


@dataclass(frozen=True)
class FitChoice:
    """What the options state of the fit; see `Validate` for each of them.

    Args:
        thresholds: A file, or ``shipped``.
        likelihood: A file, or ``shipped``.
        validator: Name or JSON of any validator.
        fit_likelihood: Whether a likelihood model is fitted to clean frames, not thresholds.
        clean: Share of the frames that are clean; None: see `judged_by_enough`.
        rate: Designated false positive rate r.
        criterion: What raises an alarm of thresholds.
        depth: Name or JSON of the depth estimator.
        seed: Seed of the attacks on clean frames.
    """

    thresholds: Path | None
    likelihood: Path | None
    validator: str | None
    fit_likelihood: bool
    clean: float | None
    rate: float
    criterion: Literal["error", "any"]
    depth: str
    seed: int

    @property
    def file(self) -> Path | None:
        """File or ``shipped``, as it is named."""
        return self.thresholds or self.likelihood

    @property
    def shipped(self) -> FitKind | None:
        """Which of the package's own fits is named, by its word in place of a file."""
        from avsec_gym.validation.shipped import SHIPPED

        if str(self.thresholds) == SHIPPED:
            return "thresholds"
        return "likelihood" if str(self.likelihood) == SHIPPED else None

    @cached_property
    def pair_depth(self) -> PairDepth:
        """How disparities of two cameras are found.

        Raises:
            ConfigurationError: The name or the JSON is mistyped.
        """
        from avsec_gym.validation.evidence.pair_depth import PairDepth

        what = named_part(self.depth, "--depth")
        return PairDepth(what) if isinstance(what, str) else PairDepth.from_settings(what)

    def named(self, sensors: Sequence[Sensor]) -> Validator | None:
        """The validator that is named, or that a file of an earlier run holds; None: neither.

        Args:
            sensors: The sensors that the validator must judge; empty: any.

        Raises:
            ConfigurationError: It is no validator, or judges other sensors.
            DataError: The file is missing or broken.
        """
        validator: Validator
        if self.validator is not None:
            validator = _any_validator(self.validator)
            whose, remedy = f"the validator {validator.name} judges", "ask for these"
        elif self.file is not None and not self.shipped:
            validator = self._read(self.file, is_likelihood=self.thresholds is None)
            whose = f"{self.file} was fitted on"
            remedy = "name a file of these; without any, one is made from the first frames"
        else:
            return None
        judged = validator.system.sensors
        if tuple(sensors) not in ((), judged):
            known, asked = (" ".join(map(str, some)) for some in (judged, sensors))
            raise ConfigurationError(
                f"{whose} the sensors {known}, not {asked}: leave --sensors out, or {remedy}"
            )
        return validator

    def judged_by(self, recordings: Recordings, ids: Sequence[str], is_named: bool) -> JudgedBy:
        """Which frames are judged, and by what.

        Args:
            recordings: The recorded frames.
            ids: Frames to be judged; empty: all that are not fitted on.
            is_named: Whether the validator is there already, see `named`.

        Raises:
            ConfigurationError: See `judged_by_clean` and `judged_by_shipped`.
            DataError: An id that is not there.
        """
        if is_named:
            return JudgedBy(recordings.named(ids) or recordings.frames)
        if self.shipped:
            return judged_by_shipped(recordings, ids, self.shipped, self.pair_depth)
        if self.clean is None and not self.fit_likelihood:
            return judged_by_enough(recordings, ids, self.rate, self.pair_depth)
        return judged_by_clean(recordings, ids, self.clean or USUAL_SHARE)

    def fitted(
        self, by: JudgedBy, recordings: Recordings, out: Path
    ) -> ThresholdValidator | LikelihoodValidator:
        """The validator of a shipped fit, or of one that is made of clean frames and kept.

        Args:
            by: What the frames are judged by.
            recordings: The recorded frames.
            out: Folder of the fit and of what is measured for it; what is there already, is used.

        Raises:
            ConfigurationError: Too few clean frames are whole.
            DataError: A file is broken, or cannot be written.
        """
        from avsec_gym.validation.validation_folder import LIKELIHOOD, THRESHOLDS

        if by.shipped is not None:
            return self._read(by.shipped, is_likelihood=self.shipped == "likelihood")
        path = out / (LIKELIHOOD if self.fit_likelihood else THRESHOLDS)
        if not is_there(path):
            self._fit(by, recordings, path)
        return self._read(path, is_likelihood=self.fit_likelihood)

    def _fit(self, by: JudgedBy, recordings: Recordings, path: Path) -> None:
        """Measure clean frames, fit, and write the file."""
        from avsec_gym.validation.fitting import (
            CleanFrames,
            fit_likelihood_model,
            fit_threshold_table,
        )
        from avsec_gym.validation.validation_folder import SAMPLES

        data = clean_data(recordings.root, by.clean)
        clean = CleanFrames(
            by.clean, recordings.system, self.pair_depth, data, leaves_out_broken=True
        )
        samples = path.with_name(SAMPLES)
        if not self.fit_likelihood:
            with console.progress("measuring clean frames") as shown:
                table = fit_threshold_table(clean, samples=samples, on_progress=shown)
            table.write(path)
            return
        console.say(f"avsec: fitting the likelihood of {len(by.clean)} frames")
        with console.progress("attacking clean frames") as shown:
            model = fit_likelihood_model(clean, self.seed, samples=samples, on_progress=shown)
        model.write(path)

    def _read(self, file: Path, *, is_likelihood: bool) -> ThresholdValidator | LikelihoodValidator:
        """The validator that goes by a file."""
        from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
        from avsec_gym.validation.threshold_validator import ThresholdValidator

        if is_likelihood:
            return LikelihoodValidator(file, self.rate)
        return ThresholdValidator(file, self.rate, self.criterion)


def _any_validator(text: str) -> Validator:
    """By name, or as JSON states."""
    from avsec_gym.registry import Kind, make
    from avsec_gym.validation.validator import Validator

    validator = make(Kind.VALIDATOR, named_part(text, "--validator"))
    if not isinstance(validator, Validator):
        raise ConfigurationError(
            f"--validator {text} makes a {type(validator).__name__}, which is no validator: it"
            " has no name, system or validate(frame)"
        )
    return validator
