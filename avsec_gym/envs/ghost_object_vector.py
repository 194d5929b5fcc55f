"""The vectorised entry point of `avsec/GhostObject-v0`."""

from __future__ import annotations

from typing import Any

from avsec_gym.envs.detection_attack_vector import DetectionAttackVectorEnv
from avsec_gym.envs.ghost_game import GhostGame
from avsec_gym.envs.ghost_object import QUERIES
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.scenario.scene import Motion


class GhostObjectVectorEnv(DetectionAttackVectorEnv):
    """`GhostObjectEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/GhostObject-v0", num_envs=64)`` makes it.
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = QUERIES,
        queries: int | None = None,
        scenarios: Any = "layouts",
        planner: Any = "astar",
        ghosts: int = 2,
        hides: int = 0,
        motion: Motion | str = Motion.STATIC,
        ghost: str = "patch",
        price: float = 0.02,
        render_mode: str | None = None,
    ) -> None:
        game = GhostGame(scenarios, planner, ghosts, hides, motion, ghost)
        budget = QueryBudget(queries, price, QUERIES)
        super().__init__(game, num_envs, max_episode_steps, budget, render_mode)
