"""Train PPO in highway-env's own `highway-v0` and let it drive in our scenes, unchanged.

python examples/highway_agent.py [--steps 1024] [--drives 50]
"""

import argparse
import json
from collections import Counter

import gymnasium as gym
import highway_env
from stable_baselines3 import PPO

import avsec_gym

SAME = ("observation", "action", "policy_frequency", "simulation_frequency")
SCENES = {"source": "layouts", "seed": 7, "count": 50}

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--steps", type=int, default=1024, help="of training, a second each")
parser.add_argument("--drives", type=int, default=50, help="to judge by")
given = parser.parse_args()
for package in (highway_env, avsec_gym):
    gym.register_envs(package)
theirs = gym.make("highway-v0", config={"vehicles_count": 15})
agent = PPO("MlpPolicy", theirs, n_steps=min(given.steps, 256), seed=0).learn(given.steps)

config = {name: theirs.unwrapped.config[name] for name in SAME}
ours = gym.make("avsec/ClosedLoop-v0", config=config, scenarios=SCENES)
result = {}
for name, act in {"ppo": lambda seen: int(agent.predict(seen)[0]), "idle": lambda _: 1}.items():
    outcomes = Counter()
    for seed in range(given.drives):
        (seen, info), ended = ours.reset(seed=seed), False
        while not ended:
            seen, _, terminated, truncated, info = ours.step(act(seen))
            ended = terminated or truncated
        outcomes[info["outcome"]] += 1
    result[name] = dict(sorted(outcomes.items()))
print(json.dumps(result))
