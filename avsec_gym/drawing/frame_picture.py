"""Pictures of sensor frames, real or procedural: one with all its sensors, or many at once."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, Image, SensorFrame
from avsec_gym.geometry import box_corners, project, rectangle_corners, transform_points

_SIDES = ((0, 1), (1, 2), (2, 3), (3, 0))
_EDGES = (*_SIDES, *((a + 4, b + 4) for a, b in _SIDES), *((i, i + 4) for i in range(4)))
_COLOURS = {
    "Car": (60, 220, 90),
    "Van": (40, 200, 200),
    "Truck": (80, 140, 255),
    "Pedestrian": (255, 90, 90),
    "Person_sitting": (255, 90, 90),
    "Cyclist": (255, 190, 40),
}
_OTHER = (220, 120, 255)
_NEAR = 0.3
_SURFACES = np.array(
    [
        (70, 130, 180),
        (128, 64, 128),
        (160, 120, 160),
        (200, 80, 80),
        (244, 35, 232),
        (196, 196, 196),
        (120, 190, 90),
        (150, 200, 120),
        (100, 85, 75),
        (60, 120, 30),
        (240, 220, 60),
        (30, 60, 200),
        (230, 40, 60),
    ],
    np.uint8,
)


def contact_sheet(images: Sequence[Image], *, columns: int = 4, width: int = 480) -> Image:
    """Many frames in a grid.

    Args:
        images: Images, one for each frame.
        columns: Number of columns of the grid.
        width: Width of a frame in it, pixels.
    """
    height = round(width * images[0].shape[0] / images[0].shape[1])
    tiles = [cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA) for image in images]
    tiles += [np.full((height, width, 3), 255, np.uint8)] * (-len(tiles) % columns)
    gap = 6
    rows = []
    for start in range(0, len(tiles), columns):
        row = [
            np.pad(tile, ((0, gap), (0, gap), (0, 0)), constant_values=255)
            for tile in tiles[start : start + columns]
        ]
        rows.append(np.concatenate(row, axis=1))
    return np.ascontiguousarray(np.concatenate(rows)[:-gap, :-gap])


def frame_picture(
    frame: SensorFrame,
    boxes: Boxes3D | None = None,
    disparity: NDArray[np.float32] | None = None,
    surfaces: NDArray[np.uint8] | None = None,
    *,
    camera: int = 2,
    partner: int = 3,
) -> Image:
    """A frame with whatever it has: images, labels, depth, LiDAR, surfaces, and a view from above.

    Args:
        frame: Images and scan; what is missing is left out.
        boxes: Labels, drawn as 3D boxes and from above.
        disparity: Disparity of the camera, pixels, NaN where unknown, shape (H, W).
        surfaces: `avsec_gym.world.site.Surface` of each pixel, shape (H, W).
        camera: The reference camera.
        partner: The other camera of the pair.
    """
    calibration = frame.calibration
    left = frame.image(camera)
    panels = [titled(with_boxes(left, boxes, calibration, camera), f"camera {camera}, labels")]
    if partner in frame.images:
        panels.append(titled(frame.image(partner), f"camera {partner}"))
    if disparity is not None:
        panels.append(titled(depth_picture(disparity), "disparity"))
    if frame.has_points:
        shown = points_in_image(left, frame, camera)
        panels.append(titled(shown, "LiDAR in the image, colour by distance"))
    if surfaces is not None:
        panels.append(titled(surface_picture(left, surfaces), "surfaces"))
    column = np.concatenate(panels)
    if not frame.has_points:
        return column
    above = titled(view_from_above(frame, boxes, column.shape[0]), "LiDAR from above")
    return np.concatenate([column, above], axis=1)


def with_boxes(image: Image, boxes: Boxes3D | None, calibration: Calibration, camera: int) -> Image:
    """An image with 3D boxes; the front face is crossed."""
    result = image.copy()
    if boxes is None:
        return result
    every = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    projection = calibration.projection(camera)
    for corners, category in zip(every, boxes.category, strict=True):
        colour = _COLOURS.get(str(category), _OTHER)
        lines = [(corners[a], corners[b]) for a, b in _EDGES]
        lines += [(corners[0], corners[7]), (corners[3], corners[4])]
        for start, end in lines:
            _line(result, start, end, projection, colour)
    return result


def depth_picture(disparity: NDArray[np.float32]) -> Image:
    """Disparities as colours, near ones warm; unknown is black."""
    known = np.isfinite(disparity) & (disparity > 0)
    share = np.zeros(disparity.shape)
    share[known] = np.clip(np.log(disparity[known] / 2.0) / np.log(60.0), 0.0, 1.0)
    picture = (_colours(share) * known[..., None]).astype(np.uint8)
    return np.ascontiguousarray(picture)


def surface_picture(image: Image, surfaces: NDArray[np.uint8]) -> Image:
    """An image in the colours of what its pixels show; see `frame_picture`."""
    coloured = _SURFACES[np.minimum(surfaces, len(_SURFACES) - 1)]
    return (0.45 * image + 0.55 * coloured).astype(np.uint8)


def points_in_image(image: Image, frame: SensorFrame, camera: int) -> Image:
    """LiDAR points over a darkened image."""
    points = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
    pixels, depth = project(frame.calibration.projection(camera), points)
    height, width = image.shape[:2]
    seen = (depth > 1.0) & (pixels >= 0).all(1) & (pixels[:, 0] < width) & (pixels[:, 1] < height)
    pixels, depth = pixels[seen], depth[seen]
    result = (0.45 * image).astype(np.uint8)
    colours = _colours(np.clip(1.0 - np.log(depth / 3.0) / np.log(25.0), 0.0, 1.0))
    for index in np.argsort(-depth):
        u, v = pixels[index]
        cv2.circle(result, (int(u), int(v)), 1, colours[index].tolist(), -1)
    return result


def view_from_above(frame: SensorFrame, boxes: Boxes3D | None, height: int) -> Image:
    """The scan on the ground plane, 60 m ahead and 15 m behind, with the boxes' footprints."""
    scale = height / 75.0
    width = int(46 * scale)
    result = np.full((height, width, 3), 18, np.uint8)

    def place(x: NDArray[np.floating], y: NDArray[np.floating]) -> NDArray[np.int64]:
        across, down = 0.5 * width - y * scale, height - (x + 15.0) * scale
        return np.stack([across, down], axis=-1).astype(np.int64)

    camera = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
    spots = place(camera[:, 2], -camera[:, 0])
    inside = (spots >= 0).all(1) & (spots[:, 0] < width) & (spots[:, 1] < height)
    level = np.clip((1.9 - camera[inside, 1]) / 3.0, 0.0, 1.0)
    result[spots[inside, 1], spots[inside, 0]] = _colours(0.15 + 0.8 * level)
    if boxes is not None:
        corners = rectangle_corners(boxes.poses, boxes.length, boxes.width)
        for outline, category in zip(corners, boxes.category, strict=True):
            colour = _COLOURS.get(str(category), _OTHER)
            line = place(outline[:, 0], outline[:, 1]).astype(np.int32)
            cv2.polylines(result, [line], True, colour, 2, cv2.LINE_AA)
            nose = line[[0, 3]].mean(axis=0), line.mean(axis=0)
            cv2.line(result, nose[0].astype(int).tolist(), nose[1].astype(int).tolist(), colour, 2)
    return result


def titled(image: Image, title: str) -> Image:
    """A copy of an image with words in its upper left corner."""
    result = image.copy()
    # A dark rim: the same thin letters moved, since thick ones are wider.
    for right, down in ((-1, 0), (1, 0), (0, -1), (0, 1), (1, 1)):
        _letters(result, title, (10 + right, 22 + down), (0, 0, 0))
    _letters(result, title, (10, 22), (255, 255, 255))
    return result


def _letters(image: Image, text: str, place: tuple[int, int], colour: tuple[int, ...]) -> None:
    cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 1, cv2.LINE_AA)


def _line(image: Image, start, end, projection, colour) -> None:  # type: ignore[no-untyped-def]
    """A line in space, cut off before the camera."""
    low, high = sorted((start, end), key=lambda point: point[2])
    if high[2] < _NEAR:
        return
    if low[2] < _NEAR:
        low = low + (high - low) * (_NEAR - low[2]) / (high[2] - low[2])
    pixels, _ = project(projection, np.stack([low, high]))
    one, two = np.clip(pixels, -5000, 5000).astype(int).tolist()
    cv2.line(image, one, two, colour, 1, cv2.LINE_AA)


def _colours(share: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Of the turbo map, shape (..., 3)."""
    return (matplotlib.colormaps["turbo"](share)[..., :3] * 255).astype(np.uint8)
