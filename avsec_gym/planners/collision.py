"""The planner's own collision test: the ego rectangle against obstacles and road edge, in numba.

A planned trajectory is not checked here but with shapely (`avsec_gym.metrics.collision_check`), so
that planner and check cannot share a bug.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.shapes import Disc, Piece, Polygon, Rectangle, members

ALWAYS, FOR_EVER = -(2**40), 2**40
"""Time steps before and after all others."""
_ROUNDING = 1e-9
"""Metres; shortcuts leave so much to the full tests."""


class CollisionWorld(NamedTuple):
    """The obstacles and the road edge, which a planner must not touch, laid out for the kernels.

    Every obstacle is a set of convex pieces that share its motion; here each piece is a row, and a
    row keeps what it needs of its obstacle.
    """

    vertices: Floats
    """Convex pieces about their shape's centre, counter-clockwise, shape (N, K, 2)."""
    corners: NDArray[np.int64]
    """Vertices in use, shape (N,); a single one is a disc."""
    sizes: Floats
    """Radius of discs, 0 for polygons, and a piece's largest distance from its shape's centre,
    shape (N, 2)."""
    poses: Floats
    """x, y of the shape's centre, cos, sin of the heading, shape (N, T, 4)."""
    presence: NDArray[np.int64]
    """Time step of the first state, number of known states, time step of the last one, shape
    (N, 3); what never moves is there from `ALWAYS` to `FOR_EVER`."""
    edges: Floats
    """Road edge, x1, y1, x2, y2, shape (M, 4), closed lines; none: the ground is free
    everywhere."""

    @property
    def standing(self) -> bool:
        """Nothing moves, comes or goes."""
        return bool((self.presence[:, 0] == ALWAYS).all())


def collision_world_of(scenario: PlanningScenario, *, exact: bool = False) -> CollisionWorld:
    """The obstacles and the road edge of a scenario.

    Args:
        scenario: The believed scenario.
        exact: Whether gaps between lanelets that are too narrow to mean anything are kept.
    """
    road = scenario.road
    return obstacle_world(scenario.obstacles, road.edges if exact else road.closed_edges)


def obstacle_world(obstacles: Obstacles, edges: Floats) -> CollisionWorld:
    """Lay obstacles out for the kernels.

    Args:
        obstacles: The N obstacles.
        edges: Segments of the road edge, shape (M, 4).
    """
    # The convex pieces, with the obstacle of each; rectangles alone are laid out at once.
    owner: NDArray[np.int64]
    if all(type(shape) is Rectangle for shape in obstacles.shapes):
        owner = np.arange(len(obstacles))
        vertices, corners, radius, centres = _rectangle_pieces(obstacles.shapes)  # type: ignore[arg-type]
    else:
        flat = [
            (i, piece, centre)
            for i, shape in enumerate(obstacles.shapes)
            for member in members(shape)
            for centre, pieces in [_pieces(member)]
            for piece in pieces
        ]
        owner = np.array([i for i, _, _ in flat], np.int64)
        corners = np.array([len(piece.vertices) for _, piece, _ in flat], np.int64)
        centres = np.array([centre for _, _, centre in flat]).reshape(-1, 2)
        vertices = np.zeros((len(flat), int(corners.max(initial=4)), 2))
        for row, (_, piece, centre) in enumerate(flat):
            vertices[row, : corners[row]] = piece.vertices - np.array(centre)
        radius = np.array([piece.radius for _, piece, _ in flat])
    # When each piece is there: what stands, always, with its only pose.
    poses, static = obstacles.poses[owner], obstacles.static[owner]
    first = np.where(static, ALWAYS, obstacles.first_step[owner])
    known = np.where(static, 1, obstacles.steps[owner])
    last = np.where(static, FOR_EVER, first + known - 1)
    # The circle about a piece's centre that holds it, for the shortcuts of the tests.
    reach = np.hypot(vertices[..., 0], vertices[..., 1]).max(axis=1, initial=0.0) + radius
    return CollisionWorld(
        vertices=vertices,
        corners=corners,
        sizes=np.column_stack([radius, reach]),
        poses=np.concatenate(
            [
                poses[..., :2] + centres[:, None, :],
                np.cos(poses[..., 2:]),
                np.sin(poses[..., 2:]),
            ],
            axis=-1,
        ),
        presence=np.column_stack([first, known, last]),
        # Kernels are compiled for arrays that can be written into; those of a road cannot.
        edges=edges.copy(),
    )


@lru_cache(maxsize=256)
def _pieces(shape: Rectangle | Disc | Polygon) -> tuple[tuple[float, float], list[Piece]]:
    """What a shape turns about, and its convex pieces: many obstacles are of one shape."""
    return shape.centre, shape.convex_pieces()


def within_reach(world: CollisionWorld, x: float, y: float, distance: float) -> CollisionWorld:
    """The world without the pieces that stay farther from a point than a distance."""
    away = np.hypot(world.poses[..., 0] - x, world.poses[..., 1] - y).min(axis=1, initial=np.inf)
    near = away <= distance + world.sizes[:, 1]
    if near.all():
        return world
    rows: dict[str, Any] = {
        name: column[near] for name, column in world._asdict().items() if name != "edges"
    }
    return CollisionWorld(**rows, edges=world.edges)


def _rectangle_pieces(
    shapes: tuple[Rectangle, ...],
) -> tuple[Floats, NDArray[np.int64], Floats, Floats]:
    data = np.array([(s.length, s.width, s.x, s.y, s.heading) for s in shapes]).reshape(-1, 5)
    along = 0.5 * data[:, :1] * np.array([1.0, -1.0, -1.0, 1.0])
    across = 0.5 * data[:, 1:2] * np.array([1.0, 1.0, -1.0, -1.0])
    cos, sin = np.cos(data[:, 4:]), np.sin(data[:, 4:])
    vertices = np.stack([cos * along - sin * across, sin * along + cos * across], -1)
    count = len(shapes)
    return vertices, np.full(count, 4, np.int64), np.zeros(count), data[:, 2:4]


@kernel(nogil=True)
def collides(
    x: float,
    y: float,
    cos: float,
    sin: float,
    half_length: float,
    half_width: float,
    step: int,
    world: CollisionWorld,
) -> bool:
    """Whether a rectangle centred on (x, y) touches an obstacle at a time step or the road edge.

    Beyond an obstacle's last known state that state is kept; before its first it is absent, unless
    it is static.

    Invariant: a shortcut only ever skips what the full test would find free.
    """
    own_reach = np.sqrt(half_length * half_length + half_width * half_width)
    for i in range(world.poses.shape[0]):
        t = min(step - world.presence[i, 0], world.presence[i, 1] - 1)
        if t < 0:
            continue
        ox, oy = world.poses[i, t, 0] - x, world.poses[i, t, 1] - y
        reach = own_reach + world.sizes[i, 1]
        if ox * ox + oy * oy > reach * reach:
            continue
        oc, os = world.poses[i, t, 2], world.poses[i, t, 3]
        count, radius = world.corners[i], world.sizes[i, 0]
        if touches_piece(
            ox, oy, oc, os, cos, sin, half_length, half_width, world.vertices, i, count, radius
        ):
            return True
    # Off the road: an edge is touched, or the centre is beyond all of it.
    if world.edges.shape[0] == 0:
        return False
    for k in range(world.edges.shape[0]):
        if touches_edge(x, y, cos, sin, half_length, half_width, world.edges, k):
            return True
    return not within_edges(x, y, world.edges)


@kernel(nogil=True)
def touches_piece(
    ox: float,
    oy: float,
    oc: float,
    os: float,
    cos: float,
    sin: float,
    half_length: float,
    half_width: float,
    vertices: Floats,
    i: int,
    count: int,
    radius: float,
) -> bool:
    """Separating axes between the ego rectangle and piece i.

    Args:
        ox: Offset from the rectangle's centre to the centre of the piece's shape along x, m.
        oy: Offset along y, m.
        oc: Cosine of the piece's heading.
        os: Sine of the piece's heading.
        cos: Cosine of the rectangle's heading.
        sin: Sine of the rectangle's heading.
        half_length: Half the rectangle's length, m.
        half_width: Half the rectangle's width, m.
        vertices: Vertices of all pieces.
        i: Number of the piece.
        count: Number of its vertices; 1 is a disc.
        radius: Radius of the disc, m.
    """
    # The obstacle's frame in the ego vehicle's.
    px, py = cos * ox + sin * oy, cos * oy - sin * ox
    rc, rs = cos * oc + sin * os, cos * os - sin * oc
    if count == 1:
        vx, vy = vertices[i, 0, 0], vertices[i, 0, 1]
        dx = max(abs(px + rc * vx - rs * vy) - half_length, 0.0)
        dy = max(abs(py + rs * vx + rc * vy) - half_width, 0.0)
        return bool(dx * dx + dy * dy <= radius**2)
    # The ego vehicle's two axes: the piece's extent along them.
    # Invariant: low and high bound the vertices before k.
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for k in range(count):
        vx, vy = vertices[i, k, 0], vertices[i, k, 1]
        qx, qy = px + rc * vx - rs * vy, py + rs * vx + rc * vy
        low_x, high_x = min(low_x, qx), max(high_x, qx)
        low_y, high_y = min(low_y, qy), max(high_y, qy)
    if low_x > half_length or high_x < -half_length or low_y > half_width or high_y < -half_width:
        return False
    # The piece's own axes: the normals of its edges, outward as vertices run counter-clockwise.
    # Invariant: no axis before k parts the two.
    for k in range(count):
        ax, ay = vertices[i, k, 0], vertices[i, k, 1]
        following = k + 1 if k + 1 < count else 0
        ex, ey = vertices[i, following, 0] - ax, vertices[i, following, 1] - ay
        # The edge's outward normal, turned into the ego frame, and its distance from the ego.
        nx, ny = rc * ey + rs * ex, rs * ey - rc * ex
        qx, qy = px + rc * ax - rs * ay, py + rs * ax + rc * ay
        nearest = half_length * abs(nx) + half_width * abs(ny)
        if nx * qx + ny * qy + nearest < 0.0:
            return False
    return True


@kernel(nogil=True)
def touches_edge(
    x: float,
    y: float,
    cos: float,
    sin: float,
    half_length: float,
    half_width: float,
    edges: Floats,
    k: int,
) -> bool:
    """Whether a rectangle touches segment k of the road edge (Liang and Barsky's clipping)."""
    x1, y1, x2, y2 = edges[k, 0] - x, edges[k, 1] - y, edges[k, 2] - x, edges[k, 3] - y
    ax, ay = cos * x1 + sin * y1, cos * y1 - sin * x1
    bx, by = cos * x2 + sin * y2, cos * y2 - sin * x2
    # Both ends far beyond one side: most segments end here.
    beyond = half_width + _ROUNDING
    if (ay > beyond and by > beyond) or (ay < -beyond and by < -beyond):
        return False
    beyond = half_length + _ROUNDING
    if (ax > beyond and bx > beyond) or (ax < -beyond and bx < -beyond):
        return False
    # Clip the segment to the rectangle; what is left touches it.
    # Invariant: the part from `first` to `last` lies within the rectangle along the axes so far;
    # nothing is left once `first` is beyond `last`.
    first, last = 0.0, 1.0
    dx, dy = bx - ax, by - ay
    for axis in range(2):
        start = ax if axis == 0 else ay
        change = dx if axis == 0 else dy
        half = half_length if axis == 0 else half_width
        if change == 0.0:
            if abs(start) > half:
                last = -1.0
            continue
        enter, leave = (-half - start) / change, (half - start) / change
        if enter > leave:
            enter, leave = leave, enter
        first, last = max(first, enter), min(last, leave)
    return first <= last


@kernel(nogil=True)
def within_edges(x: float, y: float, edges: Floats) -> bool:
    """Whether a point is inside the closed road edge: a ray along x crosses it an odd time."""
    inside = False
    for k in range(edges.shape[0]):
        y1, y2 = edges[k, 1] - y, edges[k, 3] - y
        if (y1 > 0.0) != (y2 > 0.0):
            x1, x2 = edges[k, 0] - x, edges[k, 2] - x
            if x1 + (x2 - x1) * y1 / (y1 - y2) > 0.0:
                inside = not inside
    return inside
