"""Sensor state vectors and their places."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.validation.state_posterior import state_indices, state_vectors


@pytest.mark.parametrize("sensors", [1, 4])
def test_vectors_stand_where_their_indices_say(sensors: int) -> None:
    states = state_vectors(sensors)
    assert states.shape == (2**sensors, sensors)
    assert state_indices(states).tolist() == list(range(2**sensors))
    assert not states[0].any()


@pytest.mark.parametrize("shape", [(4,), (3, 4), (2, 3, 4), (5, 2, 3, 4)])
def test_indices_of_any_number_of_axes(shape: tuple[int, ...]) -> None:
    states = np.random.default_rng(0).random(shape) < 0.5
    found = state_indices(states)
    assert found.shape == shape[:-1]
    np.testing.assert_array_equal(state_vectors(4)[found], states)
