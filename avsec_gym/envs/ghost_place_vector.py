"""The vectorised entry point of `avsec/GhostObject-v1`."""

from __future__ import annotations

from typing import Any

from avsec_gym.envs.detection_attack_vector import DetectionAttackVectorEnv
from avsec_gym.envs.ghost_game import OBJECT_LEVEL
from avsec_gym.envs.ghost_place import QUERIES
from avsec_gym.envs.ghost_place_game import GhostPlaceGame
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.registry import Kind


@takes_parts(Kind.ATTACK, refused=OBJECT_LEVEL, scenarios="layouts")
class GhostPlaceVectorEnv(DetectionAttackVectorEnv):
    """`GhostPlaceEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/GhostObject-v1", num_envs=64)`` makes it.
    """

    title = "avsec/GhostObject-v1"

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = -1,
        queries: int | None = None,
        places: int = 16,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        game = GhostPlaceGame(taken.scenarios, taken.planner, places, taken.motion, taken.road)
        budget = QueryBudget(queries, price, QUERIES)
        super().__init__(game, num_envs, max_episode_steps, budget, render_mode)
