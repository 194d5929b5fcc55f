"""One instant of a filmed drive from above: the road, who is there, what the car believes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.scenario_picture import BELIEVED, EGO, GOAL, INK, LANE, REAL, ROAD
from avsec_gym.frame import Image
from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I

GROUND, UNSEEN, CONTACT = "#cfd6db", "#ffffff", "#c1272d"
"""The colours of what lies beside the road, of what the car does not believe in, and of what it has
touched."""
_SHIFT = 4
"""Binary digits behind the point of a pixel, for smooth edges."""
_DASH = 0.8
"""Metres of a dash and of a gap."""
_HARD = 4.05
"""m/s2 from which on brake lights are drawn: nuPlan's bound of comfort."""
_SAME = 0.1
"""Metres up to which a believed object that lies like a real one is not drawn."""


@dataclass(frozen=True)
class FilmView:
    """The part of the world that pictures show; it moves on with the car.

    Args:
        size: Width and height, pixels.
        scale: Pixels to the metre.
        forward: Where the road leads in the picture.
        behind: Metres that are shown behind the car's centre.
    """

    size: tuple[int, int]
    scale: float
    forward: Literal["up", "right"] = "right"
    behind: float = 14.0


def film_picture(film: DriveFilm, instant: int, view: FilmView) -> Image:
    """The picture of an instant.

    Filled in grey: real, and the car believes that something is there; white: real, and it does
    not; dashed: believed, where it lies otherwise than something real; red: touched.  Blue: the
    car, its way so far and its plan; yellow: the line that it is to cross.

    Args:
        film: The drive.
        instant: The row of the film.
        view: What is shown.

    Returns:
        Red, green and blue, shape (height, width, 3).
    """
    canvas = _Canvas(film, instant, view)
    # The ground.
    for lane in film.lanes():
        canvas.fill(lane, ROAD)
    for lane in film.lanes():
        canvas.line(lane, LANE, 0.15, closed=True)
    canvas.line(film.goal, GOAL, 0.5)
    # Everything real, then what is believed in its place.
    real = np.flatnonzero(film.present[instant])
    poses, sizes = film.poses[instant, real], film.sizes[real]
    believed = film.believed[film.believed_at == instant]
    seen = _seen(poses, sizes, believed)
    last = instant == len(film) - 1
    for row, corners, known in zip(real, rectangle_corners(poses, *sizes.T), seen, strict=True):
        touched = last and row == film.contact[0]
        canvas.fill(corners, CONTACT if touched else REAL if known else UNSEEN)
        canvas.line(corners, INK, 0.12, closed=True)
    differing = believed[~_lies_like(believed, poses, sizes)]
    for corners in rectangle_corners(differing[:, :3], differing[:, 3], differing[:, 4]):
        canvas.dashed(corners, BELIEVED, 0.25)
    # The car: its way so far, its plan, itself.
    canvas.line(film.car[: instant + 1, :2], EGO, 0.2)
    canvas.dashed(_plan_ahead(film, instant), EGO, 0.25, closed=False)
    own = rectangle_corners(film.car[instant, [0, 1, 3]], BMW_320I.length, BMW_320I.width)
    canvas.fill(own, EGO)
    canvas.line(own, INK, 0.12, closed=True)
    if film.braking[instant] > _HARD:
        canvas.line(own[1:3], CONTACT, 0.6)
    return canvas.pixels


def _seen(poses: Floats, sizes: Floats, believed: Floats) -> NDArray[np.bool_]:
    """Whether the car believes that something is where each real object is, shape (N,)."""
    objects = rectangle_polygons(poses, sizes[:, 0], sizes[:, 1])
    boxes = rectangle_polygons(believed[:, :3], believed[:, 3], believed[:, 4])
    return shapely.intersects(objects[:, None], boxes[None]).any(axis=1)


def _lies_like(believed: Floats, poses: Floats, sizes: Floats) -> NDArray[np.bool_]:
    """Whether each believed object lies just as a real one does, shape (B,)."""
    if not len(poses):
        return np.zeros(len(believed), bool)
    own = rectangle_corners(believed[:, :3], believed[:, 3], believed[:, 4])
    real = rectangle_corners(poses, sizes[:, 0], sizes[:, 1])
    apart = np.linalg.norm(own[:, None] - real[None], axis=-1).max(axis=-1)
    return np.asarray(apart.min(axis=1) < _SAME)


def _plan_ahead(film: DriveFilm, instant: int) -> Floats:
    """What is left of the plan that the car follows, from the car on, shape (n, 2)."""
    points = film.plans[film.plan_of == film.planned[instant]]
    if not len(points):
        return points
    nearest = int(np.hypot(*(points - film.car[instant, :2]).T).argmin())
    return np.vstack([film.car[instant, :2], points[nearest + 1 :]])


class _Canvas:
    """Draws in metres."""

    def __init__(self, film: DriveFilm, instant: int, view: FilmView) -> None:
        width, height = view.size
        self._scale = view.scale
        self.pixels: Image = np.full((height, width, 3), _rgb(GROUND), np.uint8)
        way = float(film.ways[instant])
        cos, sin = np.cos(way), np.sin(way)
        # Metres ahead of the car and to its left become pixels.
        self._turn = np.array([[cos, -sin], [sin, cos]])
        self._middle = film.car[instant, :2]
        if view.forward == "right":
            self._axes = np.array([[1.0, 0.0], [0.0, -1.0]])
            self._origin = np.array([view.behind * view.scale, 0.5 * height])
        else:
            self._axes = np.array([[0.0, -1.0], [-1.0, 0.0]])
            self._origin = np.array([0.5 * width, height - view.behind * view.scale])

    def fill(self, points: Floats, colour: str) -> None:
        """An area."""
        cv2.fillPoly(self.pixels, [self._at(points)], _rgb(colour), cv2.LINE_AA, _SHIFT)

    def line(self, points: Floats, colour: str, width: float, *, closed: bool = False) -> None:
        """A line of a width in metres, one pixel at least."""
        if len(points) > 1:
            thick = max(round(width * self._scale), 1)
            cv2.polylines(
                self.pixels, [self._at(points)], closed, _rgb(colour), thick, cv2.LINE_AA, _SHIFT
            )

    def dashed(self, points: Floats, colour: str, width: float, *, closed: bool = True) -> None:
        """A dashed line; arguments as above."""
        ends = np.vstack([points, points[:1]]) if closed else points
        for begin, end in pairwise(ends):
            length = float(np.hypot(*(end - begin)))
            count = max(round(0.5 * length / _DASH), 1)
            for number in range(count):
                shares = np.array([[2 * number], [2 * number + 1]]) / (2 * count)
                self.line(begin + shares * (end - begin), colour, width)

    def _at(self, points: Floats) -> NDArray[np.int32]:
        own = (np.asarray(points, float)[:, :2] - self._middle) @ self._turn
        pixels = (own @ self._axes) * self._scale + self._origin
        return np.round(np.clip(pixels, -2000, 4000) * 2**_SHIFT).astype(np.int32)


def _rgb(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
