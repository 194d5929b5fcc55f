"""A stereo detector without a network: what stands up in the depths of the left image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.perception.detectors.boxes_in_view import boxes_in_view

CELL, NEAREST, ASIDE = 0.5, 4.0, 20.0
"""Side of a cell seen from above, and how near and how far to the side they are looked at, m."""
CAR = (1.5, 1.7, 4.0)
"""Height, width and length that every box has at least, m; the camera sees only a car's rear."""


@dataclass(frozen=True)
class StereoClusters:
    """Every group of touching cells with enough pixels above the road is a car.

    Args:
        ahead: How far it looks, metres.
        fewest: Pixels of a cell.
        disparities: Disparities that are searched, a multiple of 16.
    """

    name: ClassVar[str] = "stereo_clusters"
    ahead: float = 40.0
    fewest: int = 20
    disparities: int = 128

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The groups of a frame; surer, the more pixels they have."""
        z = SemiGlobalMatching(disparities=self.disparities).disparity(frame).depth
        projection = frame.calibration.projection(2)
        v, u = np.nonzero((z > NEAREST) & (z < self.ahead))
        z = z[v, u]
        x = ((u - projection[0, 2]) * z - projection[0, 3]) / projection[0, 0]
        y = (v - projection[1, 2]) * z / projection[1, 1]
        upright = (y > -0.5) & (y < 1.3) & (np.abs(x) < ASIDE)  # The road is 1.65 m below.
        edges = np.arange(NEAREST, self.ahead, CELL), np.arange(-ASIDE, ASIDE, CELL)
        pixels, _, _ = np.histogram2d(z[upright], x[upright], edges)
        full = (pixels >= self.fewest).astype(np.uint8)
        _, groups, found, _ = cv2.connectedComponentsWithStats(full)
        count = np.bincount(groups.ravel(), pixels.ravel(), len(found))[1:]
        left, near, width, depth, _ = found[1:].T
        size = np.maximum(np.stack([0 * width, CELL * width, CELL * depth], axis=1), CAR)
        middle = edges[1][left] + CELL * width / 2
        far = edges[0][near] + size[:, 2] / 2
        place, yaw = np.stack([middle, 0 * far + 1.65, far], 1), 0 * far - np.pi / 2
        score, shape = count / (count + 100), frame.image(2).shape[:2]
        return boxes_in_view(place, size, yaw, score, "Car", frame.calibration, shape)
