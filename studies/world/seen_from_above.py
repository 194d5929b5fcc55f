"""Pictures from above: a layout, and what connected vehicles see together."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.drawing.connected_picture import VEHICLE_COLOURS
from avsec_gym.drawing.frame_picture import titled
from avsec_gym.frame import Image
from avsec_gym.geometry import Floats, rectangle_corners, transform_points
from avsec_gym.world.capture import Scan
from avsec_gym.world.export import SEEN_POINTS
from avsec_gym.world.layouts import SceneLayout
from avsec_gym.world.posed_scenes import PosedScene

Colour = tuple[int, int, int]

_DARK, _LANE = 18, (70, 70, 70)
_STANDS, _MOVES, _EGO = (120, 170, 220), (255, 170, 60), (255, 255, 255)
_BY_VEHICLES: dict[int, Colour] = {0: (90, 90, 90), 1: (235, 235, 235), 2: (255, 220, 40)}
"""Outlines of objects by how many vehicles see them; two stands for more."""
_GROUND, _ABOVE = 0.25, 3.0
"""Metres between which a point counts as one of what stands on the ground."""
_DIM = 0.3


class FromAbove:
    """A dark picture of the ground, the first vehicle looking to the right.

    Args:
        size: Width and height, pixels.
        corner: Metres ahead and to the left of the vehicle of the picture's upper left corner.
        scale: Pixels per metre.
    """

    def __init__(self, size: tuple[int, int], corner: tuple[float, float], scale: float) -> None:
        self.image: Image = np.full((size[1], size[0], 3), _DARK, np.uint8)
        self._corner, self._scale = np.array(corner), scale

    def line(self, places: Floats, colour: Colour, *, closed: bool = False, wide: int = 1) -> None:
        """A line through places ahead and to the left, metres, shape (n, 2)."""
        corners = [self._pixels(places).astype(np.int32)]
        cv2.polylines(self.image, corners, closed, colour, wide, cv2.LINE_AA)

    def dots(self, places: Floats, colour: NDArray[np.floating]) -> None:
        """Single pixels, shape (n, 2), each of a colour, shape (n, 3)."""
        pixels = np.floor(self._pixels(places)).astype(int)
        inside = (pixels >= 0).all(1) & (pixels < self.image.shape[1::-1]).all(1)
        columns, rows = pixels[inside].T
        self.image[rows, columns] = colour[inside]

    def word(self, place: Floats, text: str, colour: Colour) -> None:
        """A word at a place, shape (2,)."""
        u, v = self._pixels(place[None])[0].astype(int).tolist()
        at = (u + 8, v - 8)
        cv2.putText(self.image, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, colour, 1, cv2.LINE_AA)

    def _pixels(self, places: Floats) -> Floats:
        return np.asarray((places - self._corner) * [self._scale, -self._scale])


def layout_picture(layout: SceneLayout, size: tuple[int, int]) -> Image:
    """A layout: lanes, the ego vehicle, boxes that stand (blue) and that move (orange).

    Args:
        layout: The layout.
        size: Width and height, pixels.
    """
    length = 75.0  # Metres; objects are rarely labelled beyond.
    scale = size[0] / length
    canvas = FromAbove(size, (-5.0, 0.5 * size[1] / scale), scale)
    along = np.linspace(-10.0, 90.0, 60)
    for offset in layout.road.lane_offsets:
        for side in (-0.5, 0.5):
            left = np.full_like(along, offset + side * layout.road.lane_width)
            canvas.line(layout.road.poses(along, left, 0.0 * along)[:, :2], _LANE)
    boxes = layout.boxes
    moving = np.zeros(len(boxes), bool) if boxes.moving is None else boxes.moving
    ego = rectangle_corners(np.zeros((1, 3)), np.array([4.7]), np.array([1.8]))
    canvas.line(ego[0], _EGO, closed=True, wide=2)
    corners = rectangle_corners(boxes.poses, boxes.length, boxes.width)
    for outline, pose, moves in zip(corners, boxes.poses, moving, strict=True):
        colour = _MOVES if moves else _STANDS
        canvas.line(outline, colour, closed=True, wide=2)
        canvas.line(np.stack([pose[:2], outline[[0, 3]].mean(axis=0)]), colour, wide=2)
    return canvas.image


def connected_picture(posed: PosedScene, scans: Sequence[Scan], width: int, height: int) -> Image:
    """The scans of all sensor vehicles of an instant in one frame, and who sees what.

    Args:
        posed: The scene.
        scans: The scan of each sensor vehicle.
        width: Width of the picture, pixels.
        height: Height of the picture, pixels.
    """
    instant, own = posed.instant, np.linalg.inv(posed.vehicle_to_world[0])
    places = transform_points(own, posed.vehicle_to_world[:, :3, 3])[:, :2]
    low, high = places.min(axis=0) - (22.0, 18.0), places.max(axis=0) + np.array([34.0, 18.0])
    scale = float(min(np.array([width, height]) / (high - low)))
    middle = 0.5 * (low + high)
    corner = (middle[0] - 0.5 * width / scale, middle[1] + 0.5 * height / scale)
    canvas = FromAbove((width, height), corner, scale)
    # Points first, the ground's darker; then the objects, and the vehicles over all.
    colours = np.array([_rgb(VEHICLE_COLOURS[i % len(VEHICLE_COLOURS)]) for i in range(len(scans))])
    points = [
        transform_points(own @ pose @ posed.rig.velodyne_pose, scan.points[:, :3])
        for pose, scan in zip(posed.vehicle_to_world, scans, strict=True)
    ]
    for stands in (False, True):
        for each, colour in zip(points, colours, strict=True):
            shown = ((each[:, 2] > _GROUND) & (each[:, 2] < _ABOVE)) == stands
            canvas.dots(
                each[shown, :2], np.tile(colour * (1.0 if stands else _DIM), (shown.sum(), 1))
            )
    actors = instant.actors
    corners = rectangle_corners(actors.pose, actors.dimensions[:, 2], actors.dimensions[:, 1])
    outlines = transform_points(own, np.concatenate([corners, 0.0 * corners[..., :1]], axis=-1))
    for index, outline in enumerate(outlines[..., :2]):
        sees = sum(int((scan.object_id == index).sum()) >= SEEN_POINTS for scan in scans)
        if index not in instant.egos:
            canvas.line(outline, _BY_VEHICLES[min(sees, 2)], closed=True)
    for number, index in enumerate(instant.egos):
        colour = tuple(colours[number].tolist())
        canvas.line(outlines[index, :, :2], colour, closed=True, wide=3)
        canvas.word(outlines[index, :, :2].mean(axis=0), f"vehicle {number}", _EGO)
    return titled(canvas.image, "outlines: yellow seen by two or more, white by one, grey by none")


def _rgb(code: str) -> Colour:
    """Of a colour such as #1F77B4."""
    red, green, blue = (int(code[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
