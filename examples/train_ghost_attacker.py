"""Train PPO to place a ghost object, and hold it against rules in scenes that it has not seen.

python examples/train_ghost_attacker.py [--steps 80000] [--held-out 1000] [--seed 0]
"""

import argparse
import json

import gymnasium as gym
import numpy as np
from stable_baselines3 import PPO

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym.agents.place_policy import PlacePolicy, places_in
from avsec_gym.envs.place_features import PlaceFeatures
from avsec_gym.envs.sb3 import StableBaselinesVecEnv
from avsec_gym.metrics.clustered_shares import share_of

ID, LAYOUTS = "avsec/GhostObject-v1", {"name": "layouts", "count": 400}
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
for name, default in {"steps": 80_000, "held-out": 1000, "seed": 0}.items():
    parser.add_argument(f"--{name}", type=int, default=default)
given = parser.parse_args()
env = StableBaselinesVecEnv(gym.make_vec(ID, num_envs=256, scenarios=LAYOUTS))
how = {"n_steps": 8, "batch_size": 512, "n_epochs": 4, "learning_rate": 2e-3, "clip_range": 0.3}
how |= {"gamma": 0.0, "policy_kwargs": {"log_std_init": -0.7}}  # An episode is one step.
ppo = PPO(PlacePolicy, env, **how, seed=given.seed, device="cpu").learn(given.steps)
judged = gym.make_vec(ID, num_envs=given.held_out, scenarios=LAYOUTS | {"seed": 7})
judged.action_space.seed(given.seed)
rules = {  # An action has a number for each of sixteen places: the ghost comes to the highest.
    "random": lambda seen: judged.action_space.sample(),
    "first": lambda seen: np.eye(16)[[0] * len(seen)],
    "nearest": lambda seen: -np.hypot(*PlaceFeatures.decode(places_in(seen)).positions.T).T / 100,
    "ppo": lambda seen: ppo.predict(seen, deterministic=True)[0],
}
for name, act in rules.items():
    seen, drawn = judged.reset(seed=given.seed)
    *_, info = judged.step(act(seen))
    won = share_of(info["is_success"], drawn["scenario"].tolist())
    print(json.dumps({name: {"success_rate": won.rate, "interval": won.interval}}))
