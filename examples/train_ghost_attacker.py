"""Train a ghost-object attacker with PPO and compare it with random search on held-out layouts.

python examples/train_ghost_attacker.py                    # about a minute on two cores
python examples/train_ghost_attacker.py --steps 4096 --held-out 50
"""

from __future__ import annotations

import argparse
import json
import time

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

import avsec_gym
from avsec_gym.envs.sb3 import StableBaselinesVecEnv

TRAINING = {"name": "layouts", "seed": 0, "count": 400}
HELD_OUT = {"name": "layouts", "seed": 1, "count": 200}


def train(steps: int, seed: int) -> PPO:
    """PPO on the batched environment."""
    torch.set_num_threads(1)
    environment = VecMonitor(
        StableBaselinesVecEnv(
            gym.make_vec("avsec/GhostObject-v0", num_envs=64, scenarios=TRAINING, ghosts=1)
        )
    )
    agent = PPO(
        "MlpPolicy",
        environment,
        n_steps=32,
        batch_size=512,
        n_epochs=6,
        learning_rate=1e-3,
        gamma=0.9,
        ent_coef=1e-3,
        policy_kwargs={"net_arch": [128, 128], "log_std_init": -0.5},
        seed=seed,
        device="cpu",
    )
    return agent.learn(steps)


def evaluate(policy: PPO | None, episodes: int, seed: int) -> dict[str, float]:
    """Success, queries and reward on held-out layouts; without a policy, random actions."""
    env = gym.make("avsec/GhostObject-v0", scenarios=HELD_OUT, ghosts=1)
    env.action_space.seed(seed)
    successes, queries, rewards = [], [], []
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        total, over = 0.0, False
        while not over:
            if policy is None:
                action = env.action_space.sample()
            else:
                action, _ = policy.predict(observation)
            observation, reward, terminated, truncated, info = env.step(action)
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
    parser.add_argument("--steps", type=int, default=150_000, help="training steps")
    parser.add_argument("--held-out", type=int, default=200, help="episodes to judge by")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    gym.register_envs(avsec_gym)
    begun = time.perf_counter()
    agent = train(arguments.steps, arguments.seed)
    trained = time.perf_counter() - begun
    print(
        json.dumps(
            {
                "random": evaluate(None, arguments.held_out, arguments.seed),
                "ppo": evaluate(agent, arguments.held_out, arguments.seed),
                "training_seconds": round(trained, 1),
                "training_steps": int(agent.num_timesteps),
            },
            indent=1,
        )
    )


if __name__ == "__main__":
    main()
