"""Which detector lets the car drive most safely?  Ranks detectors by `evaluate_policy`.

python examples/rank_detectors.py [--detectors oracle dsgn stereo_rcnn] [--episodes 96]
"""

import argparse
import json

import gymnasium as gym
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import avsec_gym
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.detector_policy import DetectorPolicy


class EmptyDetector:
    """Sees nothing at all: what safety is worth without perception."""

    name = "nothing"

    def detect(self, frame):
        return Boxes3D.empty()


gym.register_envs(avsec_gym)
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--detectors", nargs="*", default=["oracle", "dsgn", "stereo_rcnn"])
unseen = {"source": "mixed", "assets": "judge"}
parser.add_argument("--scenarios", default=unseen, help="a suite or a KITTI folder")
parser.add_argument("--episodes", type=int, default=96)
given, rates = parser.parse_args(), {}
for detector in [*given.detectors, EmptyDetector()]:
    env = Monitor(gym.make("avsec/DetectorBenchmark-v0", scenarios=given.scenarios))
    env.reset(seed=0)  # The same episodes for every detector.
    policy = DetectorPolicy(detector, env)
    rewards, _ = evaluate_policy(policy, env, given.episodes, return_episode_rewards=True)
    rates[policy.detector.name] = sum(reward > 0 for reward in rewards) / given.episodes
print(json.dumps(dict(sorted(rates.items(), key=lambda row: -row[1])), indent=1))
