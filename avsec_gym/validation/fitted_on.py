"""`FittedOn`: which sensors, which depth and which data something was fitted on, and its files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.validation.evidence.pair_depth import PairDepth

FORMAT = 5
"""Raised when what is measured changes, or how it is weighed: thresholds and likelihoods of before
hold no more."""
_SAME_SCALE = 0.05
"""Recording days of KITTI differ by less, rigs by more."""
_MOST_SENSORS = 16
_LARGEST_SCALE = 1e6
_RENAMED = {"moments": "frames"}
"""Names of data in files of earlier releases, and what they are called now."""
_REMEDY = "Fit it anew on clean frames of these sensors, or name another file."


@dataclass(frozen=True)
class FittedOn:
    """What thresholds and likelihoods hold for, and where they come from.

    Args:
        system: The sensors.
        depth: The settings of the pair depth, `PairDepth.settings`.
        scales: Focal length times baseline of neighbouring cameras, from right to left, pixels
            times metres.
        data: JSON-able: what names the frames, such as a suite, how many, which seed.
        weights: The hash of what a learned depth estimator had learned; None where nothing is
            learned, or where it was not recorded.
    """

    system: SensorSystem
    depth: Mapping[str, Any]
    scales: tuple[float, ...]
    data: Mapping[str, Any]
    weights: str | None = None

    def check(self, system: SensorSystem, depth: PairDepth, calibration: Calibration) -> None:
        """Check that it holds for these sensors, too.

        Args:
            system: The same one.
            depth: How disparities are found.
            calibration: The calibration of the rig.

        Raises:
            ConfigurationError: Another system, depth estimator or rig, for which the thresholds
                do not hold.
        """
        if self.system != system:
            raise ConfigurationError(
                f"this was fitted on the sensors {_named(self.system)}, not {_named(system)}: fit "
                "it on clean frames of these sensors"
            )
        if dict(self.depth) != depth.settings:
            raise ConfigurationError(
                f"this was fitted with depth by {dict(self.depth)}, not by {depth.settings}: fit "
                "it with this one, or use that one"
            )
        if self.weights != depth.weights:
            raise ConfigurationError(
                f"this was fitted with {self._weights} of {self.depth.get('name')}, which has"
                f" others today ({str(depth.weights)[:8]}): fit it anew"
            )
        scales = camera_scales(system, calibration)
        if not np.allclose(scales, self.scales, rtol=_SAME_SCALE, atol=0):
            raise ConfigurationError(
                "this was fitted on cameras that stand otherwise: focal length times baseline of "
                f"neighbours is {_listed(scales)} px m, not {_listed(self.scales)}"
            )

    def to_json(self) -> dict[str, Any]:
        """The record for a file."""
        return {
            "sensors": list(self.system.sensors),
            "depth": dict(self.depth),
            "scales": list(self.scales),
            "data": dict(self.data),
            **({} if self.weights is None else {"weights": self.weights}),
        }

    @property
    def _weights(self) -> str:
        recorded = self.weights is not None
        return f"the weights {str(self.weights)[:8]}" if recorded else "weights unknown"


def fitted_on(
    system: SensorSystem, depth: PairDepth, calibration: Calibration, data: Mapping[str, Any]
) -> FittedOn:
    """What is to be fitted on these sensors.

    Args:
        system: The sensors.
        depth: How disparities are found.
        calibration: The calibration of the rig.
        data: Names of the frames; JSON-able.

    Raises:
        ConfigurationError: The cameras do not stand in that order.
    """
    system.check(calibration)
    return FittedOn(
        system, depth.settings, camera_scales(system, calibration), dict(data), depth.weights
    )


def camera_scales(system: SensorSystem, calibration: Calibration) -> tuple[float, ...]:
    """Focal length times baseline of neighbouring cameras, from right to left."""
    return tuple(
        calibration.focal_length(left) * calibration.baseline(left, right)
        for right, left in zip(system.cameras, system.cameras[1:], strict=False)
    )


def write_fitted(
    path: str | Path, kind: str, on: FittedOn, content: Mapping[str, Any], *, overwrite: bool
) -> None:
    """Write something fitted as JSON, whole or not at all.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    header = {"format": FORMAT, "kind": kind, "fitted_on": on.to_json()}
    text = json.dumps({**header, **content}, allow_nan=False)
    write_bytes(path, text.encode(), overwrite=overwrite)


def read_fitted(path: str | Path, kind: str) -> tuple[FittedOn, dict[str, Any]]:
    """Read what `write_fitted` wrote.

    Raises:
        DataError: Missing, cut off, or of another kind or format.
    """
    content = read_json_object(path, remedy=_REMEDY)
    try:
        if (content["kind"], content["format"]) != (kind, FORMAT):
            raise DataError(
                f"The file holds {content['kind']!r} in format {content['format']!r}, expected "
                f"{kind!r} in format {FORMAT}.",
                path=path,
                remedy=_REMEDY,
            )
        on = content["fitted_on"]
        sensors = tuple(on["sensors"])
        if len(sensors) > _MOST_SENSORS:  # Triples grow with the third power.
            raise ValueError(f"it has {len(sensors)} sensors")
        system = SensorSystem(sensors)
        scales = tuple(map(float, on["scales"]))
        if not all(0 < scale < _LARGEST_SCALE for scale in scales):
            raise ValueError("scales are focal lengths times baselines, positive")
        if len(scales) != len(system.cameras) - 1:
            raise ValueError(f"{len(scales)} scales for {len(system.cameras)} cameras")
        data = {_RENAMED.get(name, name): value for name, value in on["data"].items()}
        weights = on.get("weights")
        if not isinstance(weights, str | None):
            raise ValueError("weights are named by their hash")
        PairDepth.from_settings(on["depth"])  # What it refuses is the file's fault.
        return FittedOn(system, dict(on["depth"]), scales, data, weights), content
    except (KeyError, TypeError, ValueError, AttributeError, ConfigurationError) as error:
        raise broken(path, error) from error


def broken(path: str | Path, error: Exception) -> DataError:
    """The error for a file whose content is inconsistent."""
    what = f"lacks {error}" if isinstance(error, KeyError) else f"is damaged: {error}"
    return DataError(f"The file {what}.", path=path, remedy=_REMEDY)


def _named(system: SensorSystem) -> str:
    return ", ".join(map(str, system.sensors))


def _listed(numbers: tuple[float, ...]) -> str:
    return ", ".join(f"{number:.0f}" for number in numbers)
