"""Poses of a car from its inertial and satellite unit, and its measurements along given poses.

The *world frame* has x to the east, y to the north, z up; a pose is the transform from the unit
(x forward, y left, z up) to the world, as in KITTI's raw devkit and in pykitti: latitude and
longitude by a Mercator projection that is to scale at the first position, which is the origin;
orientation ``Rz(yaw) Ry(pitch) Rx(roll)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.kitti.oxts import Oxts

EARTH_RADIUS = 6378137.0
"""Metres, as KITTI's devkit has it."""
GRAVITY = 9.81
"""m/s^2."""
KARLSRUHE = (49.0, 8.4, 115.0)
"""Latitude and longitude in degrees, altitude in metres: where KITTI was recorded."""

_ACCURACIES_AND_MODES = (0.05, 0.02, 4.0, 10.0, 6.0, 6.0, 6.0)


def poses_from_oxts(oxts: Oxts) -> Floats:
    """Where the unit was, relative to its first position.

    Returns:
        Shape (N, 4, 4): from the unit to the world frame, metres; the first translation is zero,
        the first rotation is the unit's own.
    """
    poses = np.tile(np.eye(4), (len(oxts), 1, 1))
    if len(oxts):
        radius = EARTH_RADIUS * np.cos(np.radians(oxts.lat[0]))
        east = radius * np.radians(oxts.lon)
        north = radius * np.log(np.tan(np.radians(90.0 + oxts.lat) / 2))
        places = np.stack([east, north, oxts.alt], axis=1)
        poses[:, :3, 3] = places - places[0]
        poses[:, :3, :3] = _about_z(oxts.yaw) @ _level_from_unit(oxts.roll, oxts.pitch)
    return poses


def oxts_from_poses(
    poses: ArrayLike,
    *,
    origin: tuple[float, float, float] = KARLSRUHE,
    period: float = 0.1,
) -> Oxts:
    """What the unit would measure along the poses: the inverse of `poses_from_oxts`.

    Velocities and angular rates are central differences (one-sided of second order at the ends),
    accelerations their differences; angular rates are of the unit's own frame.

    Args:
        poses: Poses from the unit to the world frame, shape (N, 4, 4), N >= 1.
        origin: Latitude, longitude (degrees) and altitude (metres) of the first position.
        period: Time from pose to pose, seconds.

    Raises:
        ConfigurationError: No poses, another shape, a rotation that is none, or an origin or
            period that cannot be.
    """
    poses = np.asarray(poses, np.float64)
    latitude, longitude, altitude = origin
    _check(poses, latitude, period)
    rotation, places = poses[:, :3, :3], poses[:, :3, 3] - poses[0, :3, 3]

    radius = EARTH_RADIUS * np.cos(np.radians(latitude))
    north = radius * np.log(np.tan(np.radians(90.0 + latitude) / 2)) + places[:, 1]
    latitudes = np.degrees(2 * np.arctan(np.exp(north / radius))) - 90.0
    longitudes = longitude + np.degrees(places[:, 0] / radius)

    yaw = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    pitch = -np.arcsin(np.clip(rotation[:, 2, 0], -1, 1))
    roll = np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2])

    to_level = _about_z(-yaw)
    velocity = _at_samples(np.diff(places, axis=0) / period)
    push = _at_samples(np.diff(velocity, axis=0) / period)
    push[:, 2] += GRAVITY
    to_unit = rotation.transpose(0, 2, 1)
    turn = _at_samples(_rotation_vectors(to_unit[:-1] @ rotation[1:]) / period)
    columns = [
        latitudes,
        longitudes,
        altitude + places[:, 2],
        np.stack([roll, pitch, yaw], axis=1),
        velocity[:, [1, 0]],
        _apply(to_level, velocity),
        _apply(to_unit, push),
        _apply(to_level, push),
        turn,
        _apply(_level_from_unit(roll, pitch), turn),
        np.tile(_ACCURACIES_AND_MODES, (len(poses), 1)),
    ]
    return Oxts.from_rows(np.column_stack(columns))


def _check(poses: Floats, latitude: float, period: float) -> None:
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not len(poses):
        raise ConfigurationError(f"poses have shape (N, 4, 4) with N > 0, got {poses.shape}")
    rotation = poses[:, :3, :3]
    if not (
        np.isfinite(poses).all()
        and np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max() < 1e-6
        and (np.linalg.det(rotation) > 0).all()
    ):
        raise ConfigurationError("a pose holds a value that is not finite, or no rotation")
    if not (abs(latitude) < 85 and period > 0):
        raise ConfigurationError(
            f"the latitude is within 85 degrees and the period positive, got {latitude}, {period}"
        )


def _at_samples(steps: Floats) -> Floats:
    """Rates at N samples from the N - 1 mean rates between them, linear beyond the ends."""
    if len(steps) == 0:
        return np.zeros((1, 3))
    near, far = steps[:2][-1], steps[-2:][0]  # The step itself where there is but one.
    padded = np.vstack([2 * steps[0] - near, steps, 2 * steps[-1] - far])
    return np.asarray((padded[:-1] + padded[1:]) / 2)


def _rotation_vectors(rotations: Floats) -> Floats:
    """Axis times angle of rotations by less than half a turn, shape (N, 3)."""
    skew = rotations - rotations.transpose(0, 2, 1)
    axis = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1) / 2
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, (np.trace(rotations, axis1=1, axis2=2) - 1) / 2)
    scale = np.divide(angle, sine, out=np.ones_like(sine), where=sine > 0)
    return axis * scale[:, None]


def _about_z(angle: Floats) -> Floats:
    return _rotation(angle, 0, 1)


def _level_from_unit(roll: Floats, pitch: Floats) -> Floats:
    """From the unit's axes to its level ones, shape (N, 3, 3)."""
    return _rotation(pitch, 2, 0) @ _rotation(roll, 1, 2)


def _rotation(angle: Floats, first: int, second: int) -> Floats:
    """Rotations that turn one axis towards another, shape (N, 3, 3)."""
    result = np.tile(np.eye(3), (len(angle), 1, 1))
    result[:, first, first] = result[:, second, second] = np.cos(angle)
    result[:, second, first] = np.sin(angle)
    result[:, first, second] = -np.sin(angle)
    return result


def _apply(matrices: Floats, vectors: Floats) -> Floats:
    return np.einsum("nij,nj->ni", matrices, vectors)
