"""Angles in kernels; `avsec_gym.geometry.wrap_angle` is the same of arrays."""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel


@kernel(nogil=True)
def wrapped(angle: float) -> float:
    """The same direction in [-pi, pi)."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
