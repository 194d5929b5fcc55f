"""The pulses of one turn of a LiDAR: where each begins, and where it goes."""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel


@kernel()
def aim_pulses(  # type: ignore[no-untyped-def]
    elevation, shift, height, column, pulse, rotation, place, origins, directions
):
    """Origins and directions of pulses in the world, into the last two arguments.

    Args:
        elevation: True elevation of each laser, radians, shape (L,).
        shift: Azimuth of each laser ahead of its head's direction, radians, shape (L,).
        height: Where each laser's rays begin above the origin, metres, shape (L,).
        column: Directions of the head at which all lasers fire, radians, shape (C,).
        pulse: Numbers of the pulses, laser by laser, shape (n,), each below L * C.
        rotation: The rotation from the velodyne frame to the world when each column fires, shape
            (C, 3, 3), or (1, 3, 3) for a LiDAR at rest.
        place: The same of the origin, metres, shape (C, 3) or (1, 3).
        origins: Result, metres, written in place, shape (n, 3).
        directions: Result, unit vectors, written in place, shape (n, 3).
    """
    columns = len(column)
    moves = len(rotation) > 1
    column_sin, column_cos = np.sin(column), np.cos(column)
    shift_sin, shift_cos = np.sin(shift), np.cos(shift)
    up_sin, up_cos = np.sin(elevation), np.cos(elevation)
    for i in range(len(pulse)):
        laser, c = divmod(pulse[i], columns)
        sine, cosine = _of_sum(column_sin[c], column_cos[c], shift_sin[laser], shift_cos[laser])
        x, y, z = up_cos[laser] * cosine, up_cos[laser] * sine, up_sin[laser]
        k = c if moves else 0
        for axis in range(3):
            directions[i, axis] = (
                rotation[k, axis, 0] * x + rotation[k, axis, 1] * y + rotation[k, axis, 2] * z
            )
            origins[i, axis] = place[k, axis] + rotation[k, axis, 2] * height[laser]


@kernel()
def place_points(  # type: ignore[no-untyped-def]
    elevation, shift, height, column, pulse, distance, places
):
    """Where pulses end in the velodyne frame by the calibration, into the last argument.

    Args:
        elevation: Calibrated elevation of each laser, radians, shape (L,).
        shift: Azimuth of each laser ahead of its head's direction, radians, shape (L,).
        height: Where each laser's rays begin above the origin, metres, shape (L,).
        column: Directions of the head at which all lasers fire, radians, shape (C,).
        pulse: Numbers of the pulses, laser by laser, shape (n,), each below L * C.
        distance: Measured ranges, metres, shape (n,).
        places: Result, metres, written in place, shape (n, 3).
    """
    columns = len(column)
    column_sin, column_cos = np.sin(column), np.cos(column)
    shift_sin, shift_cos = np.sin(shift), np.cos(shift)
    up_sin, up_cos = np.sin(elevation), np.cos(elevation)
    for i in range(len(pulse)):
        laser, c = divmod(pulse[i], columns)
        sine, cosine = _of_sum(column_sin[c], column_cos[c], shift_sin[laser], shift_cos[laser])
        places[i, 0] = distance[i] * up_cos[laser] * cosine
        places[i, 1] = distance[i] * up_cos[laser] * sine
        places[i, 2] = distance[i] * up_sin[laser] + height[laser]


@kernel()
def _of_sum(sin_a, cos_a, sin_b, cos_b):  # type: ignore[no-untyped-def]
    """Sine and cosine of a sum of two angles, by those of its parts, of which there are few."""
    return sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b
