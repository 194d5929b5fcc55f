"""`ScanObstacles`: whatever stands up in a LiDAR scan, without a network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, whole_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.upright_boxes import (
    LIDAR_HEIGHT,
    ground_heights,
    upright_boxes,
)

_CATEGORY = "Misc"
_OBJECT_HEIGHT = 1.5
_CELL = 0.2
_TILE = 4.0
_SURE = 10.0
_LEAST = 0.001
_MOST = {"step": 10.0, "ahead": 300.0, "aside": 300.0, "headroom": 100.0}
"""Metres: no LiDAR of a car sees farther, and a grid of it fits into any memory."""
_MOST_POINTS = 10**7


@dataclass(frozen=True)
class ScanObstacles:
    """The elevation map of an early autonomous car: where a cell's points differ in height.

    A cell of 0.2 m stands up if its points, those below the top of the car, are `step` apart in
    height; cells that touch, or have one between them, are one obstacle, with the smallest
    rectangle around it as its box.  What is longer than 8 m is reported in pieces of 4 m, so that a
    hedge around a bend is no box across the road.  Every obstacle is of KITTI's class Misc, as
    nothing here knows a car from a wall, and surer the more points it has: n / (n + 10).  Of a car
    only the sides that the LiDAR sees are boxed.  After Thrun et al., "Stanley: the robot that won
    the DARPA grand challenge", 2006, section 5.1, without its model of the sensor's noise.

    Args:
        step: The length of a step, metres.
        ahead: How far it looks, metres.
        aside: The distance to either side, metres.
        headroom: What hangs higher above a flat road is driven under, metres.
        fewest: Points of an obstacle.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    name: ClassVar[str] = "scan_obstacles"
    step: float = 0.3
    ahead: float = 50.0
    aside: float = 20.0
    headroom: float = 2.0
    fewest: int = 5

    def __post_init__(self) -> None:
        for name, most in _MOST.items():
            object.__setattr__(self, name, number(name, getattr(self, name), _LEAST, most))
        object.__setattr__(self, "fewest", whole_number("fewest", self.fewest, 1, _MOST_POINTS))

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The obstacles of a frame that camera 2 shows, if there is one.

        Raises:
            DataError: The frame has no LiDAR scan.
        """
        points = frame.points
        x, y, z = points[:, :3].T
        near = (x > 0) & (x < self.ahead) & (np.abs(y) < self.aside)
        seen = points[near & (z < self.headroom - LIDAR_HEIGHT)]
        pieces = list(self._pieces(seen))
        rectangles = np.array([_rectangle(piece) for piece in pieces]).reshape(-1, 5)
        count = np.array([len(piece) for piece in pieces], float)
        return upright_boxes(
            rectangles,
            ground_heights(points, rectangles),
            count / (count + _SURE),
            _CATEGORY,
            _OBJECT_HEIGHT,
            frame.calibration,
            frame.image(2).shape[:2] if 2 in frame.images else None,
        )

    def _pieces(self, points: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """The places of each obstacle's points, shape (n, 2)."""
        import cv2

        row = (points[:, 0] / _CELL).astype(int)
        column = ((points[:, 1] + self.aside) / _CELL).astype(int)
        shape = (int(self.ahead / _CELL) + 1, int(2 * self.aside / _CELL) + 1)
        low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
        np.minimum.at(low, (row, column), points[:, 2])
        np.maximum.at(high, (row, column), points[:, 2])
        stands = (high - low > self.step).astype(np.uint8)
        joined = cv2.morphologyEx(stands, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
        _, labels = cv2.connectedComponents(joined)
        label = labels[row, column]
        # Not the road at its foot, which would make it larger.
        above = points[:, 2] > low[row, column] + self.step / 2
        of_obstacle = above & (stands[row, column] > 0)
        places, label = points[of_obstacle, :2], label[of_obstacle]
        for group in _groups(places, label):
            if max(np.ptp(group, axis=0)) <= 2 * _TILE:
                parts = [group]
            else:
                tiles = np.floor(group / _TILE).astype(int)
                parts = list(_groups(group, tiles[:, 0] * 1000 + tiles[:, 1]))
            yield from (part for part in parts if len(part) >= self.fewest)


def _groups(values: NDArray[np.float32], key: NDArray[np.int_]) -> list[NDArray[np.float32]]:
    """The rows that have the same key, together."""
    order = np.argsort(key, kind="stable")
    return np.split(values[order], np.flatnonzero(np.diff(key[order])) + 1) if len(key) else []


def _rectangle(places: NDArray[np.float32]) -> Floats:
    """The smallest around some places: x, y, length, width, heading; a cell wide at least."""
    import cv2

    (x, y), (first, second), angle = cv2.minAreaRect(places)
    if first < second:
        first, second, angle = second, first, angle + 90.0
    sides = np.maximum([first, second], _CELL)
    return np.array([x, y, *sides, np.radians(angle)])
