"""`ConnectedFit`: what the evidence of connected vehicles is worth, as fitted, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.distance_thresholds import distance_threshold
from avsec_gym.validation.connected.rays.decision import DecisionRule
from avsec_gym.validation.connected.rays.fitting import ScoreProbability
from avsec_gym.validation.connected.rays.rates import RayRates
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.scan_pattern import ScanPattern, scan_pattern
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

FORMAT = 2
"""Raised when what is measured changes, or how it is weighed: fits of before hold no more."""
KIND = "connected_vehicles"
SHIPPED_FIT = Path(__file__).parent / "fits" / "kitti_64_beams.json"
"""Fitted by `avsec connected --fit` on the procedural world; its file states on which."""
_REMEDY = "Fit anew on clean instants of these vehicles: `avsec connected DATA --fit FILE`."
_MOST_SAMPLES = 2_000_000
_Made = TypeVar("_Made")


@dataclass(frozen=True)
class ConnectedFit:
    """Chances of rays, thresholds and calibrations of one rig, and what they were fitted on.

    Args:
        pattern: How the beams of the vehicles' LiDARs lie.
        data: What names the instants: data set, seed, assets, how many, vehicles, proposer, poses;
            JSON-able.
        rates: Chances of rays.
        margins: How far things may lie apart, for rays.
        see_through: The log odds of a thing that rays see through, see `DecisionRule`.
        calibration: The map from a region's score to a probability.
        clean_scores: Highest score of each attack-free instant, rising; -inf where nothing was
            compared.
        epsilon: Mean distance of ground surfaces, metres.
        clean_distances: The distances of pairs of attack-free surfaces, metres, rising.
        of_distance: The map from the largest distance of a region to a probability.

    Raises:
        ConfigurationError: No scores or distances.
    """

    pattern: ScanPattern
    data: Mapping[str, Any]
    rates: RayRates
    margins: WitnessMargins
    see_through: float
    calibration: ScoreProbability
    clean_scores: tuple[float, ...]
    epsilon: float
    clean_distances: tuple[float, ...]
    of_distance: ScoreProbability
    rule: DecisionRule = field(default_factory=DecisionRule)

    def __post_init__(self) -> None:
        if not self.clean_scores or not self.clean_distances:
            raise ConfigurationError("a fit has scores and distances of attack-free instants")

    def constants(self, alarms: float = 0.1, rate: float = 0.1) -> ConnectedConstants:
        """What vehicles decide by.

        Args:
            alarms: Share of attack-free instants that may alarm by rays.
            rate: r, the share of attack-free distances beyond theta (section 4.4.4).

        Raises:
            ConfigurationError: A share that is none.
        """
        # The probability above that of the highest score that must not alarm.
        at = float(self.calibration.probability(self._highest_without_alarm(alarms)))
        alarm = float(np.clip(np.nextafter(at, 1.0), 1e-6, 1 - 1e-12))
        rule = replace(
            self.rule, alarm=alarm, see_through=self.see_through, calibration=self.calibration
        )
        theta = distance_threshold(self.clean_distances, rate)
        return ConnectedConstants(
            self.rates, self.margins, rule, self.epsilon, theta, self.of_distance
        )

    def vouched_alarms(self, alarms: float = 0.1) -> float:
        """Share of attack-free instants that alarm by rays at most, with 95 % confidence.

        As of `rate_bound`, if the attack-free instants that were fitted on are independent.

        Args:
            alarms: The share of attack-free instants that may alarm, as of `constants`.

        Raises:
            ConfigurationError: As of `constants`.
        """
        highest = self._highest_without_alarm(alarms)
        beyond = int((np.array(self.clean_scores) > highest).sum())
        return rate_bound(len(self.clean_scores), beyond)

    def check(self, scans: Sequence[VehicleScan]) -> None:
        """Check that it holds for the LiDARs of an instant, too.

        Scans of which nothing came back show nothing, and are no reason to refuse.

        Raises:
            ConfigurationError: Beams that lie otherwise.
        """
        for scan in scans:
            pattern = scan_pattern(scan.points)
            if pattern is not None:
                self.pattern.check(pattern)

    @property
    def origin(self) -> str:
        """What it was fitted on, in words."""
        data = self.data
        where = f"of {data['folder']}" if "folder" in data else "of the procedural world"
        words = {"seed": "seed", "assets": "assets", "vehicles": "vehicles"}
        named = ", ".join(f"{word} {data[key]}" for key, word in words.items() if key in data)
        counts = f"{data.get('instants')} instants {where}, attacked {data.get('attacked')} times"
        return f"fitted on {counts}" + (f" ({named})" if named else "")

    def _highest_without_alarm(self, alarms: float) -> float:
        """The highest score of the attack-free instants that must not alarm."""
        if not 0 <= alarms < 1:
            raise ConfigurationError(f"the share of false alarms is from 0 to 1, got {alarms}")
        scores = np.sort(self.clean_scores)
        beyond = min(int(alarms * len(scores) + 1e-9), len(scores) - 1)
        return max(float(scores[len(scores) - 1 - beyond]), _LEAST_SCORE)


_LEAST_SCORE = 0.0
"""What speaks against an attack never alarms."""


def write_connected_fit(path: str | Path, fit: ConnectedFit, *, overwrite: bool = False) -> None:
    """Write it as JSON, whole or not at all.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    content = {
        "format": FORMAT,
        "kind": KIND,
        "data": dict(fit.data),
        "pattern": asdict(fit.pattern),
        "rates": asdict(fit.rates),
        "margins": asdict(fit.margins),
        "see_through": fit.see_through,
        "calibration": asdict(fit.calibration),
        # JSON knows no infinity.
        "clean_scores": [score if np.isfinite(score) else None for score in fit.clean_scores],
        "epsilon": fit.epsilon,
        "clean_distances": list(fit.clean_distances),
        "of_distance": asdict(fit.of_distance),
    }
    text = json.dumps(content, allow_nan=False) + "\n"
    write_bytes(path, text.encode(), overwrite=overwrite)


def read_connected_fit(path: str | Path) -> ConnectedFit:
    """Read what `write_connected_fit` wrote.

    Raises:
        DataError: Missing, cut off, damaged, or of another kind or format.
    """
    content = read_json_object(path, remedy=_REMEDY)
    try:
        if (content["kind"], content["format"]) != (KIND, FORMAT):
            raise DataError(
                f"The file holds {content['kind']!r} in format {content['format']!r}, expected"
                f" {KIND!r} in format {FORMAT}.",
                path=path,
                remedy=_REMEDY,
            )
        scores, distances = _listed(content["clean_scores"]), _listed(content["clean_distances"])
        fit = ConnectedFit(
            _made(ScanPattern, content["pattern"]),
            dict(content["data"]),
            _made(RayRates, content["rates"]),
            _made(WitnessMargins, content["margins"]),
            _number(content["see_through"]),
            _made(ScoreProbability, content["calibration"]),
            tuple(-np.inf if score is None else float(_number(score)) for score in scores),
            _number(content["epsilon"]),
            tuple(_number(distance) for distance in distances),
            _made(ScoreProbability, content["of_distance"]),
        )
        # What decides by it has checks of its own; what no fit can hold is the file's fault.
        fit.constants()
        return fit
    except (KeyError, TypeError, ValueError, ConfigurationError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else f"is damaged: {error}"
        raise DataError(f"The file {what}.", path=path, remedy=_REMEDY) from error


def _number(value: Any) -> float:
    """A finite number of JSON.

    Raises:
        ValueError: It is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return value


def _listed(values: Any) -> list[Any]:
    if not isinstance(values, list) or len(values) > _MOST_SAMPLES:
        raise ValueError(f"samples are a list of {_MOST_SAMPLES} at most")
    return values


def _made(kind: type[_Made], values: Any) -> _Made:
    """A dataclass of numbers, of which none may be missing.

    Raises:
        ValueError: There are others.
    """
    expected = {each.name for each in fields(kind)}  # type: ignore[arg-type]
    if not isinstance(values, dict) or set(values) != expected:
        raise ValueError(f"it has not {', '.join(sorted(expected))}")
    return kind(**{name: _number(value) for name, value in values.items()})
