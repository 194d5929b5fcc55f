"""The thesis' validator: errors against thresholds, then algorithm 2 (sections 3.3 and 3.4)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from avsec_gym.argument_checks import number, one_of, shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import SensorSystem, Triple
from avsec_gym.validation.detection import detect_attack
from avsec_gym.validation.evidence.disparity_error import MEASURES, DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.thresholds import (
    Criterion,
    Threshold,
    ThresholdTable,
    read_threshold_table,
)
from avsec_gym.validation.validator import SHARES, Validation


@dataclass(frozen=True)
class ThresholdValidator:
    """Finds an attack on three sensors, and the attacked sensors of four or more.

    An error beyond its threshold is always an alarm: where no sensor that algorithm 2 names
    explains it, the status of its sensors is open.

    Args:
        thresholds: The errors without an attack; a table or its file.
        rate: The designated false alarm rate r of each triple.
        criterion: What counts as beyond, see `ThresholdTable.thresholds`.

    Raises:
        ConfigurationError: A rate or criterion that cannot be.
        DataError: The file is missing or broken.

    Example:
        >>> ThresholdValidator("thresholds.json").validate(frame).attacked  # doctest: +SKIP
        frozenset({3})
    """

    name: ClassVar[str] = "thresholds"
    thresholds: ThresholdTable | str | Path
    rate: float = 0.01
    criterion: Criterion = "any"
    _table: ThresholdTable = field(init=False, repr=False, compare=False)
    _chosen: Mapping[Triple, Threshold] = field(init=False, repr=False, compare=False)
    _depth: PairDepth = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given = self.thresholds
        if not isinstance(given, ThresholdTable | str | Path):
            raise ConfigurationError(
                f"thresholds takes a file or a ThresholdTable, got {shown(given)}"
            )
        object.__setattr__(self, "rate", number("rate", self.rate, 0.0, 1.0))
        one_of("criterion", self.criterion, (*MEASURES, "any"))
        table = given if isinstance(given, ThresholdTable) else read_threshold_table(given)
        object.__setattr__(self, "_table", table)
        object.__setattr__(self, "_chosen", table.thresholds(self.rate, self.criterion))
        object.__setattr__(self, "_depth", PairDepth.from_settings(table.on.depth))

    @property
    def on(self) -> FittedOn:
        """What it was fitted on."""
        return self._table.on

    @property
    def system(self) -> SensorSystem:
        """See `Validator`."""
        return self.on.system

    @property
    def remark(self) -> str:
        """Where clean samples are too few for the rate; empty if they are not.

        Thresholds are then the largest sample's, as those of r = 0.
        """
        shares = self._table.shares
        limits = np.array([self._chosen[triple].shares for triple in self.system.triples])
        # One that was raised beyond all samples is of other data.
        largest = (shares.max(axis=0) == limits).all(axis=0)
        # Of a share that is nothing in every sample none would lie beyond, however many there were.
        if self.rate == 0 or not (largest & shares.any(axis=(0, 1))).any():
            return ""
        names = [
            SHARES[name] for name, is_largest in zip(MEASURES, largest, strict=True) if is_largest
        ]
        frames = math.ceil(1 / self.rate)
        few = f"it takes {frames:,} or more"
        if self.criterion == "any":  # All shares together may be exceeded by the share r.
            few = f"it takes up to {2 * frames:,}, for E and holes up to {22 * frames:,}"
        return (
            f"expect more false alarms than r = {self.rate:g}: of {len(shares)} clean frames, the "
            f"thresholds of {', '.join(names)} are the largest values; {few}"
        )

    @property
    def vouched(self) -> str:
        """The false positive rate that these thresholds can vouch for, in words."""
        count = len(self._table)
        return (
            f"thresholds of {count:,} clean frames at r = {self.rate:g} vouch for a false alarm"
            f" rate of each triple of {self._table.vouched_rate(self.rate, self.criterion):.2g} at"
            " most (95 % confidence; frames of one drive are alike, and count as fewer)"
        )

    def validate(self, frame: SensorFrame) -> Validation:
        """See `Validator`; maps are found only of those references that algorithm 2 reaches."""
        self.on.check(self.system, self._depth, frame.calibration)
        errors = DisparityErrors(DisparityMaps(frame, self.system, self._depth))

        def exceeded(triple: Triple) -> bool:
            # Algorithm 1 asks for all triples of a reference: their maps are found at once.
            errors.maps.find(self.system.pairs(triple[2]))
            return self._chosen[triple].exceeded(errors[triple])

        sensors = self.system.sensors
        if len(sensors) == 3:
            errors.maps.find(self.system.pairs(2))
            alarm = detect_attack(errors, self._chosen)
            status = SensorStatus.CANNOT_TELL if alarm else SensorStatus.SOUND
            statuses = dict.fromkeys(sensors, status)
            return Validation(alarm, statuses, errors, thresholds=self._chosen)
        found = identify_attacked_sensors(exceeded, len(sensors))
        statuses = dict.fromkeys(sensors, SensorStatus.SOUND)
        statuses |= {sensors[position]: SensorStatus.CANNOT_TELL for position in found.doubtful}
        statuses |= {sensors[position]: SensorStatus.ATTACKED for position in found.named}
        alarm = bool(found.named or found.doubtful)
        return Validation(alarm, statuses, errors, thresholds=self._chosen)
