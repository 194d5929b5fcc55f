"""The kernel that drives the car, held against `simulate`."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.integration import SUBSTEPS, driven
from avsec_gym.planners.vehicle import BMW_320I, simulate


def test_it_drives_as_simulate_does() -> None:
    rng = np.random.default_rng(0)
    start = rng.uniform(-1, 1, (50, 5)) * (9, 9, 6, 3, 0.5) + (0, 0, 7, 0, 0)
    acceleration, rate = rng.uniform(-8, 8, 50), rng.uniform(-0.4, 0.4, 50)
    expected = simulate(BMW_320I, start, acceleration, rate, 7, 0.1, substeps=SUBSTEPS)
    np.testing.assert_allclose(driven(start, acceleration, rate, 7, 0.1), expected, atol=1e-12)
