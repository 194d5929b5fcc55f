"""The vector form of `avsec/ClosedLoopAttack-v0` plays what single ones play, step for step."""

from __future__ import annotations

import inspect
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym.closed_loop.attack.lasting_ghosts import LastingGhosts
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.envs.closed_loop_attack_vector import ClosedLoopAttackVectorEnv
from avsec_gym.errors import ConfigurationError
from tests.envs.test_closed_loop_attack import LEAD
from tests.envs.test_closed_loop_vector import ERRORS, same_info

ID = "avsec/ClosedLoopAttack-v0"
FEW = {"source": "layouts", "count": 6}


@pytest.mark.parametrize(
    ("arguments", "steps", "wins"),
    [
        ({"scenarios": FEW}, 60, False),
        pytest.param(
            {"scenarios": FEW, "perception": ERRORS, "motion": "static"},
            60,
            False,
            marks=pytest.mark.slow,
        ),
        pytest.param(
            {"scenarios": LEAD, "contested": True, "frames": 80, "energy": 80.0},
            70,
            True,
            marks=pytest.mark.slow,
        ),
        (
            {
                "scenarios": FEW,
                "kind": {"name": "ghost", "ghosts": 2, "hides": 0},
                "driver": {"name": "planner", "replanning": 0.2},
                "duration": 2.0,
            },
            45,
            False,
        ),
    ],
)
def test_it_plays_what_single_ones_play(arguments: dict[str, Any], steps: int, wins: bool) -> None:
    """Attackers that keep at what they do for a while, over drives that end and begin anew."""
    count, seed = 3, 5
    many: Any = gym.make_vec(
        ID, num_envs=count, vectorization_mode="vector_entry_point", **arguments
    )
    assert isinstance(many, ClosedLoopAttackVectorEnv)
    singles = [gym.make(ID, disable_env_checker=True, **arguments) for _ in range(count)]
    observations, infos = many.reset(seed=seed)
    for i, env in enumerate(singles):
        observation, info = env.reset(seed=seed + i)
        np.testing.assert_allclose(observations[i], observation, atol=1e-6)
        same_info(infos, i, info)
    generator = np.random.default_rng(0)
    habits = generator.uniform(-1, 1, (steps, *many.action_space.shape))
    if wins:  # Hide what is ahead.
        habits[:] = (-1.0, 0, 0, 0, 1, 0, 0)
    ended, successes, ends = [False] * count, 0, 0
    for step in range(steps):
        actions = habits[step // 20].astype(np.float32)
        observations, rewards, terminated, truncated, infos = many.step(actions)
        for i, env in enumerate(singles):
            expected: tuple[float, bool, bool] = (0.0, False, False)
            if ended[i]:  # Autoreset mode NEXT_STEP: this action is not used.
                observation, info = env.reset()
            else:
                observation, *expected, info = env.step(actions[i])  # type: ignore[assignment]
            ended[i] = expected[1] or expected[2]
            np.testing.assert_allclose(observations[i], observation, atol=1e-6)
            assert rewards[i] == pytest.approx(expected[0], abs=1e-9)
            assert (terminated[i], truncated[i]) == tuple(expected[1:])
            same_info(infos, i, info)
            successes, ends = successes + info["is_success"], ends + ended[i]
    assert ends
    assert bool(successes) == wins


def test_every_argument_reaches_the_single_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for those that only one value is accepted of."""
    own = inspect.signature(ClosedLoopAttackVectorEnv.__init__).parameters
    refused = {"traffic", "config", "render_mode"}
    names = own.keys() - {"self", "num_envs", "parts", *refused}
    given = {name: object() for name in names} | {"kind": "ghost", "perception": "truth"}
    reached: dict[str, Any] = {}

    class Reached(Exception):
        """Nothing is made of them."""

    def single(**arguments: Any) -> None:
        reached.update(arguments)
        raise Reached

    module = "avsec_gym.envs.closed_loop_attack_vector"
    monkeypatch.setattr(f"{module}.ClosedLoopAttackEnv", single)
    with pytest.raises(Reached):
        ClosedLoopAttackVectorEnv(scenarios=FEW, **given)
    assert reached == {**given, "scenarios": FEW}


def test_drives_without_the_attack_are_made_once_for_all() -> None:
    """And by a perception of their own: a drive that is judged disturbs none that goes on."""
    many = ClosedLoopAttackVectorEnv(3, scenarios=LEAD, perception=ERRORS)
    judged = {id(alone.unattacked) for alone in many.alone}
    assert len(judged) == 1
    perceptions = [alone.perception for alone in many.alone]
    assert len({id(each) for each in perceptions}) == 3
    assert many.alone[0].unattacked._drive.perception.perception not in perceptions


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kind": LastingGhosts()}, "name their attack.*sync"),
        ({"kind": "facula", "perception": "sensors"}, "error model.*sync"),
        ({"kind": "facula"}, 'perception="sensors"'),
        ({"perception": type("Mine", (TruthPerception,), {})()}, "error model.*sync"),
        ({"traffic": "reacting"}, "recorded traffic.*sync"),
        ({"config": {"policy_frequency": 5}}, "config.*sync"),
        ({"render_mode": "rgb_array"}, "not rendered.*sync"),
        ({"frames": 0}, "frames"),
        ({"num_envs": 0}, "num_envs"),
        ({"attack": "facula"}, "the agent plays it"),
        ({"driver": "planer"}, 'mean "planner"'),
    ],
)
def test_what_only_a_single_environment_has_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        ClosedLoopAttackVectorEnv(**{"num_envs": 2, "scenarios": LEAD, **wrong})
