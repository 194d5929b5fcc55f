"""Train PPO for a minute to attack a car that drives on; print what it wins in other scenes.

python examples/train_closed_loop_attacker.py [--steps 4096] [--held-out 20]
"""

import argparse
import json

import gymnasium as gym
from stable_baselines3 import PPO

import avsec_gym  # noqa: F401 - registers the environments


def made(seed: int) -> gym.Env:
    scenes = {"source": "layouts", "seed": seed, "count": 40}
    return gym.make("avsec/ClosedLoopAttack-v0", scenarios=scenes)


def won(env: gym.Env, act, episodes: int) -> int:
    """Episodes in which a safe drive becomes unsafe by the car's own fault."""
    count = 0
    for seed in range(episodes):
        (seen, info), ended = env.reset(seed=seed), False
        while not ended:
            seen, _, terminated, truncated, info = env.step(act(seen))
            ended = terminated or truncated
        count += info["is_success"]
    return count


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--steps", type=int, default=4096, help="of training, 0.1 s of a drive each")
parser.add_argument("--held-out", type=int, default=20, help="episodes that are judged")
given = parser.parse_args()
agent = PPO("MlpPolicy", made(0), n_steps=min(1024, given.steps), seed=0).learn(given.steps)
judged, rules = made(7), {"ppo": lambda seen: agent.predict(seen, deterministic=True)[0]}
judged.action_space.seed(0)
rules["random"] = lambda _: judged.action_space.sample()
print(json.dumps({name: won(judged, act, given.held_out) for name, act in rules.items()}))
