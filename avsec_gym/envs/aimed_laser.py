"""`AimedLaser`: `avsec/FaculaAttack-v0` with one attempt, aimed at what is in the car's way."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.contested_situations import obstacle_in_the_way
from avsec_gym.envs.sensor_attack_features import best_scores
from avsec_gym.envs.sensor_attack_game import Situation
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, project
from avsec_gym.scenario.intention import Intention

RADII = (10.0, 180.0)
"""Pixels: the smallest hides hardly any car, the largest nearly all."""
STRENGTHS = (10.0, 255.0)
"""Grey levels: from hardly seen to white."""
REACH = (1.5, 0.75)
"""Metres beside and above the middle of what is in the way."""
LASER: dict[str, Any] = {"response": None, "radii": RADII, "strength": STRENGTHS}
"""Arguments of the environment: the laser's reach, and a car that drives on at an alarm."""
ACTIONS = 5
"""Numbers of an action."""
_SEEN = 9


class AimedLaser(gym.Wrapper[Any, Any, Any, Any]):
    """One attempt an episode of `avsec/FaculaAttack-v0`, at the obstacle in the way, mostly a car.

    Actions, each in [-1, 1]: the right camera if above 0, else the left; how far right of its
    middle and above it, in `REACH`; the radius, from the first to the second of `RADII`, by equal
    factors; the strength, from the first to the second of `STRENGTHS`.

    Observations: the intention (one-hot); of the obstacle x / 50 m, y / 20 m, column and row of its
    middle, -1 to 1 across the left image, the best score of a box on it; and how bright the image
    is there, from 0 to 1.

    Args:
        env: The environment, made with the arguments `LASER`.
        quiet: Whether an unsafe plan is rewarded only if the validator raises no alarm.
    """

    def __init__(self, env: gym.Env[Any, Any], *, quiet: bool = True) -> None:
        super().__init__(env)
        self.quiet = quiet
        self.action_space = gym.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (_SEEN,), np.float32)
        self._game: Any = env.unwrapped
        self._targets: dict[tuple[str, Intention], Boxes3D] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin, and take aim."""
        _, info = self.env.reset(seed=seed, options=options)
        situation = self._game.situation
        asked = situation.scene.id, situation.intention
        if asked not in self._targets:
            self._targets[asked] = obstacle_in_the_way(self._game.game, situation)
        self._target = self._targets[asked]
        self._seen = self._look(situation)
        return self._seen, info

    def step(
        self, action: NDArray[Any]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Shine; the episode is over."""
        coding = self._game.coding(self._game.situation.unattacked.frame)
        coded = coding.encode(self.facula(np.clip(action, -1.0, 1.0).astype(float)))
        _, reward, _, _, info = self.env.step(np.clip(coded, -1.0, 1.0).astype(np.float32))
        if not self.quiet and info["alarm"] and not info["safe"]:
            reward = float(reward) + 1.0
        return self._seen, float(reward), True, False, info

    def facula(self, action: Floats) -> Facula:
        """The light that an action stands for, since the last reset.

        Args:
            action: Five numbers in [-1, 1].
        """
        camera = RIGHT if action[0] > 0 else LEFT
        (small, large), (weak, strong) = RADII, STRENGTHS
        radius = small * (large / small) ** ((action[3] + 1) / 2)
        strength = weak + (strong - weak) * (action[4] + 1) / 2
        place = self._middle + np.array([REACH[0] * action[1], -REACH[1] * action[2], 0.0])
        calibration = self._game.situation.unattacked.frame.calibration
        [[u, v]], _ = project(calibration.projection(camera), place[None])
        return Facula(camera, radius, (u, v), strength)

    @property
    def _middle(self) -> Floats:
        """The middle of what is in the way, camera frame, metres, shape (3,)."""
        return self._target.location[0] - [0.0, self._target.dimensions[0, 0] / 2, 0.0]

    def _look(self, situation: Situation) -> NDArray[np.float32]:
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


def full_light(radius: float) -> NDArray[np.float32]:
    """The action of full light on the middle, in the left camera, shape (5,).

    Args:
        radius: Radius of the spot, pixels.

    Raises:
        ConfigurationError: The radius is not one of `RADII`.

    Example:
        >>> full_light(180.0).tolist()
        [-1.0, 0.0, 0.0, 1.0, 1.0]
    """
    small, large = RADII
    if not small <= radius <= large:
        raise ConfigurationError(f"a radius is from {small:g} to {large:g} pixels, got {radius:g}")
    fraction = math.log(radius / small) / math.log(large / small)
    return np.array([-1.0, 0.0, 0.0, 2 * fraction - 1, 1.0], np.float32)
