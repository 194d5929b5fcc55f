"""Semi-global matching, OpenCV's: depth without weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale

_STEPS = 16.0
"""Steps in which OpenCV counts a pixel."""
_BETWEEN = {
    "left": (0, 100),
    "right": (0, 100),
    "disparities": (16, 16_384),
    "block": (1, 255),
    "uniqueness": (0, 100),
}


@dataclass(frozen=True)
class SemiGlobalMatching:
    """Stereo matching of grey images, with usual settings for KITTI.

    Raises:
        ConfigurationError: A number that OpenCV refuses.

    Source:
        Hirschmueller, Stereo Processing by Semiglobal Matching and Mutual Information, 2008.
    """

    name: ClassVar[str] = "sgbm"
    left: int = 2
    """Reference camera."""
    right: int = 3
    """The other one."""
    disparities: int = 128
    """Searched, a multiple of 16; the leftmost so many columns have none."""
    block: int = 5
    """Width of the compared blocks, odd."""
    uniqueness: int = 10
    """Percent by which the best match beats the second."""

    def __post_init__(self) -> None:
        for name, (least, most) in _BETWEEN.items():
            object.__setattr__(self, name, whole_number(name, getattr(self, name), least, most))
        if self.disparities % 16 or not self.block % 2:
            raise ConfigurationError(
                "disparities are a positive multiple of 16 and the block is odd, got "
                f"{self.disparities} and {self.block}"
            )

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        pair = frame.stereo(self.left, self.right)
        return DisparityMap(
            self.match(pair.left, pair.right), pair_scale(frame, self.left, self.right)
        )

    def match(self, left: Image, right: Image) -> Disparity:
        """Disparities of two images.

        Args:
            left: The left image, shape (H, W, 3).
            right: The same shape.

        Returns:
            Shape (H, W), pixels, NaN where there is no match.
        """
        import cv2

        matcher = cv2.StereoSGBM.create(
            minDisparity=0,
            numDisparities=self.disparities,
            blockSize=self.block,
            P1=8 * self.block**2,
            P2=32 * self.block**2,
            preFilterCap=63,
            uniquenessRatio=self.uniqueness,
            speckleWindowSize=100,
            speckleRange=32,
        )
        grey = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (left, right)]
        found = matcher.compute(*grey).astype(np.float32) / np.float32(_STEPS)
        found[found < 0] = np.nan
        return np.asarray(found)
