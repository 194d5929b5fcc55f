"""What attackers on sensors have in common: episodes, queries, observations and rewards."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of
from avsec_gym.attacks.attack import LEFT
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.attacked_sensors import CAMERAS, check_read
from avsec_gym.envs.info import episode_info
from avsec_gym.envs.observations import BOTH, FEATURES, IMAGES, THUMBNAIL, thumbnail
from avsec_gym.envs.parts import parts_of
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.sensor_attack_features import SIZE, best_scores, features, ghosts_among
from avsec_gym.envs.sensor_attack_game import QueryOutcome, SensorAttackGame, Situation
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.frame_scenes import check_frame_scenes

OBSERVATIONS = (FEATURES, IMAGES, BOTH)
PLAYED = {"attack": "the agent plays it"}
RENAMED = {
    "image": 'observation="both" shows the features and a small image, observation="images" the '
    "image alone",
    "contested": 'such scenes are named by scenarios={"source": "mixed", "contested": True}',
}
"""Former arguments of attackers."""

Observation = NDArray[np.float32] | dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Tampering:
    """What an action does to a frame."""

    frame: SensorFrame
    used: float
    """Share of the budget that was used, in [0, 1]; the reward is less by its price."""
    facts: dict[str, float]
    """What `info` has of it."""
    action: Floats
    """What was done, as an action; part of the next observation."""


class SensorAttackEnv(DrawnEnv[Observation]):
    """Episodes of an attacker on sensors; `tamper` turns an action into an attacked frame.

    Scenes and detector are loaded at the first reset, so that making an environment is cheap.

    Args:
        action_size: Numbers of an action, each in [-1, 1].
        parts: The scenes and the parts of the victim, as the user gave them.
        budget: Queries of an episode, and the price of a query and of the whole budget of change.
        observation: What the attacker sees, one of `OBSERVATIONS`.
        render_mode: None, ``rgb_array`` or ``human``.

    Raises:
        ConfigurationError: An unknown mode or observation, an attack on what nothing in the car
            reads, or see `parts_of`.
    """

    attacked = CAMERAS
    """The sensors that are attacked: something in the car has to read them."""
    known_size = SIZE
    """Size of what the attacker sees beside its last action."""

    def __init__(
        self,
        action_size: int,
        parts: Mapping[str, Any],
        budget: QueryBudget,
        *,
        observation: str = FEATURES,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        self.parts, self.query_budget = parts_of(self, parts), budget
        check_read(self.parts, parts.get("detector", self.parts.detector), self.attacked)
        check_frame_scenes(self.parts.scenarios, self.parts.road)
        self.observation = one_of("observation", observation, OBSERVATIONS)
        self.action_space = gym.spaces.Box(-1.0, 1.0, (action_size,), np.float32)
        vector = gym.spaces.Box(-1.0, 1.0, (self.known_size + action_size,), np.float32)
        pixels = gym.spaces.Box(0, 255, (*THUMBNAIL, 3), np.uint8)
        spaces: dict[str, gym.Space[Any]] = {FEATURES: vector, IMAGES: pixels}
        both: gym.Space[Any] = gym.spaces.Dict(spaces)
        self.observation_space: gym.Space[Any] = spaces.get(self.observation, both)
        self._situation: Situation | None = None
        self._last: QueryOutcome | None = None
        self._done = np.zeros(action_size)
        self._spent = 0

    @abstractmethod
    def tamper(self, situation: Situation, action: Floats) -> Tampering:
        """The frame that the car sees, and what of the budget it took.

        Args:
            situation: The situation that is attacked.
            action: The attacker's action, in [-1, 1], shape (action_size,).
        """

    @property
    @abstractmethod
    def untouched(self) -> dict[str, float]:
        """The facts before the first query."""

    def known(self) -> Floats:
        """What the attacker sees beside its last action, shape (known_size,), in [-1, 1]."""
        return features(self.situation, self._last, self.query_budget.left(self._spent))

    @cached_property
    def game(self) -> SensorAttackGame:
        """Scenes and victim.

        Raises:
            ConfigurationError: There is no such set or part.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        return SensorAttackGame(self.parts)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; ``options`` may pick a ``scenario`` and an ``intention``."""
        super().reset(seed=seed)
        self._situation = self.game.draw(self.np_random, options)
        self._last, self._spent = None, 0
        self._done = np.zeros_like(self._done)
        self.shown()
        return self._observe(), self._info(self.untouched, success=False)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Query the car once."""
        # The attacker tampers with the frame; the car sees it, plans and drives.
        situation = self.situation
        tampering = self.tamper(situation, checked_action(action, len(self._done)))
        self._done = np.clip(tampering.action, -1.0, 1.0)
        self._last = self.game.query(situation, tampering.frame)
        self._spent += 1
        # An attack counts where a safe episode becomes unsafe, in spite of the validator.
        success = situation.unattacked.episode.record.safe and self.game.harms(self._last)
        self.shown()
        return (
            self._observe(),
            float(success) - self.query_budget.price * (1.0 + tampering.used),
            success or self.query_budget.ends(self._spent),
            False,
            self._info(tampering.facts, success),
        )

    def picture(self) -> NDArray[np.uint8] | None:
        """What the car saw, with what it believed, above its episode."""
        if self._situation is None:
            return None
        from avsec_gym.drawing.detection_picture import detection_picture

        frame, camera = self.view()
        look = self._look
        return detection_picture(frame, look.perception.believed, look.episode, camera=camera)

    def view(self) -> tuple[SensorFrame, int]:
        """A frame, and the camera whose image shows the attack best."""
        return self._look.frame, LEFT

    @property
    def situation(self) -> Situation:
        """What is attacked.

        Raises:
            ResetNeeded: There is none yet.
        """
        if self._situation is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._situation

    @property
    def _look(self) -> QueryOutcome:
        """The last query, or what there was before the first."""
        return self._last or self.situation.unattacked

    def _observe(self) -> Observation:
        seen: dict[str, NDArray[Any]] = {}
        if self.observation != IMAGES:
            seen[FEATURES] = np.concatenate([self.known(), self._done]).astype(np.float32)
        if self.observation != FEATURES:
            seen[IMAGES] = thumbnail(self.situation.unattacked.frame.image(LEFT))
        return seen if self.observation == BOTH else seen[self.observation]

    def _info(self, facts: dict[str, float], success: bool) -> dict[str, Any]:
        scene, believed = self.situation.scene, self._look.perception.believed
        obstacles = scene.boxes[is_obstacle(scene.boxes)]
        episode = None if self._last is None else self._last.episode
        return {
            **episode_info(episode, scene.id, self.situation.intention),
            "is_success": success,
            "queries": self._spent,
            "objects": len(obstacles),
            "found": int((best_scores(obstacles, believed) > 0).sum()),
            "ghosts": len(ghosts_among(obstacles, believed)),
            "alarm": self._look.report.alarm,
            **facts,
        }
