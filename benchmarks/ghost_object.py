"""Steps a second of `avsec/GhostObject-v0` and `-v1`, single and batched; prints JSON.

    python benchmarks/ghost_object.py

Random actions on one core, resets included, by CPU time.  v1 plans the car's answers when a scene
is first drawn and remembers them: `first_episodes` is the time of that, the other figures are of
scenes that were drawn before.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np

import avsec_gym

SECONDS = 2.0
"""CPU time of each measurement."""
VERSIONS = ("avsec/GhostObject-v0", "avsec/GhostObject-v1")


def rate(turn: Callable[[], int]) -> float:
    """Steps a second of CPU time; a turn returns how many it took."""
    steps, begun = 0, time.process_time()
    while time.process_time() - begun < SECONDS:
        steps += turn()
    return steps / (time.process_time() - begun)


def single(id: str) -> dict[str, int]:
    """One environment; the first episodes compile, and lay the scenes out."""
    env = gym.make(id, disable_env_checker=True)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(256)]
    env.reset(seed=0)
    steps = 0

    def turn() -> int:
        nonlocal steps
        *_, terminated, truncated, _ = env.step(actions[steps % 256])
        steps += 1
        if terminated or truncated:
            env.reset()
        return 1

    first = rate(turn)
    warm_up(env.unwrapped.game)  # type: ignore[attr-defined]
    return {"first_episodes": round(first), "steps_per_second": round(rate(turn))}


def batched(id: str, count: int) -> int:
    """Many environments in one batch; steps that only reset are not counted."""
    envs = gym.make_vec(id, num_envs=count)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(32)]
    envs.reset(seed=0)
    warm_up(envs.unwrapped.game)  # type: ignore[attr-defined]
    turns = 0

    def turn() -> int:
        nonlocal turns
        *_, info = envs.step(actions[turns % 32])
        turns += 1
        return int(np.count_nonzero(info["outcome"] != "reset"))

    rate(turn)
    return round(rate(turn))


def warm_up(game: Any) -> None:
    """Draw until every scene has been laid out, or nearly so."""
    generator = np.random.default_rng(0)
    for _ in range(4000):
        game.draw_all([generator], None)


def main() -> None:
    """Measure, print JSON."""
    gym.register_envs(avsec_gym)
    result = {
        id: {
            "single": single(id),
            "batched_steps_per_second": {str(n): batched(id, n) for n in (16, 64, 256)},
        }
        for id in VERSIONS
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
