"""A laser that is aimed at what is in the car's way: the attempts of `train_quiet_laser.py`.

    python examples/aimed_laser.py
    python examples/aimed_laser.py --radius 90 --out laser.png

aims by hand, once in each of some situations, and draws the first attempt that makes a plan unsafe
without an alarm of the validator; if there is none, the last.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from itertools import islice, product
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from shapely.geometry import LineString, Point

import avsec_gym
from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.sensor_attack_features import best_scores
from avsec_gym.envs.sensor_attack_game import SensorAttackGame, Situation
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.geometry import Floats, project
from avsec_gym.pipeline import Perception
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene

RADII = (10.0, 180.0)
"""Pixels: the smallest hides hardly any car, the largest nearly all."""
STRENGTHS = (10.0, 255.0)
"""Grey levels: from hardly seen to white."""
REACH = (1.5, 0.75)
"""Metres beside and above the middle of what is in the way."""
ACTIONS, SEEN = 5, 9


class AimedLaser(gym.Wrapper):
    """One attempt an episode of `avsec/FaculaAttack-v0`, at the obstacle in the way, mostly a car.

    Actions, each in [-1, 1]: the right camera if above 0, else the left; how far right of its
    middle and above it, in `REACH`; the radius, from the first to the second of `RADII`, by equal
    factors; the strength, from the first to the second of `STRENGTHS`.

    Observations: the intention (one-hot); of the obstacle x / 50 m, y / 20 m, column and row of its
    middle, -1 to 1 across the left image, the best score of a box on it; and how bright the image
    is there, from 0 to 1.
    """

    quiet = True
    """False: an unsafe plan is rewarded whether or not the validator raises an alarm."""

    def __init__(self, env: gym.Env) -> None:
        super().__init__(env)
        self.action_space = gym.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (SEEN,), np.float32)
        self._targets: dict[tuple[str, Intention], Boxes3D] = {}

    def reset(self, **options: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin, and take aim."""
        _, info = self.env.reset(**options)
        situation = self.env.unwrapped.situation
        asked = situation.scene.id, situation.intention
        if asked not in self._targets:
            self._targets[asked] = in_the_way(self.env.unwrapped.game, situation)
        self._target = self._targets[asked]
        self._seen = self._look(situation)
        return self._seen, info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Shine."""
        frame = self.env.unwrapped.situation.unattacked.frame
        coding = self.env.unwrapped.coding(frame)
        coded = coding.encode(self.facula(np.clip(action, -1.0, 1.0).astype(float)))
        _, reward, _, _, info = self.env.step(np.clip(coded, -1.0, 1.0).astype(np.float32))
        if not self.quiet and info["alarm"] and not info["safe"]:
            reward = float(reward) + 1.0
        return self._seen, float(reward), True, False, info

    def facula(self, action: Floats) -> Facula:
        """What an action stands for here."""
        camera = RIGHT if action[0] > 0 else LEFT
        (small, large), (weak, strong) = RADII, STRENGTHS
        radius = small * (large / small) ** ((action[3] + 1) / 2)
        strength = weak + (strong - weak) * (action[4] + 1) / 2
        place = self._middle + np.array([REACH[0] * action[1], -REACH[1] * action[2], 0.0])
        calibration = self.env.unwrapped.situation.unattacked.frame.calibration
        [[u, v]], _ = project(calibration.projection(camera), place[None])
        return Facula(camera, radius, (u, v), strength)

    @property
    def _middle(self) -> Floats:
        """Of what is in the way, in camera coordinates, metres."""
        return self._target.location[0] - [0.0, self._target.dimensions[0, 0] / 2, 0.0]

    def _look(self, situation: Situation) -> np.ndarray:
        frame, target = situation.unattacked.frame, self._target
        image = frame.image(LEFT)
        size = np.array(image.shape[1::-1])
        pixels, _ = project(frame.calibration.projection(LEFT), self._middle[None])
        column, row = np.clip(np.rint(pixels[0]).astype(int), 0, size - 1)
        x, y, _ = target.poses[0]
        seen = [float(situation.intention == each) for each in Intention]
        seen += [x / 50, y / 20, *(2.0 * pixels[0] / (size - 1) - 1.0)]
        seen += [*best_scores(target, situation.unattacked.perception.detections)]
        seen += [image[max(row - 5, 0) : row + 6, max(column - 5, 0) : column + 6].mean() / 255]
        return np.clip(seen, -1.0, 1.0).astype(np.float32)


def in_the_way(game: SensorAttackGame, situation: Situation) -> Boxes3D:
    """The obstacle without which the car would drive into it; of several, or where it takes more
    than one, that nearest to the straight line from the car to the middle of its goal.
    """
    boxes, scene = situation.scene.boxes, situation.scene
    ahead = np.flatnonzero(is_obstacle(boxes) & (boxes.poses[:, 0] > 1))
    goal = situation.unattacked.episode.problem.goals[0].region[0]
    line = LineString([(0.0, 0.0), (goal.x, goal.y)])
    nearest = sorted(ahead, key=lambda one: line.distance(Point(boxes.poses[one, :2])))
    for car in nearest:
        others = boxes[np.arange(len(boxes)) != car]
        believed = Perception(others, others, None)
        if not game.pipeline.run_episode(scene, believed, situation.intention).record.safe:
            return boxes[[car]]
    return boxes[nearest[:1]]


def worth_attacking(game: SensorAttackGame) -> Iterator[tuple[Scene, Intention]]:
    """Situations with something in the way, safe and without an alarm while there is no attack."""
    for scene, intention in product(game.scenes.scenes.labelled, Intention):
        if is_contested(scene, intention):
            look = game.situation(scene, intention).unattacked
            if look.episode.record.safe and not look.report.alarm:
                yield scene, intention


def by_hand(radius: float) -> np.ndarray:
    """The action of full light on the middle, in the left camera."""
    small, large = RADII
    fraction = math.log(radius / small) / math.log(large / small)
    return np.array([-1.0, 0.0, 0.0, 2 * fraction - 1, 1.0], np.float32)


def main() -> None:
    """Shine, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radius", type=float, default=45.0, help="pixels, from 10 to 180")
    parser.add_argument("--attempts", type=int, default=8, help="how many are made at most")
    parser.add_argument("--scenarios", default="mixed", help="suite or folder")
    parser.add_argument("--detector", default="stereo_rcnn")
    parser.add_argument("--out", type=Path, default=Path("runs/laser.png"), help="the picture")
    options = parser.parse_args()
    if not RADII[0] <= options.radius <= RADII[1] or options.attempts < 1:
        parser.error(f"--radius is from {RADII[0]:g} to {RADII[1]:g}, --attempts 1 or more")
    gym.register_envs(avsec_gym)
    made = gym.make(
        "avsec/FaculaAttack-v0",
        scenarios=options.scenarios,
        detector=options.detector,
        validator="thresholds",
        response=None,  # The car drives on at an alarm.
        radii=RADII,
        strength=STRENGTHS,
        render_mode="rgb_array",
    )
    env, game = AimedLaser(made), made.unwrapped.game
    for scene, intention in islice(worth_attacking(game), options.attempts):
        env.reset(options={"scenario": scene.id, "intention": intention.value})
        *_, info = env.step(by_hand(options.radius))
        alarm = "alarm" if info["alarm"] else "no alarm"
        print(f"{scene.id} {intention.value}: {info['outcome']}, {alarm}")
        if info["is_success"]:
            break
    picture = env.render()
    if picture is None:
        parser.error(f"in {options.scenarios} nothing that could be hidden is in the way")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(options.out), picture[..., ::-1])
    print(options.out)


if __name__ == "__main__":
    main()
