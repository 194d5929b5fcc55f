"""Plane shapes of obstacles and goal regions, and their convex pieces for the search.

A shape that no obstacle can have, such as one of a negative length, is a `PlanningError`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from avsec_gym.argument_checks import keep_checked, keep_read_only, shown
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.scenario.bounds import ANGLE, COORDINATE, SIZE


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle in its owner's frame (metres, radians)."""

    length: float
    width: float
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def __post_init__(self) -> None:
        SIZE.check(self.length, "the length of a rectangle")
        SIZE.check(self.width, "the width of a rectangle")
        COORDINATE.check(self.x, "the x of a rectangle")
        COORDINATE.check(self.y, "the y of a rectangle")
        ANGLE.check(self.heading, "the heading of a rectangle")

    @property
    def centre(self) -> tuple[float, float]:
        """What the shape turns about."""
        return self.x, self.y

    @property
    def is_centred(self) -> bool:
        """Whether it lies about its owner's centre, along its heading."""
        return self.x == self.y == self.heading == 0.0

    def polygon(self) -> shapely.Polygon:
        """The shape in its own frame."""
        return shapely.Polygon(self.corners())

    def corners(self) -> Floats:
        """Corners, counter-clockwise, shape (4, 2)."""
        pose = np.array([self.x, self.y, self.heading])
        return rectangle_corners(pose, np.array(self.length), np.array(self.width))

    def convex_pieces(self) -> list[Piece]:
        """The rectangle itself."""
        return [Piece(self.corners(), 0.0)]


@dataclass(frozen=True, slots=True)
class Disc:
    """A disc in its owner's frame (metres)."""

    radius: float
    x: float = 0.0
    y: float = 0.0

    def __post_init__(self) -> None:
        SIZE.check(self.radius, "the radius of a disc")
        COORDINATE.check(self.x, "the x of a disc")
        COORDINATE.check(self.y, "the y of a disc")

    @property
    def centre(self) -> tuple[float, float]:
        """What the shape turns about."""
        return self.x, self.y

    def polygon(self) -> shapely.Polygon:
        """The disc as a 256-gon that lies outside it by at most 0.01 % of the radius."""
        circumscribed = self.radius / np.cos(np.pi / 256)
        return shapely.Point(self.x, self.y).buffer(circumscribed, quad_segs=64)

    def convex_pieces(self) -> list[Piece]:
        """A point with a radius."""
        return [Piece(np.array([[self.x, self.y]]), self.radius)]


@dataclass(frozen=True, slots=True)
class Polygon:
    """A simple polygon in its owner's frame (metres)."""

    vertices: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        COORDINATE.check_all(self.vertices, "a vertex of a polygon")
        keep_checked(self, {"vertices": points_as_tuples(self.vertices, "a polygon")})
        if len(self.vertices) < 3:
            raise PlanningError(f"a polygon has {len(self.vertices)} vertices; expected 3 or more.")
        polygon = self.polygon()
        if not (polygon.is_valid and polygon.area > 0):
            x, y = self.vertices[0]
            raise PlanningError(
                f"the polygon that begins at ({x:g}, {y:g}) has edges that cross or touch, or no"
                " area; expected the corners of one area in the order of its border."
            )

    @property
    def centre(self) -> tuple[float, float]:
        """What the shape turns about: its centroid."""
        centroid = self.polygon().centroid
        return centroid.x, centroid.y

    def polygon(self) -> shapely.Polygon:
        """The shape in its own frame."""
        return shapely.Polygon(self.vertices)

    def convex_pieces(self) -> list[Piece]:
        """The polygon if it is convex, else triangles that tile it."""
        polygon = shapely.orient_polygons(self.polygon())
        ring = np.array(polygon.exterior.coords)[:-1]
        if np.isclose(polygon.convex_hull.area, polygon.area, rtol=1e-12):
            return [Piece(ring, 0.0)]
        triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
        rings = shapely.get_coordinates(shapely.orient_polygons(triangles)).reshape(-1, 4, 2)
        return [Piece(ring[:3], 0.0) for ring in rings]


@dataclass(frozen=True, slots=True)
class Group:
    """Several shapes that one obstacle consists of."""

    shapes: tuple[Rectangle | Disc | Polygon, ...]

    def __post_init__(self) -> None:
        simple = all(isinstance(shape, Rectangle | Disc | Polygon) for shape in self.shapes)
        if not (self.shapes and simple):
            raise PlanningError(
                f"a group holds {shown(self.shapes)}; expected one or more rectangles, discs and"
                " polygons."
            )

    def polygon(self) -> shapely.Geometry:
        """The union in the obstacle's frame."""
        return shapely.union_all([shape.polygon() for shape in self.shapes])

    def convex_pieces(self) -> list[Piece]:
        """The pieces of all members."""
        return [piece for shape in self.shapes for piece in shape.convex_pieces()]


Shape = Rectangle | Disc | Polygon | Group


def points_as_tuples(
    points: Sequence[Sequence[float]] | Floats, what: str
) -> tuple[tuple[float, float], ...]:
    """Points x, y in an order, which nothing can change.

    Args:
        points: Numbers as lists, tuples or an array; shape (N, 2).
        what: What the points belong to, for the message.

    Raises:
        PlanningError: They have another shape.
    """
    count, *each = np.shape(points) or (1,)
    if count and each != [2]:
        raise PlanningError(f"{what} is {shown(points)}; expected two points (x, y) or more.")
    return tuple((x, y) for x, y in points)


def members(shape: Shape) -> tuple[Rectangle | Disc | Polygon, ...]:
    """The simple shapes that a shape consists of."""
    return shape.shapes if isinstance(shape, Group) else (shape,)


def placed(shape: Shape, pose: Floats) -> shapely.Geometry:
    """The area that an obstacle of a shape covers at a pose.

    As in commonroad-io, each simple shape turns about its own centre, not about the obstacle's
    origin: a centre off the origin is shifted, never turned.

    Args:
        shape: Shape in the obstacle's own frame.
        pose: Pose as x, y, heading.
    """
    x, y, heading = pose
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    areas = []
    for member in members(shape):
        centre = np.array(member.centre)
        areas.append(
            shapely.transform(
                member.polygon(), lambda p, c=centre: (p - c) @ turn + c + np.array([x, y])
            )
        )
    return areas[0] if len(areas) == 1 else shapely.union_all(areas)


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A convex polygon, counter-clockwise (K, 2), or one point with a radius."""

    vertices: Floats
    radius: float

    def __post_init__(self) -> None:
        keep_read_only(self, {"vertices": self.vertices})
