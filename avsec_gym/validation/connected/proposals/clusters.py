"""`ClusterProposer`: regions without a network, for vehicles that have no time for one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Points
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.proposals.ground_map import ground_map
from avsec_gym.validation.connected.proposals.rectangle_fit import fitted_rectangle
from avsec_gym.validation.connected.regions import Regions

_CELL = 0.2
_CAR_LENGTH, _CAR_WIDTH, _CAR_HEIGHT = 4.0, 1.7, 1.5
_NARROWEST_CAR = 1.2
"""Metres: what shows no side as long as this is a person, or a cyclist from behind."""
_WIDEST_CAR = 2.2
"""Metres: a side that is longer is no end of a car, but its long side."""
_SMALLEST = 0.6


@dataclass(frozen=True)
class ClusterProposer:
    """Whatever stands up on the ground and is about as large as something on the road.

    Points above the ground map that touch, seen from above, are one cluster; a rectangle is fitted
    to each, and what is as wide as a car becomes as long as one, away from the sensor, which sees
    its near sides only. What is longer than `longest`, such as a wall or a hedge, gives no region;
    neither does what is shorter than `shortest`, or higher than `tallest`. The defaults look for
    cars and vans, as the network does; a shortest of 0.1 finds people, too, and a tallest of 4
    trucks, and both more bushes and poles.

    Args:
        lowest: Points lower above the ground belong to it, metres.
        headroom: Points higher above the ground are driven under, metres.
        tallest: Clusters whose top is higher are left out, metres.
        shortest: Clusters whose longer side is shorter are left out, metres.
        reach: How far it looks, metres.
        fewest: Points of a cluster.
        least_height: Clusters whose top is lower are kerbs and grass, metres.
        longest: Clusters with a greater extent along x or y are left out, metres.

    Raises:
        ConfigurationError: A number is not positive.
    """

    lowest: float = 0.3
    headroom: float = 4.5
    tallest: float = 2.3
    shortest: float = 1.2
    reach: float = 60.0
    fewest: int = 5
    least_height: float = 0.5
    longest: float = 7.0

    def __post_init__(self) -> None:
        numbers = (self.lowest, self.headroom, self.reach, self.fewest, self.longest)
        if not all(0 < number < np.inf for number in numbers):
            raise ConfigurationError(f"all numbers of a proposer are positive, got {self}")

    def __call__(self, points: Points) -> Regions:
        """The regions of a scan, velodyne frame. See `RegionProposer`."""
        places = np.asarray(points[:, :3], np.float64)
        inside = (np.abs(places[:, :2]) < self.reach).all(axis=1) & np.isfinite(places[:, 2])
        places = places[inside]
        if not len(places):
            return Regions.empty()
        ground = ground_map(places, self.reach)
        above = places[:, 2] - ground.height(places[:, :2])
        stands = (above > self.lowest) & (above < self.headroom)
        boxes = []
        for cluster in self._clusters(np.c_[places[stands, :2], above[stands]]):
            top = float(cluster[:, 2].max())
            if len(cluster) < self.fewest or not self.least_height <= top <= self.tallest:
                continue
            seen = fitted_rectangle(cluster[:, :2])
            if seen[2] >= self.shortest:
                boxes.append(_whole_object(seen, top))
        if not boxes:
            return Regions.empty()
        x, y, length, width, heading, height = np.array(boxes).T
        centre = np.stack([x, y, ground.height(np.stack([x, y], axis=1))], axis=1)
        return Regions(centre, np.stack([length, width, height], axis=1), heading)

    def _clusters(self, points: Floats) -> Iterator[Floats]:
        """Points (x, y, height above the ground) that touch each other, shape (M, 3) each."""
        if not len(points):
            return
        cells = np.floor((points[:, :2] + self.reach) / _CELL).astype(int)
        occupied = np.zeros(cells.max(axis=0) + 1, bool)
        occupied[cells[:, 0], cells[:, 1]] = True
        # Cells that touch at a corner are joined.
        labels, _ = ndimage.label(occupied, np.ones((3, 3)))
        for cluster in _grouped(points, labels[cells[:, 0], cells[:, 1]]):
            if np.ptp(cluster[:, :2], axis=0).max() <= self.longest:
                yield cluster


def _grouped(points: Floats, key: NDArray[np.int_]) -> list[Floats]:
    """The points that have the same key, together."""
    order = np.argsort(key, kind="stable")
    return np.split(points[order], np.flatnonzero(np.diff(key[order])) + 1)


def _whole_object(rectangle: Floats, height: float) -> tuple[float, ...]:
    """The box of the object of which a rectangle is the part that the sensor sees.

    Args:
        rectangle: x, y, length, width, heading of what is seen; the sensor is at the origin.
        height: The top of the cluster above the ground, metres.

    Returns:
        x, y, length, width, heading, height.
    """
    x, y, length, width, heading = rectangle.tolist()
    if length < _NARROWEST_CAR:
        return x, y, max(length, _SMALLEST), max(width, _SMALLEST), heading, height
    if length < _WIDEST_CAR:
        # The end of a car: what is seen as long is its width.
        length, width, heading = width, length, heading + np.pi / 2
    whole = np.array([max(length, _CAR_LENGTH), max(width, _CAR_WIDTH)])
    axes = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    # The near sides stay where they are, the far ones move away from the sensor.
    away = np.where(axes @ [x, y] >= 0, 1.0, -1.0)
    x, y = np.array([x, y]) + (away * (whole - [length, width]) / 2) @ axes
    return x, y, whole[0], whole[1], heading, max(height, _CAR_HEIGHT)
