"""Which pixels of a stereo pair show the road, and which its side area, with their disparities.

The side areas of a road are all that stands or lies beside it: pavement, kerb, verge, terrain,
parking bays, cycle paths, and, if asked for, what rises there (buildings, plants, furniture).
Sky, vehicles and persons are neither road nor side area.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import box_corners, project, transform_points
from avsec_gym.kitti.map_files import read_disparity, read_mask
from avsec_gym.world.site import Surface

Mask = NDArray[np.bool_]

GROUND = (
    Surface.PARKING,
    Surface.CYCLE_PATH,
    Surface.PAVEMENT,
    Surface.KERB,
    Surface.VERGE,
    Surface.TERRAIN,
)
"""What lies beside the road."""
EVERYTHING = (*GROUND, Surface.BUILDING, Surface.VEGETATION, Surface.FURNITURE)
"""And what stands there."""

_INFINITELY_FAR = np.float32(1e-3)
"""Pixels of disparity that the sky gets."""
_STANDING = 0.3
"""Metres above the ground at which a LiDAR point belongs to something that stands."""
_FARTHEST = 60.0
"""Metres up to which a plane is taken for the ground of a real frame."""


@dataclass(frozen=True, eq=False)
class RoadView:
    """What one image shows.

    Args:
        road: Whether each pixel shows the road, shape (H, W).
        side: Whether each pixel lies in the side area beside the road, shape (H, W).
        disparity: Disparity between the pair, pixels, float32, shape (H, W); 0 where unknown.
    """

    road: Mask
    side: Mask
    disparity: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Roadside:
    """Road and side area in both images of a pair."""

    left: RoadView
    right: RoadView


def read_roadside(folder: str | Path, id: str, side: tuple[Surface, ...] = EVERYTHING) -> Roadside:
    """Road and side area of a frame of the procedural world.

    Args:
        folder: The object layout's folder, such as ``training``, with ``surface_2`` and
            ``disparity_2``.
        id: Id of the frame, six digits.
        side: Surfaces that belong to the side area.

    Raises:
        DataError: A map is missing or broken, or the two differ in size.
    """
    path = Path(folder) / "surface_2" / f"{id}.png"
    surface = read_mask(path)
    disparity = read_disparity(Path(folder) / "disparity_2" / f"{id}.png")
    if surface.shape != disparity.shape:
        raise DataError(
            f"The surfaces have shape {surface.shape}, the disparities {disparity.shape}.",
            path=path,
            remedy="Both maps belong to the left image; make the data set anew.",
        )
    return roadside_of_surfaces(surface, disparity, side)


def roadside_of_surfaces(
    surface: NDArray[np.integer],
    disparity: NDArray[np.float32],
    side: tuple[Surface, ...] = EVERYTHING,
) -> Roadside:
    """Road and side area from what each pixel of the left image shows.

    The right image gets what the left one sees of it; what only the right camera sees is taken
    for a continuation of the farther of the two surfaces beside it.

    Args:
        surface: `Surface` of each pixel of the left image, shape (H, W).
        disparity: Disparity of the left image, pixels, 0 or NaN where unknown, shape (H, W).
        side: Surfaces that belong to the side area.
    """
    known = np.where(disparity > 0, disparity, np.float32(0))
    known[surface == Surface.SKY] = _INFINITELY_FAR
    rows, source = np.arange(len(known))[:, None], _seen_from_right(known)
    views = []
    for surfaces, disparities in ((surface, known), (surface[rows, source], known[rows, source])):
        views.append(RoadView(surfaces == Surface.ROAD, np.isin(surfaces, side), disparities))
    return Roadside(*views)


def straight_roadside(
    frame: SensorFrame,
    objects: Boxes3D | None = None,
    *,
    road: tuple[float, float] = (-4.0, 4.0),
    camera_height: float = 1.65,
) -> Roadside:
    """Road and side area of a real frame: a plane, and a straight road ahead on it.

    With a LiDAR scan the plane is fitted to it, and what rises above the plane is left out;
    without, the camera looks along the plane. Only the ground is found, up to 60 m.

    Args:
        frame: A stereo pair.
        objects: Objects that stand on the ground: neither road nor side area.
        road: First and last place of the road across, metres to the right of the left camera.
        camera_height: Height of the camera above the ground, metres, where no scan shows it.

    Raises:
        ConfigurationError: The road has no width, or the camera no height.
        DataError: An image is missing or broken.
    """
    if not (road[0] < road[1] and camera_height > 0):
        raise ConfigurationError(
            f"a road runs from left to right, below the camera, got {road}, {camera_height} m"
        )
    points = None
    height, slope = camera_height, 0.0
    if frame.has_points:
        points = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
        height, slope = _fitted_plane(points, camera_height)
        points = points[points[:, 1] < height + slope * points[:, 2] - _STANDING]
    views = []
    for camera in (LEFT, RIGHT):
        shape = frame.image(camera).shape[:2]
        x, depth = _plane_places(frame.calibration, camera, shape, height, slope)
        ground = (depth > 0) & (depth < _FARTHEST)
        ground &= ~_standing(frame.calibration, camera, shape, objects, points)
        on_road = (x >= road[0]) & (x <= road[1])
        depth = np.where(ground, depth, 1.0)
        disparity = np.where(ground, _disparity(frame.calibration, camera, depth), 0.0)
        views.append(RoadView(ground & on_road, ground & ~on_road, disparity.astype(np.float32)))
    return Roadside(*views)


def _seen_from_right(disparity: NDArray[np.float32]) -> NDArray[np.intp]:
    """Column of the left image that shows what each pixel of the right one does, shape (H, W).

    What only the right camera sees gets the farther of the two neighbours in its row.
    """
    height, width = disparity.shape
    row, column = np.nonzero(disparity > 0)
    # What is nearer is written later, and stays.
    order = np.argsort(disparity[row, column], kind="stable")
    row, column = row[order], column[order]
    place = column - disparity[row, column]
    source = np.full((height, width + 1), -1)
    # A surface that looks wider from the right would have gaps if each pixel hit only one.
    targets = np.stack([np.floor(place), np.ceil(place)], axis=1).astype(int)
    source[row[:, None], np.where(targets >= 0, targets, width)] = column[:, None]
    # Of one surface the pixel that hits best.
    target = np.where(place >= -0.5, np.rint(place), width).astype(int)
    hidden = disparity[row, source[row, target]] > disparity[row, column] + 1
    source[row[~hidden], target[~hidden]] = column[~hidden]
    return _filled(source[:, :width], disparity)


def _filled(source: NDArray[np.intp], disparity: NDArray[np.float32]) -> NDArray[np.intp]:
    """Columns of the left image, where unknown (-1) those of the farther neighbour in the row."""
    width = source.shape[1]
    rows, columns = np.arange(len(source))[:, None], np.arange(width)
    known = source >= 0
    before = np.maximum.accumulate(np.where(known, columns, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, columns, width)[:, ::-1], axis=1)[:, ::-1]
    beside = np.pad(source, ((0, 0), (1, 1)), constant_values=-1)
    distance = np.where(beside >= 0, disparity[rows, beside], np.inf)
    nearer = distance[rows, before + 1] > distance[rows, after + 1]
    filled = np.where(nearer, beside[rows, after + 1], beside[rows, before + 1])
    # A row in which nothing is known stays as it is.
    return np.where(filled >= 0, filled, columns)


def _fitted_plane(points: NDArray[np.float64], height: float) -> tuple[float, float]:
    """Height and slope of y = height + slope z through a scan's ground, camera frame."""
    x, y, z = points.T
    near = (np.abs(x) < 8) & (z > 4) & (z < 35)
    slope = 0.0
    for reach in (0.5, 0.25, 0.1):  # Metres beside the last plane; narrower as it gets better.
        ground = near & (np.abs(y - height - slope * z) < reach)
        if ground.sum() < 100:
            break
        slope, height = (float(value) for value in np.polyfit(z[ground], y[ground], 1))
    return height, slope


def _plane_places(
    calibration: Calibration, camera: int, shape: tuple[int, ...], height: float, slope: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where pixels see the plane: x from the left camera and depth, metres; depth < 0 above it."""
    p = calibration.projection(camera)
    v, u = np.indices(shape, dtype=float)
    # v (z + t_z) = f (height + slope z) + c z + p_13 of a point of the plane, and the camera sees
    # it at z + t_z.
    with np.errstate(divide="ignore"):
        z = (p[1, 1] * height + p[1, 3] - v * p[2, 3]) / (v - p[1, 2] - p[1, 1] * slope)
    depth = z + p[2, 3]
    centres = [calibration.camera_centre(each)[0] for each in (camera, LEFT)]
    return (u - p[0, 2]) * depth / p[0, 0] + centres[0] - centres[1], depth


def _disparity(
    calibration: Calibration, camera: int, depth: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Columns between the two views of what a camera's pixels see at a depth, shape (H, W)."""
    parallax = calibration.focal_length(LEFT) * calibration.baseline(LEFT, RIGHT)
    # u_l w_l - u_r w_r is the same for all points; the depths w differ by what one camera is ahead.
    ahead = calibration.projection(RIGHT)[2, 3] - calibration.projection(LEFT)[2, 3]
    u = np.arange(depth.shape[1])
    return (u * ahead + parallax) / (depth + ahead if camera == LEFT else depth - ahead)


def _standing(
    calibration: Calibration,
    camera: int,
    shape: tuple[int, ...],
    objects: Boxes3D | None,
    points: NDArray[np.float64] | None,
) -> Mask:
    """Pixels of objects, and of points above the ground."""
    covered: NDArray[Any] = np.zeros(shape, np.uint8)
    if points is not None:
        pixels, depth = project(calibration.projection(camera), points)
        inside = (depth > 1) & ((pixels >= 0) & (pixels < shape[::-1])).all(1)
        u, v = pixels[inside].astype(int).T
        covered[v, u] = 1
        # Lines of a scan lie up to some ten pixels apart.
        covered = cv2.morphologyEx(covered, cv2.MORPH_CLOSE, np.ones((15, 9), np.uint8))
        covered = cv2.dilate(covered, np.ones((9, 5), np.uint8))
    if objects is not None:
        there = objects[objects.category != "DontCare"]
        corners = box_corners(there.location, there.dimensions, there.rotation_y)
        for each in corners[(corners[..., 2] > 0.5).all(1)]:
            pixels, _ = project(calibration.projection(camera), each)
            outline = cv2.convexHull(np.clip(pixels, -5000, 5000).astype(np.int32))
            cv2.fillConvexPoly(covered, outline, 1)
    return covered > 0
