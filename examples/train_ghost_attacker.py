"""Train a ghost-object attacker with PPO and hold it against rules, on held-out layouts.

    python examples/train_ghost_attacker.py   # a minute or two
    python examples/train_ghost_attacker.py --steps 65536 --held-out 200

In `avsec/GhostObject-v1` the attacker has one go at one of sixteen places.  The policy here scores
each place by the same small network, whatever its position in the list.
`benchmarks/ghost_places.py` compares it with more rules, searched as long as it learns.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

import avsec_gym
from avsec_gym.agents.place_policy import PlacePolicy, places_in
from avsec_gym.envs.sb3 import StableBaselinesVecEnv
from avsec_gym.metrics.clustered_shares import Share, share_of

ID = "avsec/GhostObject-v1"
TRAINING = {"name": "layouts", "seed": 0, "count": 400}
HELD_OUT = {"name": "layouts", "seed": 7, "count": 3000}

Rule = Callable[[np.ndarray], np.ndarray]
"""Observations of B episodes to the index of a place in each."""


def train(steps: int, seed: int) -> PPO:
    """PPO on the batched environment."""
    torch.set_num_threads(1)
    return agent_for(seed).learn(steps)


def agent_for(seed: int) -> PPO:
    """An agent that has learned nothing yet."""
    environment = VecMonitor(
        StableBaselinesVecEnv(gym.make_vec(ID, num_envs=256, scenarios=TRAINING))
    )
    return PPO(
        PlacePolicy,
        environment,
        n_steps=8,
        batch_size=512,
        n_epochs=4,
        learning_rate=2e-3,
        gamma=0.0,  # An episode is one step.
        clip_range=0.3,
        ent_coef=0.0,
        policy_kwargs={"log_std_init": -0.7},
        seed=seed,
        device="cpu",
    )


def rule_of(agent: PPO) -> Rule:
    """The place that a trained agent takes, without noise."""
    return lambda seen: agent.predict(seen, deterministic=True)[0].argmax(axis=1)


def wins(rule: Rule, episodes: int, seed: int) -> Share:
    """How many of some held-out plans a rule makes unsafe; those of one scene are a cluster."""
    envs = gym.make_vec(ID, num_envs=episodes, scenarios=HELD_OUT)
    observations, drawn = envs.reset(seed=seed)
    actions = np.full(envs.action_space.shape, -1.0, np.float32)
    actions[np.arange(episodes), rule(observations)] = 1.0
    info = envs.step(actions)[-1]
    envs.close()
    return share_of(info["is_success"], drawn["scenario"].tolist())


def rate(won: Share) -> dict[str, Any]:
    """Success with its 95 % interval."""
    return {"episodes": won.of, "success_rate": won.rate, "interval": won.interval}


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=80_000, help="training steps")
    parser.add_argument("--held-out", type=int, default=1000, help="episodes to judge by")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    gym.register_envs(avsec_gym)
    generator = np.random.default_rng(options.seed)
    rules: dict[str, Rule] = {
        "random": lambda seen: generator.integers(places_in(seen).shape[1], size=len(seen)),
        "first": lambda seen: np.zeros(len(seen), int),
        "nearest": lambda seen: np.hypot(*np.moveaxis(near(seen), -1, 0)).argmin(axis=1),
    }
    begun = time.process_time()
    agent = train(options.steps, options.seed)
    seconds = time.process_time() - begun
    rules["ppo"] = rule_of(agent)
    result: dict[str, Any] = {
        name: rate(wins(rule, options.held_out, options.seed)) for name, rule in rules.items()
    }
    result |= {"training_cpu_seconds": round(seconds), "training_steps": agent.num_timesteps}
    print(json.dumps(result, indent=1))


def near(seen: np.ndarray) -> np.ndarray:
    """x and y of the places, m, shape (B, K, 2)."""
    from avsec_gym.envs.place_features import PlaceFeatures

    return PlaceFeatures.decode(places_in(seen)).positions


if __name__ == "__main__":
    main()
