"""Poses as a vehicle measures them: satellite navigation and a map, with errors that drift.

The ground of an HD map gives height, roll and pitch; what errs is the place on the ground and the
heading.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.drives import STEP

_CORRELATED = 5.0
"""Seconds after which an error has forgotten all but 1 / e of itself."""
_ERROR_SEED, _CLOCK_SEED = 21, 22


def pose_errors(seed: int, drive: int, vehicle: int, frames: int) -> Floats:
    """Errors of unit size along x and y and of the heading at each frame of a drive.

    They are Gaussian with standard deviation 1 at every frame, and drift from frame to frame (an
    autoregressive process).  The first frames do not depend on how many there are.

    Args:
        seed: Seed of the data set.
        drive: Number of the drive.
        vehicle: Number of the vehicle.
        frames: Number of frames, 0.1 s apart.

    Returns:
        Shape (frames, 3).
    """
    numbers = (seed, drive, vehicle, _ERROR_SEED)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(numbers)))
    kept = float(np.exp(-STEP / _CORRELATED))
    errors = rng.standard_normal((frames, 3))
    errors[1:] *= np.sqrt(1.0 - kept**2)
    for frame in range(1, frames):
        errors[frame] += kept * errors[frame - 1]
    return errors


def measured_pose(pose: Floats, error: Floats, position: float, heading: float) -> Floats:
    """A pose with a measurement's error: shifted along the ground, turned about its own place.

    Args:
        pose: True transform to the world, shape (4, 4).
        error: Error of unit size along x, y and of the heading, shape (3,).
        position: Standard deviation along x and along y, metres.
        heading: Standard deviation of the heading, degrees.
    """
    angle = np.radians(heading) * error[2]
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    result = pose.copy()
    result[:3, :3] = turn @ pose[:3, :3]
    result[:2, 3] += position * error[:2]
    return result


def clock_offsets(seed: int, drive: int, vehicles: int, apart: float) -> Floats:
    """By how much each vehicle's trigger comes after the instant, seconds, shape (vehicles,).

    Sensors of different vehicles are not triggered together: each has a phase of its own, which
    it keeps over a drive.

    Args:
        seed: Seed of the data set.
        drive: Number of the drive.
        vehicles: Number of vehicles.
        apart: Longest time between two vehicles' triggers, seconds.
    """
    numbers = (seed, drive, _CLOCK_SEED)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(numbers)))
    return np.round(apart * rng.random(vehicles), 4)
