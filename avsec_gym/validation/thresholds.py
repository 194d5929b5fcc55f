"""`ThresholdTable`: what disparity errors are like when nobody attacks (thesis, section 3.3.2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import SensorSystem, Triple
from avsec_gym.validation.disparity_error import DisparityError, DisparityErrors
from avsec_gym.validation.disparity_maps import DisparityMaps
from avsec_gym.validation.fitted_on import (
    FittedOn,
    broken,
    fitted_on,
    read_fitted,
    write_fitted,
)
from avsec_gym.validation.pair_depth import PairDepth

Criterion = Literal["error", "hole_share", "either"]
"""What has to be beyond its threshold: E (the thesis), the hole share, or either of the two."""

_KIND = "thresholds"


@dataclass(frozen=True)
class Threshold:
    """Theta_{i,j,k}, and one for the holes.

    Args:
        error: For E; infinite where it does not matter.
        hole_share: For the hole share.
    """

    error: float
    hole_share: float

    def exceeded(self, error: DisparityError) -> bool:
        """e_{i,j,k}."""
        return error.error > self.error or error.hole_share > self.hole_share


@dataclass(frozen=True, eq=False)
class ThresholdTable:
    """Disparity errors of every triple in attack-free data, from which thresholds follow.

    Args:
        on: The sensors, the depth and the data; the triples are those of its system.
        errors: E of N samples, shape (N, triples).
        hole_shares: The same shape.

    Raises:
        ConfigurationError: No samples, another shape, or values outside [0, 1].
    """

    on: FittedOn
    errors: Floats
    hole_shares: Floats

    def __post_init__(self) -> None:
        for name in ("errors", "hole_shares"):
            values = np.array(getattr(self, name), float)
            if (
                values.ndim != 2
                or not len(values)
                or values.shape[1] != len(self.on.system.triples)
            ):
                raise ConfigurationError(
                    f"{name} has a row for each sample and {len(self.on.system.triples)} columns, "
                    f"got shape {values.shape}"
                )
            if not ((values >= 0) & (values <= 1)).all():
                raise ConfigurationError(f"{name} are shares from 0 to 1")
            object.__setattr__(self, name, values)
        if self.errors.shape != self.hole_shares.shape:
            raise ConfigurationError("each error has a hole share")

    def __len__(self) -> int:
        """How many samples."""
        return len(self.errors)

    def thresholds(self, rate: float, criterion: Criterion = "either") -> dict[Triple, Threshold]:
        """Theta of every triple, beyond which the share `rate` of the samples lies.

        An order statistic: of N samples floor(rate * N) lie beyond it, fewer where some are equal.
        With the criterion ``either`` both thresholds are as far out as makes these samples, all
        together, beyond the one or the other.

        Args:
            rate: r, the designated false alarm rate, from 0 to 1; the threshold of 1 is below
                every sample.
            criterion: What counts as beyond.

        Raises:
            ConfigurationError: A rate or criterion that cannot be.
        """
        if not 0 <= rate <= 1:
            raise ConfigurationError(f"the false alarm rate is from 0 to 1, got {rate}")
        if criterion not in ("error", "hole_share", "either"):
            raise ConfigurationError(f"{criterion!r} is no criterion")
        result = {}
        for column, triple in enumerate(self.on.system.triples):
            error, holes = self.errors[:, column], self.hole_shares[:, column]
            if criterion == "either":
                beyond = np.minimum(_above(error), _above(holes))
            else:
                beyond = _above(error if criterion == "error" else holes)
            allowed = _allowed(beyond, rate)
            result[triple] = Threshold(
                np.inf if criterion == "hole_share" else _order_statistic(error, allowed),
                np.inf if criterion == "error" else _order_statistic(holes, allowed),
            )
        return result

    def write(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write all samples as JSON, whole or not at all.

        Raises:
            DataError: The file exists and `overwrite` is false, or it cannot be written.
        """
        samples = {"errors": self.errors.tolist(), "hole_shares": self.hole_shares.tolist()}
        write_fitted(path, _KIND, self.on, samples, overwrite=overwrite)


def threshold_table(
    on: FittedOn, samples: Iterable[Mapping[Triple, DisparityError]]
) -> ThresholdTable:
    """The table of attack-free moments.

    Args:
        on: The sensors, the depth and the data.
        samples: Of each moment all triples, such as `DisparityErrors`.

    Raises:
        ConfigurationError: No samples.
    """
    rows = [[sample[triple] for triple in on.system.triples] for sample in samples]
    errors = np.array([[one.error for one in row] for row in rows])
    return ThresholdTable(on, errors, np.array([[one.hole_share for one in row] for row in rows]))


def measured_thresholds(
    frames: Iterable[SensorFrame], system: SensorSystem, depth: PairDepth, data: Mapping[str, Any]
) -> ThresholdTable:
    """The table of attack-free frames.

    Args:
        frames: Of one rig; read one after the other.
        system: The sensors.
        depth: How disparities of two cameras are found.
        data: What names the frames; JSON-able.

    Raises:
        ConfigurationError: No frames.
    """
    samples: list[Mapping[Triple, DisparityError]] = []
    on: FittedOn | None = None
    for frame in frames:
        on = on or fitted_on(system, depth, frame.calibration, data)
        errors = DisparityErrors(DisparityMaps(frame, system, depth))
        errors.maps.find(system.pairs())
        # The numbers alone are kept, not the maps.
        samples.append(dict(errors))
    if on is None:
        raise ConfigurationError("thresholds follow from clean frames, of which there are none")
    return threshold_table(on, samples)


def read_threshold_table(path: str | Path) -> ThresholdTable:
    """Read what `ThresholdTable.write` wrote.

    Raises:
        DataError: Missing, cut off, or something else.
    """
    on, content = read_fitted(path, _KIND)
    try:
        return ThresholdTable(on, content["errors"], content["hole_shares"])
    except (KeyError, TypeError, ValueError, ConfigurationError) as error:
        raise broken(path, error) from error


def _above(values: Floats) -> NDArray[np.intp]:
    """How many samples are larger than each."""
    return len(values) - np.searchsorted(np.sort(values), values, side="right")


def _allowed(beyond: NDArray[np.intp], rate: float) -> int:
    """How many samples of one quantity may lie beyond, that the share of all is the rate.

    Args:
        beyond: For each sample, how many have to be allowed before it is not.
        rate: From 0 to 1.
    """
    # A product such as 0.29 * 100 comes out just below the whole number that is meant.
    count = int(rate * len(beyond) + 1e-9)
    return len(beyond) if count == len(beyond) else int(np.sort(beyond)[count])


def _order_statistic(values: Floats, beyond: int) -> float:
    return -1.0 if beyond >= len(values) else float(np.sort(values)[len(values) - 1 - beyond])
