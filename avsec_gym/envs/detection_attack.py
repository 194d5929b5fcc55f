"""The environment of an attacker on detections, whatever the game: reset, step, info, picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.ghost_round import OUTCOMES, Queried, Round
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.geometry import Floats
from avsec_gym.metrics.safety import COLLISION, SAFE
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion

_NOTHING = Queried.nothing(1)
_WORDS = (*OUTCOMES, "reset")
"""-1 stands for the last."""


class DetectionGame(Protocol):
    """Rules and scenes: `GhostGame` and `GhostPlaceGame`."""

    @property
    def action_size(self) -> int:
        """Numbers of an action."""

    @property
    def observation_size(self) -> int:
        """Numbers of an observation."""

    @property
    def victim(self) -> MotionPrimitivePlanner:
        """Who plans."""

    @property
    def motion(self) -> Motion:
        """What the planner knows of motion."""

    def draw_all(
        self, generators: Sequence[np.random.Generator], options: dict[str, Any] | None
    ) -> list[Round]:
        """A round by each generator."""

    def is_safe(self, index: int, intention: Intention) -> bool:
        """Whether a round is driven safely without an attack."""

    def play(self, rounds: Sequence[Round], actions: Floats) -> Queried:
        """One query in each round."""

    def observe(
        self,
        rounds: Sequence[Round],
        outcomes: NDArray[np.int64],
        costs: Floats,
        left: Floats,
        actions: Floats,
    ) -> NDArray[np.float32]:
        """Observations, shape (B, observation_size)."""

    def believed(self, round: Round, action: Floats) -> Boxes3D:
        """The detections that the car plans on after an action."""


class DetectionAttackEnv(DrawnEnv[NDArray[np.float32]]):
    """One episode at a time.

    Args:
        game: Rules and scenes.
        budget: Queries of an episode, and the price of a query, a ghost, a hidden object.
        render_mode: None, ``rgb_array`` or ``human``.

    Raises:
        ConfigurationError: An unknown mode.
    """

    metadata: dict[str, Any] = DrawnEnv.metadata | {"render_fps": 4}

    def __init__(self, game: DetectionGame, budget: QueryBudget, render_mode: str | None) -> None:
        super().__init__(render_mode)
        self.game, self.query_budget = game, budget
        self.action_space = gym.spaces.Box(-1.0, 1.0, (game.action_size,), np.float32)
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (game.observation_size,), np.float32)
        self._round: Round | None = None
        self._action = np.full(game.action_size, -1.0)
        self._spent = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode; ``options`` may pick a ``scenario`` and an ``intention``."""
        super().reset(seed=seed)
        (self._round,) = self.game.draw_all([self.np_random], options)
        self._action = np.full(self.game.action_size, -1.0)
        self._spent = 0
        self.shown()
        return self._observe(_NOTHING), self._info(_NOTHING)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Query the car once."""
        if self._round is None:
            raise gym.error.ResetNeeded("call reset before step")
        self._action = checked_action(action, self.game.action_size)
        answer = self.game.play([self._round], self._action[None])
        outcome = OUTCOMES[int(answer.outcome[0])]
        self._spent += 1
        success = outcome != SAFE and self.game.is_safe(self._round.index, self._round.intention)
        reward = float(success) - self.query_budget.price * (
            1 + int(answer.ghosts[0] + answer.hidden[0])
        )
        self.shown()
        return (
            self._observe(answer),
            reward,
            success or self.query_budget.ends(self._spent),
            False,
            self._info(answer, success),
        )

    def picture(self) -> NDArray[np.uint8] | None:
        """The scene as it is, as it is believed to be, and the plan that follows."""
        if self._round is None:
            return None
        believed = self._round.scene.boxes
        if self._spent:
            believed = self.game.believed(self._round, self._action)
        return _picture(self.game, self._round, believed)

    def _observe(self, answer: Queried) -> NDArray[np.float32]:
        assert self._round is not None
        return self.game.observe(
            [self._round],
            answer.outcome,
            answer.cost,
            np.array([self.query_budget.left(self._spent)]),
            self._action[None],
        )[0]

    def _info(self, answer: Queried, success: bool = False) -> dict[str, Any]:
        assert self._round is not None
        outcome = _WORDS[int(answer.outcome[0])]
        planned = outcome in (SAFE, COLLISION)
        return {
            "planned": planned,
            "success": planned,
            "collision": outcome == COLLISION,
            "safe": outcome == SAFE,
            "is_success": success,
            "cost": float(answer.cost[0]),
            "path_length": float(answer.path_length[0]),
            "smallest_distance": float(answer.smallest_distance[0]),
            "cost_sm1": float(answer.cost_sm1[0]),
            "outcome": outcome,
            "scenario": self._round.scene.id,
            "intention": str(self._round.intention),
            "queries": self._spent,
            "ghosts": int(answer.ghosts[0]),
            "hidden": int(answer.hidden[0]),
        }


def _picture(game: DetectionGame, round: Round, believed: Boxes3D) -> NDArray[np.uint8]:
    from avsec_gym.drawing.scenario_picture import draw_episode, picture_array
    from avsec_gym.metrics.safety import judge
    from avsec_gym.pipeline import Episode

    problem = round.scene.problem(round.intention, believed, game.motion)
    plan, truth = replace(game.victim, keep_tree=True).plan(problem), round.scene.truth()
    return picture_array(draw_episode(Episode(problem, plan, truth, judge(plan, problem, truth))))
