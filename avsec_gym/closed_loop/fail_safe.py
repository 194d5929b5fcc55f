"""Fail-safe plans: a plan is driven only if the car can still stop when it is to be replaced.

After Magdici and Althoff, "Fail-safe motion planning of autonomous vehicles", ITSC 2016.  A plan is
driven until the next replanning.  From there on, full braking along the plan's own path must touch
nothing that the car believes in; then, where no new plan is found, there is a stop that holds.
What comes from behind is left out: it has to keep its distance.  What drives ahead may itself brake
from now on, firmly: without that a car would close up to one that brakes, as far as its speed alone
allows.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.closed_loop.fault import is_behind
from avsec_gym.closed_loop.in_the_way import in_the_way
from avsec_gym.closed_loop.integration import driven
from avsec_gym.emergency_stop import DECELERATION
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.kernels import kernel
from avsec_gym.metrics.swept_contact import first_swept_contact
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.shapes import Rectangle

OTHERS_BRAKE = 4.05
"""m/s2 by which one that drives ahead may brake: nuPlan's bound of comfort."""
MARGIN = 0.15
"""Metres to keep from what moves: where it will be is a prediction, and no better than that."""
_SAME_WAY = math.radians(60)
"""Angle between two headings up to which one that moves drives ahead."""
_FURTHER = 80.0
"""Metres by which a path goes on straight in the end: more than any braking takes."""


def braked(trajectory: Floats, elapsed: float, speed: float, dt: float = 0.1) -> Floats:
    """Full braking along the path of a trajectory, until the car stands.

    Args:
        trajectory: States x, y, velocity, heading, steering angle at every `dt`, shape (T, 5).
        elapsed: Time since its first state at which the braking begins, seconds.
        speed: The car's speed there, m/s.
        dt: Length of a time step, seconds.

    Returns:
        States at every `dt`, the first one that at which it begins, shape (S, 5).
    """
    # Where the braking takes longer than the plan, the path goes on as the wheels straighten.
    path = np.vstack([trajectory, _straightened(trajectory[-1], dt)])
    return np.asarray(_braked(path, len(trajectory), elapsed / dt, speed, dt))


@kernel(nogil=True)
def _braked(path: Floats, known: int, elapsed: float, speed: float, dt: float) -> Floats:
    """`braked` on a path of which the first states belong to the trajectory.

    Args:
        path: The states, shape (S, 5).
        known: Number of those in the trajectory.
        elapsed: Time steps after which the braking begins.
        speed: The car's speed there, m/s.
        dt: Length of a time step, seconds.
    """
    # The path, without jumps of the heading, and straight on behind its end.
    # Invariant: `turns` makes up for all jumps up to k, and `along` never falls, so that places on
    # it can be interpolated.
    count = len(path) + 1
    x, y, heading, steering = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    along, turns = np.zeros(count), 0.0
    for k in range(count):
        state = path[min(k, count - 2)]
        x[k], y[k], steering[k] = state[0], state[1], state[4]
        if 0 < k < count - 1:
            turns += _jump(path[k - 1, 3], state[3])
        heading[k] = state[3] + turns
    x[-1] += _FURTHER * math.cos(heading[-1])
    y[-1] += _FURTHER * math.sin(heading[-1])
    for k in range(1, count):
        along[k] = along[k - 1] + np.hypot(x[k] - x[k - 1], y[k] - y[k - 1])
    begun = _interpolated(elapsed, np.arange(float(known)), along[:known])
    # Full braking along it.
    duration = speed / DECELERATION
    steps = math.ceil(duration / dt - 1e-9)
    states = np.empty((steps + 1, 5))
    for step in range(steps + 1):
        time = min(dt * step, duration)
        way = begun + speed * time - DECELERATION * time**2 / 2
        states[step, 0], states[step, 1] = (
            _interpolated(way, along, x),
            _interpolated(way, along, y),
        )
        states[step, 2] = speed - DECELERATION * time
        states[step, 3] = _interpolated(way, along, heading)
        states[step, 4] = _interpolated(way, along, steering)
    return states


@kernel(nogil=True)
def _jump(before: float, after: float) -> float:
    """What `numpy.unwrap` adds from one heading on."""
    change = after - before
    if abs(change) < np.pi:
        return 0.0
    shorter = (change + np.pi) % (2 * np.pi) - np.pi
    if shorter == -np.pi and change > 0:
        shorter = np.pi
    return shorter - change


@kernel(nogil=True)
def _interpolated(place: float, places: Floats, values: Floats) -> float:
    """`numpy.interp`, bit for bit; places do not fall."""
    last = len(places) - 1
    if place >= places[last]:
        return float(values[last])
    if place < places[0]:
        return float(values[0])
    low = np.searchsorted(places, place, side="right") - 1
    slope = (values[low + 1] - values[low]) / (places[low + 1] - places[low])
    return float(slope * (place - places[low]) + values[low])


def _straightened(state: Floats, dt: float) -> Floats:
    """States after one, in which the wheels turn back as fast as they can, shape (S, 5)."""
    steps = math.ceil(abs(state[4]) / (BMW_320I.max_steering_rate * dt) - 1e-9)
    if not steps:
        return np.zeros((0, 5))
    offset = BMW_320I.rear_axle
    rear = state - offset * np.array([math.cos(state[3]), math.sin(state[3]), 0.0, 0.0, 0.0])
    rate = np.array([-state[4] / (steps * dt)])
    states = np.asarray(driven(rear[None], np.zeros(1), rate, steps, dt))[0, 1:]
    states[:, 0] += offset * np.cos(states[:, 3])
    states[:, 1] += offset * np.sin(states[:, 3])
    return states


def is_fail_safe(
    trajectory: Floats,
    obstacles: Obstacles,
    until: float,
    drivable: shapely.Geometry | None = None,
    dt: float = 0.1,
) -> bool:
    """Whether a plan, and full braking after a time, touch nothing and stay on the road.

    It must hold whether those ahead drive on as believed or brake by `OTHERS_BRAKE`, with a
    `MARGIN` around all that moves, and for a time step after the car has come to rest.

    Args:
        trajectory: States of the plan at every `dt`, shape (T, 5).
        obstacles: What the car believes in, from the plan's first state on, for `steps_to_rest`.
        until: Time at which the plan is to be replaced, seconds.
        drivable: The area that the car's centre must not leave; None: the plane.
        dt: Length of a time step, seconds.
    """
    last = min(round(until / dt), len(trajectory) - 1)
    stop = braked(trajectory, last * dt, float(trajectory[last, 2]), dt)
    whole = np.vstack([trajectory[: last + 1], stop[1:]])
    if drivable is not None and not shapely.contains_xy(drivable, whole[:, 0], whole[:, 1]).all():
        return False
    # The car stands then: what comes in the next time step touches it, too.
    whole = np.vstack([whole, whole[-1:]])
    counted = ~is_behind(trajectory[0], obstacles.poses[:, 0])
    counted = in_the_way(whole, obstacles, counted, margin=MARGIN, brake=OTHERS_BRAKE, dt=dt)
    if not counted.any():
        return True
    ahead = _picked(obstacles, counted)
    ahead = widened(ahead, ~ahead.static)
    if first_swept_contact(whole, ahead, BMW_320I) is not None:
        return False
    slower = others_brake(ahead, float(trajectory[0, 3]), dt)
    return slower is None or first_swept_contact(whole, slower, BMW_320I) is None


def steps_to_rest(speed: float, until: float, dt: float = 0.1) -> int:
    """The last time step that `is_fail_safe` looks at, whatever the plan does.

    Args:
        speed: The car's speed at the plan's first state, m/s.
        until: Time at which the plan is to be replaced, seconds.
        dt: Length of a time step, seconds.
    """
    fastest = speed + BMW_320I.max_acceleration * until
    return round(until / dt) + math.ceil(fastest / (DECELERATION * dt)) + 1


def others_brake(obstacles: Obstacles, heading: float, dt: float = 0.1) -> Obstacles | None:
    """The vehicles that drive as the car does, braking from now on; None: there are none.

    They keep to the ways that they are believed to take.

    Args:
        obstacles: What the car believes in; each keeps its speed.
        heading: The car's heading, radians.
        dt: Length of a time step, seconds.
    """
    if not len(obstacles):
        return None
    speeds = obstacles.speeds[:, 0]
    turned = np.abs(wrap_angle(obstacles.poses[:, 0, 2] - heading))
    driving = ~obstacles.static & (speeds > 0) & (turned < _SAME_WAY)
    if not driving.any():
        return None
    kept = _picked(obstacles, driving)
    count, first = kept.poses.shape[1], speeds[driving][:, None]
    time = np.minimum(dt * np.arange(count), first / OTHERS_BRAKE)
    # Unbraked, they would be as far after so many time steps.
    steps = (time - OTHERS_BRAKE * time**2 / (2 * first)) / dt
    before = np.minimum(steps.astype(np.int64), count - 1)
    after = np.minimum(before + 1, count - 1)
    rows = np.arange(len(kept))[:, None]
    begin, share = kept.poses[rows, before], (steps - before)[..., None]
    poses = begin + share * (kept.poses[rows, after] - begin)
    return replace(kept, poses=poses, speeds=first - OTHERS_BRAKE * time)


def widened(obstacles: Obstacles, which: NDArray[np.bool_] | None = None) -> Obstacles:
    """Obstacles of which some reach further, by `MARGIN` on all sides.

    Args:
        obstacles: Rectangles, as a car believes in them.
        which: The obstacles that grow, shape (N,); None: all.
    """
    which = np.ones(len(obstacles), bool) if which is None else which
    shapes = tuple(
        Rectangle(shape.length + 2 * MARGIN, shape.width + 2 * MARGIN)
        if grows and isinstance(shape, Rectangle)
        else shape
        for shape, grows in zip(obstacles.shapes, which, strict=True)
    )
    return replace(obstacles, shapes=shapes)


def _picked(obstacles: Obstacles, kept: NDArray[np.bool_]) -> Obstacles:
    return Obstacles(
        ids=obstacles.ids[kept],
        categories=obstacles.categories[kept],
        shapes=tuple(obstacles.shapes[i] for i in np.nonzero(kept)[0]),
        poses=obstacles.poses[kept],
        speeds=obstacles.speeds[kept],
        steps=obstacles.steps[kept],
        first_step=obstacles.first_step[kept],
        static=obstacles.static[kept],
    )
