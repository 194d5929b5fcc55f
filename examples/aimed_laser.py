"""Aim a laser at what is in the car's way until a plan is unsafe without an alarm; draw that one.

python examples/aimed_laser.py [--radius 45] [--scenarios mixed_contested] [--out laser.png]
"""

import argparse
from itertools import islice
from pathlib import Path

import cv2
import gymnasium as gym

import avsec_gym
from avsec_gym.envs.aimed_laser import LASER, AimedLaser, full_light
from avsec_gym.envs.contested_situations import contested_situations

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--radius", type=float, default=45.0, help="pixels, from 10 to 180")
parser.add_argument("--attempts", type=int, default=8, help="the most that are made")
parser.add_argument("--scenarios", default="mixed", help="suite or folder")
parser.add_argument("--detector", default="stereo_rcnn")
parser.add_argument("--out", type=Path, default=Path("runs/laser.png"), help="the picture")
given = parser.parse_args()
gym.register_envs(avsec_gym)
car = {"scenarios": given.scenarios, "detector": given.detector, "validator": "thresholds"}
env = AimedLaser(gym.make("avsec/FaculaAttack-v0", **car, **LASER, render_mode="rgb_array"))
light, info = full_light(given.radius), None
for scene, intention in islice(contested_situations(env.unwrapped.game), given.attempts):
    env.reset(options={"scenario": scene.id, "intention": intention.value})
    *_, info = env.step(light)
    alarm = "alarm" if info["alarm"] else "no alarm"
    print(f"{scene.id} {intention.value}: {info['outcome']}, {alarm}")
    if info["is_success"]:
        break
if info is None:
    parser.error(f"in {given.scenarios} nothing that could be hidden is in the way")
given.out.parent.mkdir(parents=True, exist_ok=True)
cv2.imwrite(str(given.out), env.render()[..., ::-1])
print(given.out)
