"""Depth behind one interface: whatever finds disparities in what the sensors deliver."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.factory_arguments import check_arguments
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.suggestions import unknown_name

_BUILT_IN: dict[str, tuple[str, dict[str, Any]]] = {
    "sgbm": ("avsec_gym.perception.depth.sgbm:SemiGlobalMatching", {}),
    "lidar": ("avsec_gym.perception.depth.lidar:LidarDepth", {}),
    "ground_truth": ("avsec_gym.perception.depth.ground_truth:GroundTruthDepth", {}),
    "psmnet": ("avsec_gym.perception.depth.psmnet_depth:PsmNetDepth", {"weights": "shipped"}),
}


@dataclass(frozen=True, eq=False)
class DisparityMap:
    """How far each pixel of the reference image is shifted in another view.

    Args:
        values: The values, shape (H, W), pixels of the camera's own image, NaN where unknown.
        focal_times_baseline: The focal length in pixels times the baseline in metres of the views:
            depth = this / disparity.
    """

    values: Disparity
    focal_times_baseline: float

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Where the disparity is known, shape (H, W)."""
        return np.isfinite(self.values)

    @property
    def depth(self) -> NDArray[np.float32]:
        """Metres along the camera's axis, shape (H, W); NaN where unknown, infinite at 0."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.float32(self.focal_times_baseline) / self.values)

    def rescaled(self, focal_times_baseline: float) -> DisparityMap:
        """The same depths as disparities of a pair with another baseline."""
        factor = np.float32(focal_times_baseline / self.focal_times_baseline)
        return DisparityMap(self.values * factor, focal_times_baseline)


@runtime_checkable
class DepthEstimator(Protocol):
    """Anything that finds disparities."""

    @property
    def name(self) -> str:
        """The name that tables show."""
        ...

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """Disparities of the reference (left) image.

        Raises:
            DataError: The frame lacks a sensor that this estimator needs.
        """
        ...


def make_depth(what: Any = "sgbm") -> Any:
    """The depth estimator that a name, a dictionary or an object stands for.

    Args:
        what: ``sgbm``, ``lidar``, ``ground_truth`` or ``psmnet``; a dictionary of the name and
            arguments such as ``{"name": "sgbm", "disparities": 192}``; or a live object, which
            is returned as it is.

    Raises:
        ConfigurationError: Nothing has that name, or the arguments do not fit.

    Example:
        >>> make_depth({"name": "sgbm", "disparities": 192}).disparities
        192
    """
    if isinstance(what, DepthEstimator):
        return what
    arguments = {"name": what} if isinstance(what, str) else dict(what)
    name = arguments.pop("name", None)
    check_depth(name)
    path, defaults = _BUILT_IN[name]
    module, attribute = path.split(":")
    factory = getattr(import_module(module), attribute)
    check_arguments(f"the depth estimator {name!r}", factory, arguments)
    try:
        return factory(**(defaults | arguments))
    except TypeError as error:
        raise ConfigurationError(f"the depth estimator {name!r} cannot be made: {error}") from error


def check_depth(name: Any) -> None:
    """Refuse a name that `make_depth` does not know; nothing is made, nor imported.

    Raises:
        ConfigurationError: Nothing has that name.
    """
    if not isinstance(name, str) or name not in _BUILT_IN:
        problem = f"there is no depth estimator named {name!r}"
        raise ConfigurationError(unknown_name(problem, str(name), _BUILT_IN))


def pair_scale(frame: SensorFrame, left: int, right: int) -> float:
    """Focal length times baseline of two cameras, pixels times metres."""
    calibration = frame.calibration
    return calibration.focal_length(left) * calibration.baseline(left, right)
