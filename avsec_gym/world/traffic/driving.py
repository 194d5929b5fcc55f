"""How fast to drive or walk: the Intelligent Driver Model, and speeds for bends.

Treiber, Hennecke, Helbing: Congested traffic states in empirical observations and microscopic
simulations. Physical Review E 62, 1805 (2000).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

LATERAL_ACCELERATION = 1.8
"""Lateral acceleration in bends, m/s2."""
HARDEST_BRAKING = 8.0
"""m/s2."""
_APPROACH_BRAKING = 1.2
"""Approach braking before bends, m/s2."""
RESPONSE = 0.6
"""Seconds that drivers look ahead for bends."""


class Manners(NamedTuple):
    """How N travellers follow: one value or shape (N,) each."""

    headway: Floats
    """Time gap to the one ahead, s."""
    standstill: Floats
    """Distance kept when standing, metres."""
    acceleration: Floats
    """m/s2."""
    braking: Floats
    """Comfortable, m/s2."""


@kernel()
def idm_interaction(
    speed: float,
    gap: float,
    closing: float,
    headway: float,
    standstill: float,
    acceleration: float,
    braking: float,
) -> float:
    """The desired gap over the actual one, squared: what one obstacle adds to the IDM.

    Args:
        speed: Speed of the follower, m/s.
        gap: Free distance to the obstacle, metres.
        closing: Own speed less that of the obstacle, m/s.
        headway: The follower's `Manners`, as the others.
        standstill: Gap that is kept at rest, metres.
        acceleration: Largest acceleration, m/s2.
        braking: Comfortable braking, m/s2.
    """
    dynamic = speed * headway + speed * closing / (2.0 * np.sqrt(acceleration * braking))
    return ((standstill + max(dynamic, 0.0)) / max(gap, 0.01)) ** 2


@kernel()
def calm_interaction(
    speed: float,
    gap: float,
    closing: float,
    headway: float,
    standstill: float,
    acceleration: float,
    braking: float,
) -> float:
    """`idm_interaction` without its panic.

    At high speed the IDM brakes hard for a vehicle little slower far ahead; here no driver brakes
    harder than comfortably plus half as hard again as it must.
    """
    felt = idm_interaction(speed, gap, closing, headway, standstill, acceleration, braking)
    needed = 0.5 * max(closing, 0.0) ** 2 / max(gap - 0.5 * standstill, 0.1)
    return min(felt, (braking + 1.5 * needed) / acceleration)


def idm_acceleration(
    speed: ArrayLike, desired: ArrayLike, interaction: ArrayLike, manners: Manners
) -> Floats:
    """Acceleration of the IDM, m/s2, not below the hardest braking.

    Args:
        speed: Speed of the follower, m/s.
        desired: Speed on a free road, m/s.
        interaction: Strongest `idm_interaction` with anything ahead.
        manners: Manners of the follower.
    """
    free = 1.0 - (np.asarray(speed, float) / np.maximum(desired, 0.1)) ** 4
    wanted = manners.acceleration * (free - np.asarray(interaction))
    return np.asarray(np.maximum(wanted, -HARDEST_BRAKING))


def equilibrium_gap(speed: ArrayLike, desired: ArrayLike, manners: Manners) -> Floats:
    """The gap in which a follower keeps its speed (equation 3 of the paper), metres."""
    speed = np.asarray(speed, float)
    wish = manners.standstill + speed * manners.headway
    return np.asarray(wish / np.sqrt(1.0 - np.minimum(speed / desired, 0.999) ** 4))


def slow_down(speed: Floats, limit: Floats, acceleration: Floats) -> Floats:
    """Acceleration that has come down to the limit of a bend in `RESPONSE` seconds.

    Args:
        speed: Present speed, m/s, shape (N,).
        limit: Speed limit on the way of the next `RESPONSE` seconds, m/s, shape (N,).
        acceleration: Wanted otherwise, m/s2, shape (N,).
    """
    return np.asarray(np.minimum(acceleration, np.maximum((limit - speed) / RESPONSE, -4.0)))


def bend_limits(curvature: Floats, spacing: float) -> Floats:
    """Highest speeds on a line, also those before a bend from which it is reached comfortably.

    Args:
        curvature: Curvature at even distances along the line, 1/m, shape (n,).
        spacing: Distance between these points, metres.
    """
    square = LATERAL_ACCELERATION / np.maximum(np.abs(curvature), 1e-4)
    climb = 2.0 * _APPROACH_BRAKING * spacing * np.arange(len(curvature))
    lowest = np.minimum.accumulate((square + climb)[::-1])[::-1]
    return np.sqrt(lowest - climb)
