"""What a driver is shown, as a kernel: equal to `DriverObservation`, which states what it is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.centre_line import coordinates
from avsec_gym.closed_loop.light.car_motion import HEADING, SPEED, STEERING, X, Y
from avsec_gym.closed_loop.light.light_drive import LightDrive
from avsec_gym.closed_loop.light.road_table import RoadTable, heading_at, lane_at, place_at
from avsec_gym.envs.closed_loop_observation import EACH, OWN, RANGE
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.road_type import RoadType

_LOOK = 15.0
"""Metres ahead at which a lane is looked at."""


def show(drive: LightDrive, belief: Belief, row: NDArray[np.float32]) -> None:
    """Write what the driver of a light drive is shown.

    Args:
        drive: The drive.
        belief: What the car believes.
        row: Memory for the observation, shape (13 + 9 objects,).
    """
    left, share = drive.remaining
    highway = float(belief.road_type == RoadType.HIGHWAY)
    others = (left, share, drive.place.scene.cruise[0], highway, float(belief.stops))
    objects = (belief.poses, belief.lengths, belief.widths, belief.speeds)
    _show(drive.place.road, drive.aim.lane, drive.car, others, *objects, row)


@kernel(nogil=True)
def _show(
    road: RoadTable,
    target: int,
    car: Floats,
    others: tuple[float, float, float, float, float],
    poses: Floats,
    lengths: Floats,
    widths: Floats,
    speeds: Floats,
    row: NDArray[np.float32],
) -> None:
    x, y, heading, speed = car[X], car[Y], car[HEADING], car[SPEED]
    cos, sin = np.cos(heading), np.sin(heading)
    row[:] = 0.0
    row[0], row[1] = _cut(speed / 25.0), _cut(car[STEERING] / (math.pi / 4))
    # The lane that the car is in, and the intended one.
    for k in range(2):
        lane = lane_at(road, x, y, heading) if k == 0 else target
        begin, end = road.lines[lane, 0], road.lines[lane, 1]
        along, left = coordinates(road.points, begin, end, x, y)
        turned = wrapped(heading - heading_at(road.points, begin, end, along))
        ahead_x, ahead_y = place_at(road.points, begin, end, along + _LOOK)
        bends = cos * (ahead_y - y) - sin * (ahead_x - x)
        row[2 + 3 * k] = _cut(left / 10.0)
        row[3 + 3 * k] = _cut(turned / math.pi)
        row[4 + 3 * k] = _cut(bends / 10.0)
    row[8], row[9] = _cut(others[0] / 100.0), _cut(others[1])
    row[10], row[11], row[12] = _cut(others[2] / 25.0), others[3], others[4]
    # The nearest objects, in the car's frame.
    # Invariant: `apart` is infinite for the k objects that are shown already, the nearest ones.
    apart = np.hypot(poses[:, 0] - x, poses[:, 1] - y)
    for k in range(min(len(apart), (len(row) - OWN) // EACH)):
        i = np.argmin(apart)
        apart[i] = np.inf  # It has been taken.
        dx, dy = poses[i, 0] - x, poses[i, 1] - y
        turned = poses[i, 2] - heading
        turned_cos, turned_sin = np.cos(turned), np.sin(turned)
        at = OWN + EACH * k
        row[at] = 1.0
        row[at + 1] = _cut((cos * dx + sin * dy) / RANGE)
        row[at + 2] = _cut((cos * dy - sin * dx) / 20.0)
        row[at + 3] = _cut((speeds[i] * turned_cos - speed) / 25.0)
        row[at + 4] = _cut(speeds[i] * turned_sin / 25.0)
        row[at + 5], row[at + 6] = turned_cos, turned_sin
        row[at + 7], row[at + 8] = _cut(lengths[i] / 20.0), _cut(widths[i] / 4.0)


@kernel(nogil=True)
def _cut(value: float) -> float:
    return float(min(max(value, -1.0), 1.0))
