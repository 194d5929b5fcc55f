"""Few rays, made one by one, and where a vehicle's head looks: the judge of single kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.range_image import RangeImage
from avsec_gym.validation.connected.sweep import TIP

COLUMNS, ROWS, CELL = 1200, 300, np.radians(0.3)
"""Cells of an image, and how wide they are."""
Motion = tuple[float, float, float]
"""Speed, turn rate, period."""


def image_of(
    directions: Floats,
    distance: Floats,
    motion: Motion,
    view: tuple[float, float] = (-np.pi / 4, np.pi / 4),
) -> RangeImage:
    """The image of rays.

    Args:
        directions: Azimuth and elevation of each, shape (M, 2).
        distance: How far each came, shape (M,).
        motion: Of the vehicle.
        view: The lowest and the highest elevation of the sensor.
    """
    azimuth, elevation = np.float32(directions).reshape(-1, 2).T.astype(float)
    far = np.float32(distance).astype(float)
    azimuth = (azimuth + np.pi) % (2 * np.pi) - np.pi
    row = np.clip(elevation / CELL + 150, 0, ROWS - 1).astype(int)
    column = ((azimuth + np.pi) / CELL).astype(int) % COLUMNS
    cell = row * COLUMNS + column
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(ROWS * COLUMNS + 1)).astype(np.int32)
    flat = far * np.cos(elevation)
    vehicle, heading = after(azimuth * motion[2] / (2 * np.pi), motion)
    seen = vehicle + heading * flat * np.exp(1j * azimuth)
    end = np.stack([seen.real, seen.imag, far * np.sin(elevation) + TIP], axis=1)
    columns = (np.float32(each[order]) for each in (azimuth, elevation, far))
    return RangeImage(start, *columns, np.float32(end[order]), *view)


def after(
    seconds: Floats | float, motion: Motion
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Where a vehicle is that drives on a circle, and where it heads; x + iy."""
    speed, turn_rate, _ = motion
    heading = np.asarray(np.exp(1j * turn_rate * seconds))
    if turn_rate == 0.0:
        return np.asarray(speed * seconds + 0j), heading
    return np.asarray(1j * speed / turn_rate * (1.0 - heading)), heading


def faced(
    to_sensor: Floats, motion: Motion, age: float, place: Floats, velocity: Floats
) -> tuple[Floats, float, float, float]:
    """Where a place is in the sensor's frame when the head faces it, by two looks.

    Returns:
        The place, shape (3,); seconds since it was at its place; the time of the frame; by how
        much that may be off.
    """
    later, next_time, time, here = 0.0, 0.0, 0.0, np.zeros(3)
    for _ in range(2):
        later = age + next_time
        moved = np.array([*(place[:2] + later * velocity), place[2], 1.0])
        x, y, z, _ = to_sensor @ moved
        time = float(np.arctan2(y, x)) * motion[2] / (2 * np.pi)
        vehicle, heading = after(time, motion)
        seen = (complex(x, y) - vehicle) / heading
        here = np.array([seen.real, seen.imag, z])
        next_time = float(np.angle(seen)) * motion[2] / (2 * np.pi)
    return here, later, time, abs(next_time - time)


def tilted_pose(rng: np.random.Generator, tilt: float = 0.08) -> Floats:
    """A sensor that leans a little, anywhere."""
    pose = np.eye(4)
    angles = rng.uniform(-1, 1, 3) * (np.pi, tilt, tilt)
    pose[:3, :3] = Rotation.from_euler("zyx", angles).as_matrix()
    pose[:3, 3] = rng.uniform((-20, -20, 1.5), (20, 20, 2.0))
    return pose
