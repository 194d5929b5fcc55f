"""`ThresholdTable`: disparity errors without an attack, and thresholds (thesis, section 3.3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.sensor_system import SensorSystem, Triple
from avsec_gym.validation.evidence.disparity_error import MEASURES, DisparityError, DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import (
    FittedOn,
    broken,
    read_fitted,
    write_fitted,
)

Criterion = Literal["error", "hole_share", "densest", "brightness", "any"]
"""Which share has to be beyond its threshold: E (the thesis), another one, or any of them."""

_KIND = "thresholds"
_LEAST_BRIGHTNESS = "least_brightness"
_RARER = {"error": 10, "hole_share": 10}
"""A hard scene raises these as an attack does, disproved points and light that is in one image only
hardly ever: with ``any``, one clean sample may lie beyond them for so many beyond the others."""


@dataclass(frozen=True)
class Threshold:
    """Theta_{i,j,k}, and one for each share that goes beyond E; infinite where it does not matter.

    Args:
        error: The threshold of E.
        hole_share: The threshold of the share of holes, see `DisparityError`.
        densest: The threshold of the densest disproved window, see `DisparityError`.
        brightness: The threshold of the brightness, see `DisparityError`.
    """

    error: float = np.inf
    hole_share: float = np.inf
    densest: float = np.inf
    brightness: float = np.inf

    @property
    def shares(self) -> Floats:
        """The thresholds in the order of `MEASURES`, shape (4,)."""
        return np.array([getattr(self, name) for name in MEASURES])

    def exceeded(self, error: DisparityError) -> bool:
        """e_{i,j,k}."""
        return bool((error.shares > self.shares).any())


@dataclass(frozen=True, eq=False)
class ThresholdTable:
    """What disparity errors of every triple are in attack-free data, whence thresholds follow.

    Beyond an order statistic of N samples lies the share that was meant, (r N + 1) / (N + 1) on
    average, of new frames that are as independent of these samples as they are of each other.
    Frames of one drive are alike: of a few drives, N counts drives rather than frames, and a new
    drive may have many more false alarms, or none.

    Args:
        on: The sensors, the depth and the data; the triples are those of its system.
        shares: All `MEASURES` of N samples, shape (N, triples, 4).
        least_brightness: What the threshold of `DisparityError.brightness` is at least, in every
            triple: real cameras differ from each other by more than rendered ones, so that
            thresholds of rendered frames are raised by what clean real pairs of images show, see
            `avsec_gym.metrics.tolerance.tolerance_threshold`.

    Raises:
        ConfigurationError: No samples, another shape, or values outside [0, 1].
    """

    on: FittedOn
    shares: Floats
    least_brightness: float = 0.0

    def __post_init__(self) -> None:
        shares = np.array(self.shares, float)
        shape = (len(self.on.system.triples), len(MEASURES))
        if shares.ndim != 3 or not len(shares) or shares.shape[1:] != shape:
            raise ConfigurationError(
                f"each sample has {shape[0]} triples of {shape[1]} shares, got shape {shares.shape}"
            )
        if not ((shares >= 0) & (shares <= 1)).all():
            raise ConfigurationError("shares are from 0 to 1")
        object.__setattr__(self, "shares", shares)
        least = number("least_brightness", self.least_brightness, 0.0, 1.0)
        object.__setattr__(self, "least_brightness", least)

    def __len__(self) -> int:
        """How many samples."""
        return len(self.shares)

    def thresholds(self, rate: float, criterion: Criterion = "any") -> dict[Triple, Threshold]:
        """Theta of every triple, beyond which the share `rate` of the samples lies.

        An order statistic: of N samples floor(rate * N) lie beyond it, fewer where some are equal.
        With the criterion ``any`` these samples are, all together, beyond one or the other of the
        thresholds; those of E and of holes are farther out, beyond a tenth as many samples as the
        others.

        Args:
            rate: r, the designated false alarm rate, from 0 to 1; the threshold of 1 is below
                every sample, whatever `least_brightness` is.
            criterion: What counts as beyond.

        Raises:
            ConfigurationError: A rate or criterion that cannot be.
        """
        if not 0 <= rate <= 1:
            raise ConfigurationError(f"the false alarm rate is from 0 to 1, got {rate}")
        if criterion not in (*MEASURES, "any"):
            raise ConfigurationError(
                f"{criterion!r} is no criterion; there are {', '.join(MEASURES)} and any"
            )
        rarer: dict[str, int] = {criterion: 1}
        if criterion == "any":
            rarer = {name: _RARER.get(name, 1) for name in MEASURES}
        columns = [MEASURES.index(name) for name in rarer]
        result = {}
        for column, triple in enumerate(self.on.system.triples):
            values = dict(zip(rarer, self.shares[:, column, columns].T, strict=True))
            needed = [rarer[name] * _not_below(shares) for name, shares in values.items()]
            allowed = _allowed(np.min(needed, axis=0), rate)
            limits = {
                name: _order_statistic(values[name], allowed // rarer[name]) for name in rarer
            }
            if "brightness" in limits and rate < 1:
                limits["brightness"] = max(limits["brightness"], self.least_brightness)
            result[triple] = Threshold(**limits)
        return result

    def vouched_rate(self, rate: float, criterion: Criterion = "any") -> float:
        """The false positive rate that the thresholds of every triple keep, with 95 % confidence.

        As of `rate_bound`, of the triple with the most samples beyond.  Exact for one share of
        independent samples; with ``any`` the samples beyond any of the thresholds are counted as if
        by one share.  Frames of one drive are alike: of a few drives it promises too much.

        Args:
            rate: The designated false alarm rate, as of `thresholds`.
            criterion: What counts as beyond, as of `thresholds`.

        Raises:
            ConfigurationError: As of `thresholds`.
        """
        chosen = self.thresholds(rate, criterion)
        limits = np.array([chosen[triple].shares for triple in self.on.system.triples])
        beyond = (self.shares > limits).any(axis=2).sum(axis=0)
        return rate_bound(len(self), int(beyond.max()))

    def write(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write all samples as JSON, whole or not at all.

        Raises:
            DataError: The file exists and `overwrite` is false, or it cannot be written.
        """
        content = {"measures": MEASURES, "shares": self.shares.tolist()}
        if self.least_brightness:
            content[_LEAST_BRIGHTNESS] = self.least_brightness
        write_fitted(path, _KIND, self.on, content, overwrite=overwrite)


def shares_of(frame: SensorFrame, system: SensorSystem, depth: PairDepth) -> Floats:
    """All `MEASURES` of every triple of a frame, shape (triples, 4).

    Args:
        frame: A frame with the data of all sensors.
        system: The sensors.
        depth: How disparities of two cameras are found.
    """
    errors = DisparityErrors(DisparityMaps(frame, system, depth))
    errors.maps.find(system.pairs())
    return np.array([errors[triple].shares for triple in system.triples])


def read_threshold_table(path: str | Path) -> ThresholdTable:
    """Read what `ThresholdTable.write` wrote.

    Raises:
        DataError: Missing, cut off, or something else.
    """
    on, content = read_fitted(path, _KIND)
    try:
        if tuple(content["measures"]) != MEASURES:
            raise ValueError(f"it has the shares {content['measures']}, expected {MEASURES}")
        return ThresholdTable(on, content["shares"], content.get(_LEAST_BRIGHTNESS, 0.0))
    except (KeyError, TypeError, ValueError, ConfigurationError) as error:
        raise broken(path, error) from error


def _not_below(values: Floats) -> NDArray[np.intp]:
    """How many samples are as large as each, or larger: that many allowed, it lies beyond."""
    return len(values) - np.searchsorted(np.sort(values), values, side="left")


def _allowed(needed: NDArray[np.intp], rate: float) -> int:
    """How many samples of one quantity may lie beyond, that the share of all is at most the rate.

    Args:
        needed: The number, for each sample, of those that have to be allowed before it lies beyond.
        rate: The share, from 0 to 1.
    """
    # A product such as 0.29 * 100 comes out just below the whole number that is meant.
    count = int(rate * len(needed) + 1e-9)
    return int(np.sort(needed)[count]) - 1 if count < len(needed) else int(needed.max())


def _order_statistic(values: Floats, beyond: int) -> float:
    return -1.0 if beyond >= len(values) else float(np.sort(values)[len(values) - 1 - beyond])
