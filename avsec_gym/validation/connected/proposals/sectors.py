"""`SectorProposer`: PointRCNN's first stage, made to look all around (thesis, section 4.4.2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, Points, SensorFrame
from avsec_gym.geometry import Floats, transform_points, wrap_angle
from avsec_gym.perception.detectors.pixor.upright_boxes import seen_from_above
from avsec_gym.perception.detectors.pointrcnn.detector import PointRcnnDetector
from avsec_gym.perception.nn.rotated_nms import rotated_nms
from avsec_gym.rig import kitti_rig
from avsec_gym.validation.connected.regions import Regions


@dataclass(frozen=True, eq=False)
class SectorProposer:
    """Proposals of a network that sees the camera's view only: the scan is turned into it.

    The scan is turned about the sensor's upright axis by one sector after the other, so that each
    part of it comes into view as if it were ahead; proposals are turned back. Sectors narrower than
    the view overlap, and what stands on their border is in one of them whole.

    Args:
        detector: The network, with weights.
        sectors: Number of sectors; PointRCNN without an image sees 80 degrees, so 6 overlap.
        least_score: Proposals that are less sure are left out.
        most_overlap: Intersection over union, from above, of two regions that may both stay.
        calibration: Places the sensor among the cameras, as in the network's training data.

    Raises:
        ConfigurationError: Too few sectors to look all around.
    """

    detector: PointRcnnDetector
    sectors: int = 6
    least_score: float = 0.1
    most_overlap: float = 0.2
    calibration: Calibration = field(default_factory=lambda: kitti_rig().calibration)

    def __post_init__(self) -> None:
        if self.sectors < 5:
            raise ConfigurationError(
                f"5 sectors of 80 degrees or more look all around, got {self.sectors}"
            )

    def __call__(self, points: Points) -> Regions:
        """The regions of a scan, velodyne frame, surest first. See `RegionProposer`."""
        found = [
            self._in_sector(points, 2 * np.pi * sector / self.sectors)
            for sector in range(self.sectors)
        ]
        boxes = np.concatenate([rows for rows, _ in found])
        scores = np.concatenate([score for _, score in found])
        kept = rotated_nms(boxes[:, [0, 1, 3, 4, 6]], scores, self.most_overlap)
        x, y, z, length, width, height, heading = boxes[kept].T
        return Regions(
            np.stack([x, y, z], axis=1), np.stack([length, width, height], axis=1), heading
        )

    def _in_sector(self, points: Points, middle: float) -> tuple[Floats, Floats]:
        """Boxes (M, 7) as x, y, z, length, width, height, heading, and scores of one sector."""
        cos, sin = np.cos(middle), np.sin(middle)
        turned = points.copy()
        turned[:, 0] = cos * points[:, 0] + sin * points[:, 1]
        turned[:, 1] = cos * points[:, 1] - sin * points[:, 0]
        frame = SensorFrame("sector", self.calibration, scan=turned)
        try:
            proposed = self.detector.propose(frame)
        except DataError:
            # Nothing came back from this sector.
            return np.zeros((0, 7)), np.zeros(0)
        proposed = proposed[proposed.score >= self.least_score]
        x, y, length, width, heading = seen_from_above(proposed, self.calibration).T
        bottom = transform_points(self.calibration.camera_to_velodyne, proposed.location)[:, 2]
        boxes = np.stack(
            [
                cos * x - sin * y,
                sin * x + cos * y,
                bottom,
                length,
                width,
                proposed.dimensions[:, 0],
                wrap_angle(heading + middle),
            ],
            axis=1,
        )
        return boxes, proposed.score
