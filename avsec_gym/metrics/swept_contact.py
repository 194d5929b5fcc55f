"""Contact between time steps: the space that vehicle and obstacles sweep from one to the next.

The thesis' check looks at every time step; at 11 m/s a corner passes through 1.1 m in between.
Here both move on between steps, positions and headings linearly, and what the vehicle sweeps in
each obstacle's own frame is held against the obstacle.

Error: a step is cut into parts, and of each part the convex hull of the footprints at its ends is
taken.  With the half diagonal r, for a part in which the vehicle turns by w against the obstacle,

    what is swept lies within r w^2 / 8 of the hull, and the hull within r w / 2 + r w^2 / 8 of what
    is swept

(an interpolated corner deviates by an eighth of its second derivative; a point of the hull mixes
two points of the body, turned by s w and (1 - s) w, of which 2 s (1 - s) r w is left), for
obstacles that turn themselves with what `_deviation` adds.  Parts are so small that neither is
above `TOLERANCE`; where nothing turns, the hull is exact and the step is one part.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, rectangle_corners, wrap_angle
from avsec_gym.metrics.collision_check import Contact
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.shapes import Shape

TOLERANCE = 0.001
"""Metres by which the swept space may be wrong, either way."""


class _Steps(NamedTuple):
    """K pairs of a time step and an obstacle, from the step's begin to its end."""

    own: Floats
    """x, y, heading of the vehicle, shape (K, 3)."""
    own_change: Floats
    """The change of their poses until the next step, shape (K, 3)."""
    other: Floats
    other_change: Floats


def first_swept_contact(
    trajectory: Floats, truth: Obstacles, vehicle: Vehicle, first_step: int = 0
) -> Contact | None:
    """The first time step before whose end the vehicle touches an obstacle.

    Whatever `first_contact` finds is found, too, but for what appears at the last state alone.

    Args:
        trajectory: States x, y of the centre (m), velocity, heading (rad), steering angle, shape
            (T, 5).
        truth: Real obstacles; one that appears later is not there before.
        vehicle: The vehicle, of which the size counts.
        first_step: Time step of the trajectory's first state.

    Returns:
        The time step in or after which it happens, before the next; None where nothing is touched.

    Example:
        >>> from avsec_gym.planners.vehicle import BMW_320I
        >>> along_x = np.zeros((4, 5)); along_x[:, 0] = 10.0 * np.arange(4)
        >>> pole = Obstacles.rectangles(np.array([[15.0, 0, 0]]), np.array([0.1]), np.array([0.1]))
        >>> first_swept_contact(along_x, pole, BMW_320I)
        Contact(step=1, obstacle=0)
    """
    if not len(truth) or len(trajectory) < 2:
        return None
    # Pairs of step and obstacle that come near each other, in order of time.
    low, high = (
        np.array([_bounds(shape) for shape in truth.shapes]).reshape(-1, 2, 2).swapaxes(0, 1)
    )
    radius = 0.5 * float(np.hypot(vehicle.length, vehicle.width))
    reach = np.linalg.norm(np.maximum(np.abs(low), np.abs(high)), axis=1) + radius
    t, i, steps = _near(trajectory, truth, reach, first_step)
    if not len(t):
        return None
    # Whole steps first, with all that they may lack added: by their extent, then by their hull.
    lacking = _deviation(steps, radius)
    corners = _corners(steps, vehicle, np.zeros(len(t)), 1.0)
    margin = lacking[:, None] + TOLERANCE
    over = (corners.max(axis=1) >= low[i] - margin) & (corners.min(axis=1) <= high[i] + margin)
    for k in np.flatnonzero(over.all(axis=1)):
        area = _area(truth.shapes[i[k]])
        if not shapely.dwithin(_hulls(corners[k : k + 1])[0], area, lacking[k]):
            continue
        # Few are left: there, every millimetre matters.
        step = _Steps(*(part[k : k + 1] for part in steps))
        parts = _parts(step, radius)
        repeated = _Steps(*(np.repeat(part, parts, axis=0) for part in step))
        fine = _corners(repeated, vehicle, np.arange(parts) / parts, 1.0 / parts)
        if shapely.intersects(_hulls(fine), area).any():
            return Contact(int(first_step + t[k]), int(i[k]))
    return None


def _near(
    trajectory: Floats, truth: Obstacles, reach: Floats, first_step: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], _Steps]:
    """Steps and obstacles, in order of time, whose centres come as close as their reach, (N,)."""
    own = trajectory[:, [0, 1, 3]]
    index = first_step + np.arange(len(own))[:, None] - truth.first_step
    present = (truth.static | (index >= 0))[:-1]
    index = np.where(truth.static, 0, np.clip(index, 0, truth.steps - 1))
    other = truth.poses[np.arange(len(truth)), index]
    # Between two steps the distance is never less than that in the middle, minus half the way.
    between = own[:, None, :2] - other[..., :2]
    way = np.linalg.norm(between[1:] - between[:-1], axis=-1)
    middle = np.linalg.norm(between[1:] + between[:-1], axis=-1) / 2
    t, i = np.nonzero(present & (middle - way / 2 <= reach + TOLERANCE))
    changes = [_change(pose) for pose in (own, other)]
    return t, i, _Steps(own[t], changes[0][t], other[t, i], changes[1][t, i])


def _change(poses: Floats) -> Floats:
    """From each step to the next; headings turn the shorter way."""
    change = np.diff(poses, axis=0)
    change[..., 2] = wrap_angle(change[..., 2])
    return change


def _corners(steps: _Steps, vehicle: Vehicle, begin: Floats, length: float) -> Floats:
    """The vehicle's at both ends of a part of each step, in the obstacle's frame, (K, 8, 2)."""
    corners = []
    for share in (begin[:, None], begin[:, None] + length):
        own = steps.own + share * steps.own_change
        other = steps.other + share * steps.other_change
        cos, sin = np.cos(other[:, 2]), np.sin(other[:, 2])
        dx, dy = (own[:, k] - other[:, k] for k in (0, 1))
        relative = np.column_stack(
            [cos * dx + sin * dy, cos * dy - sin * dx, own[:, 2] - other[:, 2]]
        )
        corners.append(rectangle_corners(relative, vehicle.length, vehicle.width))
    return np.concatenate(corners, axis=1)


def _hulls(corners: Floats) -> NDArray[np.object_]:
    return np.asarray(shapely.convex_hull(shapely.multipoints(corners)))


@lru_cache(maxsize=4096)
def _area(shape: Shape) -> shapely.Geometry:
    """In the obstacle's own frame."""
    return shape.polygon()


@lru_cache(maxsize=4096)
def _bounds(shape: Shape) -> tuple[float, float, float, float]:
    """Least x, y, greatest x, y of an area."""
    bounds: tuple[float, float, float, float] = _area(shape).bounds
    return bounds


def _deviation(steps: _Steps, radius: float) -> Floats:
    """Metres by which a corner may leave the straight line between a step's ends, shape (K,).

    An eighth of the largest second derivative of R(-o) (p - q + R(h) c) over the step, where p, h
    and q, o are the poses: of the way between the centres and of the turn of the corner c.
    """
    turn = steps.other_change[:, 2]
    between = (steps.own - steps.other)[:, :2]
    way = (steps.own_change - steps.other_change)[:, :2]
    farthest = np.linalg.norm(between, axis=1) + np.linalg.norm(way, axis=1)
    of_centres = turn**2 * farthest + 2 * np.abs(turn) * np.linalg.norm(way, axis=1)
    of_corner = radius * (steps.own_change[:, 2] - turn) ** 2
    return np.asarray((of_centres + of_corner) / 8)


def _parts(one: _Steps, radius: float) -> int:
    """Into how many parts a step is cut so that a hull is wrong by `TOLERANCE` at most."""
    turned = abs(float(one.own_change[0, 2] - one.other_change[0, 2]))
    bent = float(_deviation(one, radius)[0])
    # Half of the tolerance for either: r w / 2 falls with the parts, the other with their square.
    return max(1, int(np.ceil(max(radius * turned / TOLERANCE, np.sqrt(2 * bent / TOLERANCE)))))
