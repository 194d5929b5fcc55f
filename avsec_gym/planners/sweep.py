"""One motion primitive, driven from a node: what it touches, and where it first meets a goal.

The answers are those of `collides` and `reaches` at every state; most are found at once, by a
circle around the whole way.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.collision import CollisionWorld, touches_edge, touches_piece, within_edges
from avsec_gym.planners.estimates import HeuristicLimits
from avsec_gym.planners.goal import GoalArrays, reaches
from avsec_gym.planners.search_state import COS, HEADING, SIN, X, Y

_ROUNDING = 1e-6
"""Metres by which a circle is larger than it has to be."""
_BLOCK = 16
"""Segments of the road edge that are looked at as one while they are far."""

PlacedAxle = tuple[float, float, float, float, float]
"""Rear-axle x, y, heading, and the cosine and sine that primitives are turned by."""


@kernel(nogil=True)
def place_of(node: int, pose: Floats, reference: bool) -> PlacedAxle:
    """Where a node is.

    Up to 0.05 rad commonroad-io turns by 1 and the angle, and so reference mode does.
    """
    x, y, heading = pose[node, X], pose[node, Y], pose[node, HEADING]
    if reference:
        angle = np.fmod(heading, 2.0 * np.pi)
        if abs(angle) <= 0.05:
            return x, y, heading, 1.0, angle
        if angle != heading:
            return x, y, heading, np.cos(angle), np.sin(angle)
    return x, y, heading, pose[node, COS], pose[node, SIN]


@kernel(nogil=True)
def may_meet(
    x: float,
    y: float,
    cos: float,
    sin: float,
    step: int,
    primitive: int,
    count: int,
    sweep: Floats,
    windows: NDArray[np.int64],
    intervals: Floats,
    boxes: Floats,
) -> bool:
    """Whether a primitive comes near a goal, in time, at a speed that it allows.

    Most primitives end far from every goal, or drive past it too fast: that is known from a circle
    around the whole way, and from the least and greatest speed on it.

    Args:
        x: The rear axle's place at the start, to the east, m.
        y: The rear axle's place at the start, to the north, m.
        cos: Cosine of the heading there.
        sin: Sine of the heading there.
        step: Time step at which the primitive starts.
        primitive: Number of the primitive.
        count: The last state that counts.
        sweep: Circles and speeds of all primitives.
        windows: The goals' time steps, as `GoalArrays` has them.
        intervals: The goals' headings and velocities.
        boxes: The goals' boxes.
    """
    # The circle around all centres of the way, placed.
    mx, my, around = sweep[primitive, 0], sweep[primitive, 1], sweep[primitive, 2] + _ROUNDING
    mx, my = x + cos * mx - sin * my, y + sin * mx + cos * my
    slowest, fastest = sweep[primitive, 3], sweep[primitive, 4]
    # Invariant: no goal before g can be reached; only what the exact test would refuse is refused.
    for g in range(windows.shape[0]):
        # In time, beside the box by less than the circle, and at a speed of the interval; headings
        # are left to the exact test.
        if (
            step + 1 <= windows[g, 1]
            and step + count >= windows[g, 0]
            and mx + around >= boxes[g, 0]
            and mx - around <= boxes[g, 1]
            and my + around >= boxes[g, 2]
            and my - around <= boxes[g, 3]
            and fastest >= intervals[g, 2]
            and slowest <= intervals[g, 3]
        ):
            return True
    return False


@kernel(nogil=True)
def first_in_goal(
    place: PlacedAxle,
    step: int,
    primitive: int,
    count: int,
    reference: bool,
    centre_offset: float,
    states: Floats,
    goals: GoalArrays,
) -> int:
    """The first state of a primitive in a goal region; -1 where none is."""
    for j in range(1, count + 1):
        x, y, heading, cos, sin = state_at(place, states, primitive, j, reference)
        cx, cy = x + centre_offset * cos, y + centre_offset * sin
        if reaches(cx, cy, heading, states[primitive, j, 2], step + j, goals):
            return j
    return -1


@kernel(nogil=True)
def state_at(
    place: PlacedAxle, states: Floats, primitive: int, j: int, reference: bool
) -> PlacedAxle:
    """Rear-axle x, y, heading, its cosine and sine at state j of a primitive."""
    x0, y0, heading0, cos0, sin0 = place
    px, py = states[primitive, j, 0], states[primitive, j, 1]
    heading = heading0 + states[primitive, j, 3]
    if reference:
        cos, sin = np.cos(heading), np.sin(heading)
    else:
        pc, ps = states[primitive, j, 5], states[primitive, j, 6]
        cos, sin = cos0 * pc - sin0 * ps, sin0 * pc + cos0 * ps
    return cos0 * px - sin0 * py + x0, sin0 * px + cos0 * py + y0, heading, cos, sin


@kernel(nogil=True)
def drives_freely(
    place: PlacedAxle,
    start_step: int,
    primitive: int,
    count: int,
    on_road: bool,
    reference: bool,
    states: Floats,
    sweep: Floats,
    limits: HeuristicLimits,
    world: CollisionWorld,
    blocks: Floats,
    placed: Floats,
) -> bool:
    """Whether no state of a primitive but the first touches an obstacle or leaves the road.

    Invariants: the answer is that of `collides` at every state, but for obstacles that are gone
    (`reference`); `placed` is filled before it is read, at most once; its parity is -1 where the
    way from the start to the centre has crossed the edge an odd number of times.

    Args:
        place: Pose from which the primitive starts.
        start_step: Time step at which it starts.
        primitive: Number of the primitive.
        count: The last state that counts.
        on_road: Whether it is known to start on the road, touching nothing.
        reference: Whether a moving obstacle is gone after its last known state.
        states: States of all primitives.
        sweep: Circles around all primitives, and their speeds.
        limits: The ego vehicle.
        world: Obstacles and road edge, which must not be touched.
        blocks: `edge_blocks` of that edge.
        placed: Memory for centre, cosine, sine and parity of each state, shape (T + 1, 5).
    """
    # A circle around everything that the vehicle covers on the way.
    x0, y0, _, cos0, sin0 = place
    mx, my = sweep[primitive, 0], sweep[primitive, 1]
    mx, my = x0 + cos0 * mx - sin0 * my, y0 + sin0 * mx + cos0 * my
    half_length, half_width, offset = limits.half_length, limits.half_width, limits.centre_offset
    own_reach = np.sqrt(half_length * half_length + half_width * half_width)
    around = sweep[primitive, 2] + own_reach + _ROUNDING
    known = False
    # Obstacles: by the circle, then by the distance at each state, then by separating axes.
    poses, presence, sizes, edges = world.poses, world.presence, world.sizes, world.edges
    vertices, corners = world.vertices, world.corners
    for i in range(poses.shape[0]):
        first, last_index, last = presence[i, 0], presence[i, 1] - 1, presence[i, 2]
        limit, reach = around + sizes[i, 1], own_reach + sizes[i, 1]
        for j in range(1, count + 1):
            t = min(start_step + j - first, last_index)
            if t < 0 or (reference and start_step + j > last):
                continue
            dx, dy = poses[i, t, 0] - mx, poses[i, t, 1] - my
            if dx * dx + dy * dy > limit * limit:
                # What stands stays as far at all other steps.
                if last_index == 0:
                    break
                continue
            if not known:
                _place_all(place, states, primitive, count, offset, reference, placed)
                known = True
            ox, oy = poses[i, t, 0] - placed[j, 0], poses[i, t, 1] - placed[j, 1]
            if ox * ox + oy * oy > reach * reach:
                continue
            oc, os, cos, sin = poses[i, t, 2], poses[i, t, 3], placed[j, 2], placed[j, 3]
            corner_count, radius = corners[i], sizes[i, 0]
            if touches_piece(
                ox, oy, oc, os, cos, sin, half_length, half_width, vertices, i, corner_count, radius
            ):
                return False
    if edges.shape[0] == 0:
        return True
    # The road edge: a segment near the way must not touch the vehicle, nor its centre have crossed
    # the edge between two states.
    start_x, start_y = x0 + offset * cos0, y0 + offset * sin0
    crossed = False
    for b in range(blocks.shape[0]):
        if (
            blocks[b, 0] - mx > around
            or blocks[b, 1] - mx < -around
            or blocks[b, 2] - my > around
            or blocks[b, 3] - my < -around
        ):
            continue
        for k in range(b * _BLOCK, min((b + 1) * _BLOCK, edges.shape[0])):
            if _is_far(mx, my, around, edges, k):
                continue
            if not known:
                _place_all(place, states, primitive, count, offset, reference, placed)
                known = True
            for j in range(1, count + 1):
                x, y, cos, sin = placed[j, 0], placed[j, 1], placed[j, 2], placed[j, 3]
                if touches_edge(x, y, cos, sin, half_length, half_width, edges, k):
                    return False
                if _crosses(start_x, start_y, x, y, edges, k):
                    placed[j, 4] = -placed[j, 4]
                    crossed = True
    # Off the road: by parity where the start is known to be on it, else by a ray for each state.
    if on_road and not crossed:
        return True
    if not known:
        _place_all(place, states, primitive, count, offset, reference, placed)
    for j in range(1, count + 1):
        if on_road and placed[j, 4] < 0.0:
            return False
        if not on_road and not within_edges(placed[j, 0], placed[j, 1], edges):
            return False
    return True


@kernel(nogil=True)
def edge_blocks(edges: Floats) -> Floats:
    """Boxes around every `_BLOCK` segments of the road edge that follow each other.

    Segments run along the road, so that a block lies in one place: where it is far, all of it is.

    Returns:
        x_min, x_max, y_min, y_max, shape (B, 4).
    """
    blocks = np.empty(((edges.shape[0] + _BLOCK - 1) // _BLOCK, 4))
    blocks[:, 0], blocks[:, 2] = np.inf, np.inf
    blocks[:, 1], blocks[:, 3] = -np.inf, -np.inf
    # Invariant: each block holds those of its segments that come before k.
    for k in range(edges.shape[0]):
        b = k // _BLOCK
        blocks[b, 0] = min(blocks[b, 0], edges[k, 0], edges[k, 2])
        blocks[b, 1] = max(blocks[b, 1], edges[k, 0], edges[k, 2])
        blocks[b, 2] = min(blocks[b, 2], edges[k, 1], edges[k, 3])
        blocks[b, 3] = max(blocks[b, 3], edges[k, 1], edges[k, 3])
    return blocks


@kernel(nogil=True)
def _is_far(x: float, y: float, reach: float, edges: Floats, k: int) -> bool:
    """Whether segment k of the road edge, or its line, keeps away from a circle."""
    x1, y1, x2, y2 = edges[k, 0] - x, edges[k, 1] - y, edges[k, 2] - x, edges[k, 3] - y
    if (
        (x1 > reach and x2 > reach)
        or (x1 < -reach and x2 < -reach)
        or (y1 > reach and y2 > reach)
        or (y1 < -reach and y2 < -reach)
    ):
        return True
    ex, ey = x2 - x1, y2 - y1
    apart = ex * y1 - ey * x1
    return apart * apart > reach * reach * (ex * ex + ey * ey)


@kernel(nogil=True)
def _place_all(
    place: PlacedAxle,
    states: Floats,
    primitive: int,
    count: int,
    centre_offset: float,
    reference: bool,
    placed: Floats,
) -> None:
    """Centre, cosine and sine of the heading at every state; nothing is crossed yet."""
    for j in range(1, count + 1):
        x, y, _, cos, sin = state_at(place, states, primitive, j, reference)
        placed[j, 0], placed[j, 1] = x + centre_offset * cos, y + centre_offset * sin
        placed[j, 2], placed[j, 3], placed[j, 4] = cos, sin, 1.0


@kernel(nogil=True)
def _crosses(x1: float, y1: float, x2: float, y2: float, edges: Floats, k: int) -> bool:
    """Whether the line from one place to another crosses segment k of the road edge."""
    ax, ay, bx, by = edges[k, 0] - x1, edges[k, 1] - y1, edges[k, 2] - x1, edges[k, 3] - y1
    dx, dy = x2 - x1, y2 - y1
    if (dx * ay - dy * ax > 0.0) == (dx * by - dy * bx > 0.0):
        return False
    ex, ey = bx - ax, by - ay
    return (ey * ax - ex * ay > 0.0) != (ex * (dy - ay) - ey * (dx - ax) > 0.0)
