"""A planner drives on by what its car believes: the truth, nothing, a detector's errors.

python examples/drive_on.py [--models dsgn dsgn_thesis_pgd] [--episodes 20]
"""

import argparse
import json

import gymnasium as gym

import avsec_gym
from avsec_gym.envs.planner_driver import PlannerDriver


def ends(perception, episodes):
    """What `info` reports at the end of each drive."""
    env = gym.make("avsec/ClosedLoop-v0", scenarios="mixed_contested", perception=perception)
    driver = PlannerDriver(env)
    for seed in range(episodes):
        observation, _ = env.reset(seed=seed)
        over = False
        while not over:
            action, _ = driver.predict(observation)
            observation, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        yield info


gym.register_envs(avsec_gym)
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--models", nargs="*", default=["dsgn", "dsgn_thesis_pgd"])
parser.add_argument("--episodes", type=int, default=20)
given = parser.parse_args()
cars = {"truth": "truth", "blind": "blind"}
cars |= {name: {"name": "error_model", "model": name} for name in given.models}
for name, perception in cars.items():
    drives = list(ends(perception, given.episodes))
    rates = {what: sum(bool(each[what]) for each in drives) for what in ("safe", "at_fault")}
    print(json.dumps({"car": name, "drives": len(drives), **rates}))
