"""The sensor systems and false alarm rates of the thesis' chapter 3."""

from __future__ import annotations

from avsec_gym.sensor_system import Triple

SCENARIOS: dict[str, Triple] = {"LiDAR and two cameras": (0, 2, 3), "three cameras": (1, 2, 3)}
"""Scenarios of a LiDAR and three cameras."""
RATES = (0.0, 0.01, 0.02, 0.03, 0.05)
"""Designated false alarm rates of the thesis' tables."""
CURVE_RATES = (*RATES, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""And of its figures."""
