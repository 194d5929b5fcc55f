"""Train SAC to perturb a detector's images, and hold it against chance on scenes it has not seen.

python examples/train_perturbation_attacker.py [--id avsec/PatchAttack-v0] [--detector stereo_rcnn]
"""

import argparse
import json

import gymnasium as gym
from stable_baselines3 import SAC

import avsec_gym  # noqa: F401 - registers the environments


def won(env: gym.Env, act, episodes: int) -> int:
    count = 0  # Episodes in which a safe plan becomes unsafe.
    for seed in range(episodes):
        (seen, info), ended = env.reset(seed=seed), False
        while not ended:
            seen, _, terminated, truncated, info = env.step(act(seen))
            ended = terminated or truncated
        count += info["is_success"]
    return count


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--id", default="avsec/PerturbationAttack-v0", help="or avsec/PatchAttack-v0")
parser.add_argument("--detector", default="dsgn")
for name, split in {"training": "train", "testing": "val"}.items():
    default = {"source": "mixed", "split": split}
    parser.add_argument(f"--{name}", type=json.loads, default=default, help="scenes, as JSON")
parser.add_argument("--steps", type=int, default=1000, help="of training, half a second each")
parser.add_argument("--held-out", type=int, default=30, help="episodes that are judged")
given = parser.parse_args()
env = gym.make(given.id, detector=given.detector, scenarios=given.training)
agent = SAC("MlpPolicy", env, gamma=0.5, gradient_steps=4, seed=0).learn(given.steps)
env = gym.make(given.id, detector=given.detector, scenarios=given.testing)
env.action_space.seed(0)
print(json.dumps({"random": won(env, lambda _: env.action_space.sample(), given.held_out)}))
print(json.dumps({"sac": won(env, lambda seen: agent.predict(seen)[0], given.held_out)}))
