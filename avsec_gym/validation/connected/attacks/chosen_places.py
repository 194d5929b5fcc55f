"""Places that matter to an attacker: in the victim's path, and where no other vehicle looks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.claims import claim
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.rays.witness_counts import count_rays
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

GhostArea = Literal["anywhere", "path", "blind_spot"]
"""Where a ghost is put: on any free ground (the thesis), in the victim's path, or where the rays of
the other vehicles show least."""


def place_in_path(sweep: RollingSweep, distance: float) -> tuple[float, float]:
    """Where a vehicle is after it has driven so far as it turns now, its own frame, metres.

    Args:
        sweep: The scan's sweep, with the vehicle's speed and turn rate by its own odometry.
        distance: Length of the arc, metres.
    """
    # One that stands, or whose motion is compensated, is taken to drive straight ahead.
    if sweep.speed <= _STANDS:
        return distance, 0.0
    # The chord of an arc, half of its angle off the heading.
    angle = sweep.turn_rate * distance / sweep.speed
    chord = distance * float(np.sinc(0.5 * angle / np.pi))
    return chord * float(np.cos(0.5 * angle)), chord * float(np.sin(0.5 * angle))


_STANDS = 0.5
"""Speed up to which the turn rate shows no path, m/s."""


def other_observers(instant: RecordedInstant, victim: int) -> list[Observer]:
    """What the others see from where they really are.

    Args:
        instant: What all vehicles scanned.
        victim: Number of the victim, who is left out.
    """
    return [
        observe(VehicleScan(scan.points, instant.true_pose(number), scan.time, scan.sweep))
        for number, scan in enumerate(instant.scans)
        if number != victim
    ]


def telling_rays(
    others: Sequence[Observer], ghost: Floats, box: Regions, victim: Floats, time: float
) -> int:
    """How many voxels of a ghost some other vehicle's rays end in or pass through, of all others.

    Where they are few, no other vehicle can contradict the ghost.  Arguments as of `rays_at_ghost`.
    """
    return int(rays_at_ghost(others, ghost, box, victim, time).sum())


def rays_at_ghost(
    others: Sequence[Observer], ghost: Floats, box: Regions, victim: Floats, time: float
) -> NDArray[np.int64]:
    """How many voxels of a ghost each other vehicle's rays end in or pass through, shape (O,).

    Args:
        others: The other vehicles, as of `other_observers`.
        ghost: The ghost's points, velodyne frame of the victim, metres, shape (M, 3).
        box: Its box in the world, one region.
        victim: True pose of the victim's velodyne, shape (4, 4).
        time: Time of the victim's scan after the instant, seconds.
    """
    points = np.c_[ghost, np.zeros(len(ghost))].astype(np.float32)
    claims = claim(observe(VehicleScan(points, victim, time, RollingSweep(period=0.0))), box)
    counts = [count_rays(other, claims, box, EXACT_MARGINS).counts for other in others]
    return np.array([int(each[:, :2].sum()) for each in counts], np.int64)


EXACT_MARGINS = WitnessMargins(position_noise=0.0, heading_noise=0.0, fastest=0.0)
"""Margins of rays from true poses, of what stands."""
