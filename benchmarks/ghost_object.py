"""Steps a second of `avsec/GhostObject-v0`, single and batched, with random actions; prints JSON.

python benchmarks/ghost_object.py
"""

from __future__ import annotations

import json
import os
import time

import gymnasium as gym
import numpy as np

import avsec_gym

SECONDS = 5.0


def single() -> float:
    """One environment, resets included."""
    env = gym.make("avsec/GhostObject-v0", disable_env_checker=True)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(256)]
    env.reset(seed=0)

    def run(seconds: float) -> float:
        steps, begun = 0, time.perf_counter()
        while time.perf_counter() - begun < seconds:
            *_, terminated, truncated, _ = env.step(actions[steps % 256])
            steps += 1
            if terminated or truncated:
                env.reset()
        return steps / (time.perf_counter() - begun)

    run(SECONDS)  # compiles, and lays the scenes out
    return run(SECONDS)


def batched(count: int) -> float:
    """Many environments in one batch; steps that only reset are not counted."""
    envs = gym.make_vec("avsec/GhostObject-v0", num_envs=count)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(32)]
    envs.reset(seed=0)

    def run(seconds: float) -> float:
        steps, turn, begun = 0, 0, time.perf_counter()
        while time.perf_counter() - begun < seconds:
            *_, info = envs.step(actions[turn % 32])
            steps += int(np.count_nonzero(info["outcome"] != "reset"))
            turn += 1
        return steps / (time.perf_counter() - begun)

    run(SECONDS)
    return run(SECONDS)


def main() -> None:
    """Measure on one core, print JSON."""
    gym.register_envs(avsec_gym)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    result = {
        "environment": "avsec/GhostObject-v0",
        "cores": 1,
        "single_steps_per_second": round(single()),
        "batched_steps_per_second": {str(n): round(batched(n)) for n in (16, 64, 256)},
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
