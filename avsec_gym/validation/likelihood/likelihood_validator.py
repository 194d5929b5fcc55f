"""Beyond the thesis: the sensor state vector from all triples at once, as a validator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from avsec_gym.argument_checks import number, shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import (
    LikelihoodModel,
    read_likelihood_model,
)
from avsec_gym.validation.state_posterior import Decoding
from avsec_gym.validation.validator import Validation


@dataclass(frozen=True)
class LikelihoodValidator:
    """Finds the most probable sensor state vector, with a probability for each sensor.

    `Decoding.statuses` gives the status of each sensor, in accord with the alarm.

    Args:
        model: p(evidence | **s**); a model or its file.
        rate: The designated false alarm rate.
        certainty: The probability that a status needs, else it is open; None: the most probable
            **s** is reported.

    Raises:
        ConfigurationError: A rate or a certainty that cannot be.
        DataError: The file is missing or broken.
    """

    name: ClassVar[str] = "likelihood"
    model: LikelihoodModel | str | Path
    rate: float = 0.01
    certainty: float | None = 0.95
    _model: LikelihoodModel = field(init=False, repr=False, compare=False)
    _depth: PairDepth = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given = self.model
        if not isinstance(given, LikelihoodModel | str | Path):
            raise ConfigurationError(f"model takes a file or a LikelihoodModel, got {shown(given)}")
        object.__setattr__(self, "rate", number("rate", self.rate, 0.0, 1.0))
        if self.certainty is not None:
            certainty = number("certainty", self.certainty, 0.0, 1.0)
            object.__setattr__(self, "certainty", certainty)
        model = given if isinstance(given, LikelihoodModel) else read_likelihood_model(given)
        object.__setattr__(self, "_model", model)
        object.__setattr__(self, "_depth", PairDepth.from_settings(model.on.depth))

    @property
    def on(self) -> FittedOn:
        """What it was fitted on."""
        return self._model.on

    @property
    def system(self) -> SensorSystem:
        """See `Validator`."""
        return self.on.system

    @property
    def remark(self) -> str:
        """Where clean frames are too few for the rate; empty if they are not."""
        count = len(self._model.clean_scores)
        if not 0 < self.rate * count < 1:
            return ""
        return (
            f"expect more false alarms than r = {self.rate:g}: of {count} clean frames that were "
            f"held out none raises an alarm; it takes {math.ceil(1 / self.rate):,}"
        )

    @property
    def vouched(self) -> str:
        """The false positive rate that this model can vouch for, in words; empty without frames."""
        if not (count := len(self._model.clean_scores)):
            return ""
        return (
            f"{count:,} clean frames that were held out vouch, at r ="
            f" {self.rate:g}, for a false alarm rate of {self._model.vouched_rate(self.rate):.2g}"
            " at most (95 % confidence; frames of one drive are alike, and count as fewer)"
        )

    def validate(self, frame: SensorFrame) -> Validation:
        """See `Validator`."""
        errors, decoding = self._decoded(frame)
        sensors = self.system.sensors
        found = decoding.statuses(self.certainty)[0]
        probabilities = dict(zip(sensors, decoding.posterior.sensors[0].tolist(), strict=True))
        statuses = dict(zip(sensors, found, strict=True))
        return Validation(bool(decoding.alarms[0]), statuses, errors, probabilities)

    def decode(self, frame: SensorFrame) -> Decoding:
        """What follows from the evidence of one frame, before it becomes statuses.

        Args:
            frame: The frame, as of `validate`.

        Raises:
            ConfigurationError: The rig is not the one that it was fitted on.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        return self._decoded(frame)[1]

    def _decoded(self, frame: SensorFrame) -> tuple[DisparityErrors, Decoding]:
        self.on.check(self.system, self._depth, frame.calibration)
        errors = DisparityErrors(DisparityMaps(frame, self.system, self._depth))
        return errors, self._model.decode(gather_evidence(errors)[None], self.rate)
