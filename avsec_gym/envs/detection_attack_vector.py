"""Attackers on detections, many at once: one batch of plans a step."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from avsec_gym.argument_checks import whole_number
from avsec_gym.envs.detection_attack import DetectionGame
from avsec_gym.envs.ghost_round import OUTCOMES, Queried, Round
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.envs.vector_resets import generators_of, mask_of
from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.safety import COLLISION, SAFE

MOST_ENVIRONMENTS = 65_536
"""Each has its own generator of random numbers and its own row of every array."""


class DetectionAttackVectorEnv(
    VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]]
):
    """`DetectionAttackEnv` many times over.

    An episode that has ended begins anew at the next step, whose action is not used (autoreset mode
    NEXT_STEP).  Environment i, seeded with s, plays what a single environment seeded with s + i
    plays.

    Args:
        game: Rules and scenes.
        num_envs: Number of environments, at most `MOST_ENVIRONMENTS`.
        max_episode_steps: Steps after which an episode is cut; -1: the budget alone ends it.
        budget: Queries of an episode, and the price of a query, a ghost, a hidden object.
        render_mode: The mode, which is None.

    Raises:
        ConfigurationError: A number is out of range, the limit cuts episodes before the queries
            that were asked for, or there is a mode.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        game: DetectionGame,
        num_envs: int,
        max_episode_steps: int,
        budget: QueryBudget,
        render_mode: str | None,
    ) -> None:
        if render_mode is not None:
            raise ConfigurationError(
                "many environments at once are not rendered: make a single one"
            )
        num_envs = whole_number("num_envs", num_envs, 1, MOST_ENVIRONMENTS)
        steps = whole_number("max_episode_steps", max_episode_steps, -1)
        limit = None if steps == -1 else whole_number("max_episode_steps", steps, 1)
        budget.check_limit(limit)
        self.longest = math.inf if limit is None else limit
        self.game, self.query_budget = game, budget
        self.num_envs, self.render_mode = num_envs, render_mode
        size = (game.action_size,)
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, size, np.float32)
        self.single_observation_space = gym.spaces.Box(
            -1.0, 1.0, (game.observation_size,), np.float32
        )
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._rounds: list[Round] = []
        self._generators: list[np.random.Generator] = []
        self._spent = np.zeros(num_envs, np.int64)
        self._actions = np.full((num_envs, *size), -1.0)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin all episodes, or those of ``options["reset_mask"]``."""
        options = reset_options(options, "reset_mask")
        mask = mask_of(options.pop("reset_mask", np.ones(self.num_envs, bool)), self.num_envs)
        self._generators = generators_of(seed, self.num_envs, self._generators)
        if not self._rounds:
            mask[:] = True
            self._rounds = [None] * self.num_envs  # type: ignore[list-item]
        self._begin(np.nonzero(mask)[0], options)
        nothing = Queried.nothing(self.num_envs)
        return self._observe(nothing), self._info(nothing)

    def step(  # type: ignore[override]
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """Query every car once; episodes that ended at the last step begin anew instead."""
        if not self._rounds:
            raise gym.error.ResetNeeded("call reset before step")
        actions = np.array(actions, float)
        if actions.shape != self._actions.shape or not np.isfinite(actions).all():
            raise ConfigurationError(
                f"actions have shape {self._actions.shape} and finite values, got {actions.shape}"
            )
        answers = Queried.nothing(self.num_envs)
        begins = self._ended
        self._begin(np.nonzero(begins)[0], {})
        asked = np.nonzero(~begins)[0]
        self._actions[asked] = np.clip(actions[asked], -1.0, 1.0)
        if len(asked):
            queried = self.game.play([self._rounds[i] for i in asked], self._actions[asked])
            for every, of_asked in zip(answers, queried, strict=True):
                every[asked] = of_asked
        self._spent[asked] += 1
        success = (answers.outcome > OUTCOMES.index(SAFE)) & self._safe_before()
        terminated = success | self.query_budget.ends(self._spent)
        # As Gymnasium's time limit: at the last step of an episode that is terminated, too.
        truncated = self._spent >= self.longest
        used = 1 + answers.ghosts + answers.hidden
        rewards = np.where(begins, 0.0, success - self.query_budget.price * used)
        self._ended = terminated | truncated
        return (
            self._observe(answers),
            rewards,
            terminated,
            truncated,
            self._info(answers, success),
        )

    def _safe_before(self) -> NDArray[np.bool_]:
        return np.array([self.game.is_safe(r.index, r.intention) for r in self._rounds])

    def _begin(self, which: NDArray[np.int64], options: dict[str, Any]) -> None:
        if not len(which):
            return
        generators = [self._generators[i] for i in which]
        for i, round in zip(which, self.game.draw_all(generators, options), strict=True):
            self._rounds[i] = round
        self._actions[which] = -1.0
        self._spent[which] = 0
        self._ended = self._ended.copy()
        self._ended[which] = False

    def _observe(self, answers: Queried) -> NDArray[np.float32]:
        left = self.query_budget.left(self._spent)
        return self.game.observe(self._rounds, answers.outcome, answers.cost, left, self._actions)

    def _info(self, answers: Queried, success: NDArray[np.bool_] | bool = False) -> dict[str, Any]:
        outcomes = answers.outcome
        planned = (outcomes == OUTCOMES.index(SAFE)) | (outcomes == OUTCOMES.index(COLLISION))
        words = np.array([*OUTCOMES, "reset"], object)
        values = {
            "planned": planned,
            "success": planned.copy(),
            "collision": outcomes == OUTCOMES.index(COLLISION),
            "safe": outcomes == OUTCOMES.index(SAFE),
            "is_success": np.broadcast_to(success, self.num_envs).copy(),
            "cost": answers.cost.copy(),
            "path_length": answers.path_length,
            "smallest_distance": answers.smallest_distance,
            "cost_sm1": answers.cost_sm1,
            "outcome": words[outcomes],
            "scenario": np.array([r.scene.id for r in self._rounds], object),
            "intention": np.array([str(r.intention) for r in self._rounds], object),
            "queries": self._spent.copy(),
            "ghosts": answers.ghosts,
            "hidden": answers.hidden,
        }
        masks = {f"_{name}": np.ones(self.num_envs, bool) for name in values}
        return {**values, **masks}
