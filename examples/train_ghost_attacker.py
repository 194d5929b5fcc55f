"""Train a ghost-object attacker with PPO and judge it on held-out layouts.

    python examples/train_ghost_attacker.py   # about a minute and a half
    python examples/train_ghost_attacker.py --steps 65536 --held-out 100

It is compared with random actions, and with the best of many constant actions: one for all scenes,
and one for each driving intention.  Only an attacker that looks at the scene beats those.
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
from avsec_gym.envs.sb3 import StableBaselinesVecEnv

TRAINING = {"name": "layouts", "seed": 0, "count": 1000}
HELD_OUT = {"name": "layouts", "seed": 1, "count": 400}
INTENTIONS = slice(2, 5)
"""Where an observation tells the intention, one-hot."""

Policy = Callable[[np.ndarray], np.ndarray]


def train(steps: int, seed: int) -> PPO:
    """PPO on the batched environment."""
    torch.set_num_threads(1)
    environment = VecMonitor(
        StableBaselinesVecEnv(
            gym.make_vec("avsec/GhostObject-v0", num_envs=256, scenarios=TRAINING)
        )
    )
    agent = PPO(
        "MlpPolicy",
        environment,
        n_steps=16,
        batch_size=1024,
        n_epochs=6,
        learning_rate=1e-3,
        gamma=0.9,
        ent_coef=2e-3,
        policy_kwargs={"net_arch": [128, 128], "log_std_init": -0.5},
        seed=seed,
        device="cpu",
    )
    return agent.learn(steps)


def constants(trials: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The best constant action of many, and the best for each intention, on training scenes."""
    envs = gym.make_vec("avsec/GhostObject-v0", num_envs=128, scenarios=TRAINING)
    generator = np.random.default_rng(seed)
    actions = generator.uniform(-1.0, 1.0, (trials, envs.single_action_space.shape[0]))
    actions[:, 0::4] = 1.0
    success = np.zeros((trials, 128))
    for trial, action in enumerate(actions):
        observations, _ = envs.reset(seed=seed)
        success[trial] = envs.step(np.tile(action, (128, 1)))[2]
    intention = observations[:, INTENTIONS].argmax(axis=1)
    best = actions[success.mean(axis=1).argmax()]
    by_intention = [actions[success[:, intention == i].mean(axis=1).argmax()] for i in range(3)]
    return best, np.array(by_intention)


def evaluate(policy: Policy, episodes: int, seed: int) -> dict[str, Any]:
    """Success, queries and reward on held-out layouts."""
    env = gym.make("avsec/GhostObject-v0", scenarios=HELD_OUT)
    successes, queries, rewards = [], [], []
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, info = env.step(policy(observation))
            total, over = total + float(reward), terminated or truncated
        successes.append(info["is_success"])
        queries.append(info["queries"])
        rewards.append(total)
    env.close()
    return {
        "episodes": episodes,
        "success_rate": float(np.mean(successes)),
        "queries": float(np.mean(queries)),
        "reward": float(np.mean(rewards)),
    }


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=400_000, help="training steps")
    parser.add_argument("--trials", type=int, default=400, help="constant actions to try")
    parser.add_argument("--held-out", type=int, default=300, help="episodes to judge by")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    gym.register_envs(avsec_gym)
    episodes, seed = arguments.held_out, arguments.seed
    generator = np.random.default_rng(seed)
    best, by_intention = constants(arguments.trials, seed)
    begun = time.perf_counter()
    agent = train(arguments.steps, seed)
    trained = time.perf_counter() - begun
    torch.manual_seed(seed)
    result: dict[str, Any] = {
        "random": evaluate(lambda _: generator.uniform(-1, 1, best.shape), episodes, seed),
        "constant": evaluate(lambda _: best, episodes, seed),
        "constant_by_intention": evaluate(
            lambda seen: by_intention[seen[INTENTIONS].argmax()], episodes, seed
        ),
        "ppo": evaluate(lambda seen: agent.predict(seen)[0], episodes, seed),
        "training_seconds": round(trained, 1),
        "training_steps": int(agent.num_timesteps),
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
