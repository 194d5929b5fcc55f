"""True disparities, where a data set has them: those of the procedural world do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from avsec_gym.argument_checks import camera_number
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import read_disparity
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale


@dataclass(frozen=True)
class GroundTruthDepth:
    """The file of ``disparity_2`` beside a frame's image."""

    name: ClassVar[str] = "ground_truth"
    left: int = 2
    """Reference camera."""
    right: int = 3
    """The other one of the pair for which the file was written."""

    def __post_init__(self) -> None:
        camera_number("left", self.left)
        camera_number("right", self.right)

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        if frame.origin is None:
            raise DataError(
                f"Frame {frame.id} comes from no folder, so there is no true disparity of it.",
                remedy="Read it by KittiObject.",
            )
        path = frame.origin / f"disparity_{self.left}" / f"{frame.id}.png"
        if not path.is_file():
            raise DataError(
                f"Frame {frame.id} has no true disparity.",
                path=path,
                remedy="`avsec world make` writes them; real frames have none.",
            )
        return DisparityMap(read_disparity(path), pair_scale(frame, self.left, self.right))
