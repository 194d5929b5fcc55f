"""Rules that hide what is in the way: what they see, and when they act."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

import avsec_gym
from avsec_gym.agents.hiding_rules import (
    OFF,
    ghost_at,
    hidden_at,
    in_the_way,
    waits,
    when_it_plans,
)
from avsec_gym.envs.closed_loop_observation import EACH, OWN

SIZE = 177


def seen(*places: tuple[float, float], left: float = 1.0) -> NDArray[np.float32]:
    """One observation of a car in the middle of a straight lane, with objects at places, metres."""
    observation = np.zeros(SIZE, np.float32)
    observation[9] = left
    rows = observation[OWN : OWN + EACH * len(places)].reshape(len(places), EACH)
    for row, (ahead, aside) in zip(rows, places, strict=True):
        row[:3] = 1.0, ahead / 50.0, aside / 20.0
    return observation[None]


def test_the_nearest_in_a_lane_is_in_the_way() -> None:
    [found] = in_the_way(seen((4.0, 3.0), (1.0, 0.0), (20.0, -1.5), (12.0, 1.5)), 50.0)
    assert found == pytest.approx([12.0, 1.5], abs=1e-4)
    assert in_the_way(seen((4.0, 3.0), (30.0, 0.0)), 25.0) == [None]
    assert in_the_way(seen(), 25.0) == [None]


def test_a_lane_that_bends_takes_its_way_along() -> None:
    observation = seen((15.0, 4.0), (15.0, 0.0))
    observation[:, 4] = observation[:, 7] = 0.4  # 4 m to the left at 15 m.
    [found] = in_the_way(observation, 50.0)
    assert found == pytest.approx([15.0, 4.0], abs=1e-4)


def test_the_lane_of_the_goal_counts_as_well() -> None:
    observation = seen((15.0, 3.5))
    assert in_the_way(observation, 50.0) == [None]
    # The car is 3.5 m to the right of the goal's lane, which goes on beside its own.
    observation[:, 5], observation[:, 7] = -0.35, 0.35
    [found] = in_the_way(observation, 50.0)
    assert found == pytest.approx([15.0, 3.5], abs=1e-4)


def test_one_frame_of_five_is_attacked() -> None:
    for step in range(80):
        [action] = when_it_plans(50.0)(seen((12.0, 0.0), left=1.0 - step / 80))
        wanted = hidden_at(12.0, 0.0) if step % 5 == 4 else OFF
        np.testing.assert_allclose(action, wanted, atol=1e-6)
        np.testing.assert_allclose(
            waits(50.0)(seen((12.0, 0.0)))[0], hidden_at(12.0, 0.0), atol=1e-6
        )


def test_actions_are_those_of_the_default_attack() -> None:
    """A hide at a car hides that car; a ghost lies where it is laid."""
    gym.register_envs(avsec_gym)
    env = gym.make(
        "avsec/ClosedLoopAttack-v0", scenarios={"source": "layouts", "seed": 0, "count": 4}
    )
    observation, _ = env.reset(seed=0)
    assert observation.shape == (SIZE,)
    rows = observation[OWN : OWN + EACH * 16].reshape(16, EACH)
    car = next(row for row in rows if row[0] > 0 and 0.1 < row[1] < 0.9 and abs(row[2]) < 0.4)
    place = 50.0 * float(car[1]), 20.0 * float(car[2])
    observation, _, _, _, info = env.step(hidden_at(*place))
    assert (info["hidden"], info["ghosts"]) == (1, 0)
    hidden = observation[-15:-12]
    assert 50.0 * hidden[1:] == pytest.approx(place, abs=3.0), "a tenth of a second later"
    _, _, _, _, info = env.step(ghost_at(20.0, 0.0))
    assert (info["hidden"], info["ghosts"]) == (0, 1)
