"""Walking: the posture at each phase of the gait cycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.world.models.people.skeleton import SIDES, Posture

# Joint angles of natural walking in degrees at twentieths of the cycle, which begins when the heel
# strikes (after Winter, Biomechanics and Motor Control of Human Movement).
_HIP = (24, 22, 19, 16, 12, 8, 4, 0, -4, -8, -11, -11, -7, 0, 9, 17, 22, 25, 26, 25)
_KNEE = (5, 11, 17, 18, 15, 12, 9, 7, 6, 8, 13, 22, 36, 52, 62, 61, 50, 32, 14, 5)
_ANKLE = (0, -6, -3, 1, 3, 5, 6, 7, 9, 8, 4, -6, -16, -15, -8, -2, 1, 2, 2, 1)


def walking(phase: float, hurry: float = 0.0) -> Posture:
    """The posture of a walking person; at phase 0 the right heel strikes, at 0.5 the left one.

    Args:
        phase: Phase of the gait cycle; whole numbers do not matter.
        hurry: Hurry from 0 to 1: how quickly the legs pass each other, for people of long strides.
    """
    phase += 0.9 * hurry * float(np.sin(4.0 * np.pi * (phase - 0.31))) / (4.0 * np.pi)
    legs = np.array([phase, phase + 0.5])
    swing = np.cos(2.0 * np.pi * (legs - 0.02))
    turn = float(np.cos(2.0 * np.pi * phase))
    forward = -swing
    return Posture(
        thigh=_angle(_HIP, legs),
        spread=np.full(2, -0.035) + 0.02 * np.sin(2.0 * np.pi * legs),
        knee=_angle(_KNEE, legs),
        ankle=_angle(_ANKLE, legs),
        arm=0.02 + 0.40 * forward,
        arm_spread=np.full(2, 0.13),
        elbow=0.38 + 0.22 * forward,
        lean=0.06,
        pelvis_turn=0.10 * turn,
        chest_turn=-0.13 * turn,
        pelvis_drop=-0.07 * float(np.sin(2.0 * np.pi * phase)),
        sway=-0.010 * float(np.sin(2.0 * np.pi * phase)),
        toe_out=np.full(2, 0.12) - 0.1 * turn * SIDES,
    )


METRES_PER_CRANK = 5.0
"""Metres that a bicycle rolls in one turn of its pedals."""


def stride_length(height: ArrayLike) -> Floats:
    """Metres walked in one cycle of two steps by people of given heights, metres, shape (...)."""
    return 0.82 * np.asarray(height, float)


def _angle(table: tuple[int, ...], phase: Floats) -> Floats:
    """Radians at phases, shape (2,), by smooth periodic interpolation."""
    values = np.radians(np.array(table, float))
    position = (phase % 1.0) * len(values)
    start = np.floor(position).astype(int)
    share = position - start
    p = values[(start[:, None] + np.arange(-1, 3)) % len(values)]
    slope, next_slope = 0.5 * (p[:, 2] - p[:, 0]), 0.5 * (p[:, 3] - p[:, 1])
    rise = p[:, 2] - p[:, 1]
    bend = 3.0 * rise - 2.0 * slope - next_slope
    twist = slope + next_slope - 2.0 * rise
    return np.asarray(p[:, 1] + share * (slope + share * (bend + share * twist)))
