"""Where an attacked LiDAR's scan is damaged: bogus points, and directions without returns.

The reference is the depth of a trusted pair of cameras, so that nothing is known of what they do
not see: behind the car, below and above the image, and where their matcher finds nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, Points, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import Sensor
from avsec_gym.validation.evidence.comparison import MIN_DIFFERENCE, MIN_RELATIVE_DIFFERENCE
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.reprojection import Mask, back_projected
from avsec_gym.validation.repair.large_parts import large_parts
from avsec_gym.validation.repair.trusted_view import widest_pair

TrustedMaps = Mapping[int, DisparityMap]
"""Disparity maps by the camera in whose view they are."""
STEP = np.radians(0.2)
"""Bearing and elevation of a direction, radians."""
LOWEST, HIGHEST = np.radians(-25.0), np.radians(3.0)
"""Elevations that a LiDAR of KITTI's kind looks at, radians."""

_ROWS, _COLUMNS = round((HIGHEST - LOWEST) / STEP), round(2 * np.pi / STEP)
_NEAREST = 0.5
_NEIGHBOURS = 32
_SAME_DIRECTION, _SAME_RANGE = np.radians(1.0), 0.05
"""How far neighbours are apart: radians, and share of the range."""
_FEWEST_POINTS = 50
_BETWEEN_BEAMS = 5
"""Directions; beams are nowhere so far apart."""
_SMALLEST_REGION = 100
"""The least number of directions in a damaged region."""
_REACH = 60.0
"""Metres; what is farther often returns nothing anyhow, and cameras do not know it well."""


@dataclass(frozen=True, eq=False)
class DamagedScan:
    """What is wrong with a scan.

    Args:
        points: Whether each point is bogus, shape (M,).
        lost: The directions in which returns are missing, shape (140, 1800): rows from `LOWEST` up,
            columns from behind over the right, ahead and the left, `STEP` by `STEP`.
    """

    points: NDArray[np.bool_]
    lost: Mask

    def is_lost(self, points: Points) -> NDArray[np.bool_]:
        """Which of some points lie in or behind directions without returns, shape (N,)."""
        row, column, inside = directions(points[:, :3].astype(float))
        return inside & self.lost[row, column]


def damaged_scan(
    frame: SensorFrame, trusted: Iterable[Sensor], depth: PairDepth | None = None
) -> DamagedScan:
    """What in a scan contradicts the depth of trusted cameras.

    A point is contradicted where its disparity is outside of what a trusted map has within two
    pixels (equation 3.2), nearer or farther, unless another map confirms it; where most of the
    known points around it are, within a degree and 5 % of its range, it is bogus.  A direction is
    lost where no return is left that is not bogus, though all maps know something within 60 m.

    Args:
        frame: The tampered frame.
        trusted: Sensors that are not attacked, two cameras or more of them.
        depth: How their disparities are found.

    Raises:
        ConfigurationError: Fewer than two trusted cameras.
        DataError: The frame lacks a sensor, or its file is broken.
    """
    maps = trusted_maps(frame, trusted, depth)
    nearest = (depth or PairDepth()).nearest
    bogus = bogus_points(frame.points, frame.calibration, maps, nearest)
    return DamagedScan(bogus, lost_directions(frame.points[~bogus], frame.calibration, maps))


def trusted_maps(
    frame: SensorFrame, trusted: Iterable[Sensor], depth: PairDepth | None = None
) -> TrustedMaps:
    """A map of the trusted cameras farthest apart, and of what is left the same again.

    Args:
        frame: The frame.
        trusted: Sensors, two cameras or more of them.
        depth: How disparities are found.

    Raises:
        ConfigurationError: Fewer than two trusted cameras.
        DataError: The frame lacks a camera, or its file is broken.
    """
    maps: dict[int, DisparityMap] = {}
    left_over = set(trusted)
    while (pair := widest_pair(frame.calibration, sorted(left_over, key=str))) is not None:
        left, right = pair
        estimator = (depth or PairDepth()).estimator(frame.calibration, left, right)
        maps[left] = estimator.disparity(frame)
        left_over -= {left, right}
    if not maps:
        raise ConfigurationError("a LiDAR is checked by two trusted cameras or more")
    return maps


def bogus_points(
    points: Points,
    calibration: Calibration,
    maps: TrustedMaps,
    nearest: float = PairDepth.nearest,
) -> NDArray[np.bool_]:
    """Which points of a scan trusted maps contradict; see `damaged_scan`.

    Args:
        points: The scan, shape (M, 4).
        calibration: The calibration of the rig.
        maps: The disparity maps, by the camera in whose view they are.
        nearest: Depth down to which cameras were matched, metres; a point that is nearer is
            confirmed by what is as near as they can measure.

    Returns:
        Shape (M,).
    """
    # Each map votes on each point that it sees; a confirmation outweighs any contradiction.
    result = np.zeros(len(points), bool)
    every = np.stack(
        [_votes(points, calibration, camera, trusted, nearest) for camera, trusted in maps.items()]
    )
    ahead = np.flatnonzero(points[:, 0] > 0)
    votes = np.where((every < 0).any(axis=0), -1.0, every.max(axis=0))[ahead]
    voters = np.flatnonzero(votes)
    if not len(voters):
        return result
    # The majority of the known points around a point decides.
    places = _as_neighbours(points[ahead, :3].astype(float))
    tree = cKDTree(places[voters])
    _, index = tree.query(places, _NEIGHBOURS, distance_upper_bound=1.0)
    heard = np.append(votes[voters], 0.0)[index]
    suspicious = np.flatnonzero(heard.sum(axis=1) > 0)
    # Small clusters are noise of the matcher.
    result[ahead[suspicious[_in_large_cluster(places[suspicious])]]] = True
    return result


def lost_directions(returns: Points, calibration: Calibration, maps: TrustedMaps) -> Mask:
    """Where nothing came back though trusted maps know something; see `damaged_scan`.

    Args:
        returns: The points of the scan that are not bogus, shape (M, 4).
        calibration: The calibration of the rig.
        maps: The disparity maps, by the camera in whose view they are.

    Returns:
        See `DamagedScan`.
    """
    # Directions with a return, and those between two beams.
    came_back = np.zeros((_ROWS, _COLUMNS), np.uint8)
    row, column, inside = directions(returns[:, :3].astype(float))
    came_back[row[inside], column[inside]] = 1
    between_beams = np.ones((_BETWEEN_BEAMS, _BETWEEN_BEAMS), np.uint8)
    lost = cv2.morphologyEx(came_back, cv2.MORPH_CLOSE, between_beams) == 0
    # Rows above and below all beams are not looked at.
    looked_at = np.flatnonzero(came_back.any(axis=1))
    lost[: looked_at.min(initial=_ROWS)] = False
    lost[looked_at.max(initial=-1) + 1 :] = False
    # Only where all maps expect something is a return missing.
    for camera, trusted in maps.items():
        expected = np.zeros_like(came_back)
        row, column, inside = directions(seen_places(trusted, calibration, camera))
        expected[row[inside], column[inside]] = 1
        # Pixels and directions do not fall on each other one to one.
        lost &= cv2.morphologyEx(expected, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
    # Thin and small regions are borders of objects.
    wide = cv2.morphologyEx(lost.astype(np.uint8), cv2.MORPH_OPEN, between_beams)
    return large_parts(wide > 0, _SMALLEST_REGION)


def seen_places(
    trusted: DisparityMap, calibration: Calibration, camera: int, reach: float = _REACH
) -> Floats:
    """Where the things are that a map knows, in the velodyne frame, shape (N, 3).

    Args:
        trusted: The map.
        calibration: The calibration of the rig.
        camera: The camera in whose view the map is.
        reach: Greatest depth, metres; 60 at most.
    """
    depth = trusted.depth
    known = depth < min(reach, _REACH)
    places = back_projected(np.where(known, depth, 1.0), calibration, camera)[known]
    return transform_points(calibration.camera_to_velodyne, places)


def _votes(
    points: Points, calibration: Calibration, camera: int, trusted: DisparityMap, nearest: float
) -> Floats:
    """Of each point: 1 contradicted, -1 confirmed, 0 not seen; shape (M,)."""
    places = transform_points(calibration.velodyne_to_camera, points[:, :3])
    uv, away = project(calibration.projection(camera), places)
    height, width = trusted.values.shape
    seen = np.flatnonzero(away > _NEAREST)
    pixel = np.round(uv[seen]).astype(np.int64)
    inside = ((pixel >= 0) & (pixel < (width, height))).all(axis=1)
    seen, (column, row) = seen[inside], pixel[inside].T
    around, unknown = np.ones((5, 5), np.uint8), ~trusted.valid
    largest = cv2.dilate(np.where(unknown, np.float32(-1), trusted.values), around)[row, column]
    least = cv2.erode(np.where(unknown, np.float32(np.inf), trusted.values), around)[row, column]
    own = trusted.focal_times_baseline / np.maximum(away[seen], nearest)
    difference = np.maximum(own - largest, least - own)
    allowed = np.maximum(MIN_DIFFERENCE, MIN_RELATIVE_DIFFERENCE * np.minimum(own, largest))
    votes = np.zeros(len(points))
    votes[seen] = np.where(largest < 0, 0.0, np.where(difference > allowed, 1.0, -1.0))
    return votes


def _as_neighbours(places: Floats) -> Floats:
    """Coordinates in which neighbours are less than 1 apart, shape (N, 3)."""
    distance = np.maximum(np.linalg.norm(places, axis=1), 1e-6)
    bearing = np.arctan2(places[:, 1], places[:, 0])
    elevation = np.arcsin(places[:, 2] / distance)
    return np.stack(
        [bearing / _SAME_DIRECTION, elevation / _SAME_DIRECTION, np.log(distance) / _SAME_RANGE],
        axis=1,
    )


def _in_large_cluster(places: Floats) -> NDArray[np.bool_]:
    count = len(places)
    if count == 0:
        return np.zeros(0, bool)
    _, index = cKDTree(places).query(places, min(8, count), distance_upper_bound=1.0)
    index = index.reshape(count, -1)
    rows = np.repeat(np.arange(count), index.shape[1])[index.ravel() < count]
    columns = index.ravel()[index.ravel() < count]
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (count, count))
    _, labels = connected_components(graph, directed=False)
    return np.asarray(np.bincount(labels)[labels] >= _FEWEST_POINTS)


def directions(
    places: Floats,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Row and column of the directions in which places are, and whether they are looked at."""
    elevation = np.arctan2(places[:, 2], np.hypot(places[:, 0], places[:, 1]))
    bearing = np.arctan2(places[:, 1], places[:, 0])
    row = np.floor((elevation - LOWEST) / STEP).astype(np.int64)
    inside = (row >= 0) & (row < _ROWS)
    column = np.floor((bearing + np.pi) / STEP).astype(np.int64) % _COLUMNS
    return np.clip(row, 0, _ROWS - 1), column, inside
