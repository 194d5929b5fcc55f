"""`PairDepth`: one way of finding depth, for any two cameras of a rig."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from avsec_gym.argument_checks import flag, number
from avsec_gym.errors import ConfigurationError
from avsec_gym.factory_arguments import check_arguments
from avsec_gym.frame import Calibration, Image
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DepthEstimator, check_depth, make_depth
from avsec_gym.perception.depth.filled_holes import FilledHoles
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.validation.evidence.seen_by_both import SeenByBoth

_STEP = 16
"""OpenCV searches disparities by the 16."""
_NEAREST = (0.01, 10_000.0)
"""The nearest depth that is looked for, metres."""
_FILLED = "filled"
_OWN = ("name", "nearest", _FILLED)
"""Arguments that are not the matcher's."""


@dataclass(frozen=True)
class PairDepth:
    """Makes the depth estimator of each pair, once.

    Other estimators than matching also answer where only one camera sees: such pixels are left out.

    Args:
        what: A name that `make_depth` knows, or a dictionary of it and its arguments, without
            ``left`` and ``right``.  ``sgbm`` without ``disparities`` searches as far as `nearest`
            asks for, so that narrow pairs are fast, and over the image's whole width.  With
            ``"filled": True`` its holes are filled as KITTI's development kit does, see
            `FilledHoles`.
        nearest: Depth down to which ``sgbm`` matches, metres.

    Raises:
        ConfigurationError: Neither name nor dictionary, an unknown name, or a depth that is not
            positive.

    Example:
        >>> from avsec_gym.rig import kitti_rig
        >>> PairDepth().estimator(kitti_rig().calibration, 3, 1).disparities
        16
    """

    what: str | Mapping[str, Any] = "sgbm"
    nearest: float = 3.5
    _made: dict[tuple[float, int, int], DepthEstimator] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        if not isinstance(self.what, str | Mapping):
            raise ConfigurationError(
                "the depth of pairs is a name or a dictionary, since it is made for each pair; "
                f"got {type(self.what).__name__}"
            )
        number("nearest", self.nearest, *_NEAREST)
        check_depth(self.settings.get("name"))
        if (settings := self.settings)["name"] == "sgbm":
            flag(_FILLED, settings.get(_FILLED, False))
            arguments = {name: value for name, value in settings.items() if name not in _OWN}
            check_arguments("the depth estimator 'sgbm'", WholeWidthMatching, arguments)
            WholeWidthMatching(**arguments)

    @property
    def settings(self) -> dict[str, Any]:
        """JSON-able: what decides the disparities."""
        named = {"name": self.what} if isinstance(self.what, str) else self.what
        arguments: dict[str, Any] = {**named}
        if "nearest" in arguments:
            raise ConfigurationError("nearest stands beside the dictionary, not in it")
        if arguments.get("name") == "sgbm" and "disparities" not in arguments:
            arguments["nearest"] = self.nearest
        return arguments

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> PairDepth:
        """The one whose `settings` these are."""
        what = dict(settings)
        nearest = what.pop("nearest", cls.nearest)
        return cls(what, nearest)

    @cached_property
    def weights(self) -> str | None:
        """The hash of what a learned estimator has learned; None for one that learns nothing.

        Raises:
            DataError: The weights are missing or damaged.
        """
        if self.settings["name"] in ("sgbm", "ground_truth", "lidar"):
            return None
        # Loads torch.
        from avsec_gym.perception.weights.weights_hash import weights_hash

        return weights_hash(make_depth(self.what))

    def estimator(self, calibration: Calibration, left: int, right: int) -> DepthEstimator:
        """The estimator of one pair of cameras.

        Raises:
            ConfigurationError: `make_depth` refuses, or right is not right of left.
        """
        scale = calibration.focal_length(left) * calibration.baseline(left, right)
        if scale <= 0:
            raise ConfigurationError(f"camera {right} is not right of camera {left}")
        key = (round(scale, 3), left, right)
        if key not in self._made:
            arguments = {**self.settings, "left": left, "right": right}
            nearest = arguments.pop("nearest", None)
            is_filled = arguments["name"] == "sgbm" and arguments.pop(_FILLED, False)
            if nearest is None:
                estimator = make_depth(arguments)
                is_matching = isinstance(estimator, SemiGlobalMatching)
                found = estimator if is_matching else make_depth(SeenByBoth(estimator))
            else:
                del arguments["name"]
                arguments["disparities"] = _STEP * math.ceil(scale / nearest / _STEP)
                found = make_depth(WholeWidthMatching(**arguments))
            self._made[key] = make_depth(FilledHoles(found)) if is_filled else found
        return self._made[key]


@dataclass(frozen=True)
class WholeWidthMatching(SemiGlobalMatching):
    """Semi-global matching that leaves no strip at the left edge unmatched.

    OpenCV gives none of the columns that the largest disparity leads out of the other image, where
    an attack could hide; behind a border it finds what is far enough to be in both images.
    """

    name: ClassVar[str] = "whole_width_sgbm"

    def match(self, left: Image, right: Image) -> Disparity:
        """See `SemiGlobalMatching.match`."""
        import cv2

        width = self.disparities
        wider: list[Any] = [
            cv2.copyMakeBorder(image, 0, 0, width, 0, cv2.BORDER_REPLICATE)
            for image in (left, right)
        ]
        return np.ascontiguousarray(super().match(*wider)[:, width:])
