"""PPO of stable-baselines3 in any environment of the catalogue, in fifteen lines; prints JSON.

python examples/any_environment.py [avsec/GhostObject-v1] [--steps 2048] [--arguments JSON]
"""

import argparse
import json
import time

import gymnasium as gym
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

import avsec_gym

gym.register_envs(avsec_gym)
IDS = [id for id in gym.registry if id.startswith("avsec/")]
NO_IMAGES = {"avsec/DetectorBenchmark-v0": {"observation": "features"}}


def learned(id: str, steps: int, arguments: dict) -> dict[str, float | str]:
    """Train, and play ten episodes; their mean reward.  Images are rendered on first use."""
    env = make_vec_env(id, seed=0, env_kwargs=NO_IMAGES.get(id, {}) | arguments)
    policy = "MultiInputPolicy" if hasattr(env.observation_space, "spaces") else "MlpPolicy"
    model = PPO(policy, env, n_steps=min(steps, 256), batch_size=min(steps, 64), seed=0)
    model.learn(steps)
    rate = 1e9 * model.num_timesteps / (time.time_ns() - model.start_time)
    reward, _ = evaluate_policy(model, env, n_eval_episodes=10)
    return {"environment": id, "reward": float(reward), "steps_per_second": round(rate, 2)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ids", nargs="*", metavar="ID", default=IDS, help="without: each")
    parser.add_argument("--steps", type=int, default=2048, help="of training")
    parser.add_argument("--arguments", type=json.loads, default={}, help="of the environment")
    given = parser.parse_args()
    for id in given.ids:
        print(json.dumps(learned(id, given.steps, given.arguments)), flush=True)
