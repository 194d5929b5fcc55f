"""The vectorised entry point of `avsec/GhostObject-v0`."""

from __future__ import annotations

from typing import Any

from avsec_gym.envs.detection_attack_vector import DetectionAttackVectorEnv
from avsec_gym.envs.ghost_game import OBJECT_LEVEL, GhostGame
from avsec_gym.envs.ghost_object import QUERIES
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.registry import Kind


@takes_parts(Kind.ATTACK, refused=OBJECT_LEVEL, scenarios="layouts")
class GhostObjectVectorEnv(DetectionAttackVectorEnv):
    """`GhostObjectEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/GhostObject-v0", num_envs=64)`` makes it.
    """

    title = "avsec/GhostObject-v0"

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = -1,
        queries: int | None = None,
        ghosts: int = 2,
        hides: int = 0,
        ghost: str = "patch",
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        game = GhostGame(
            taken.scenarios, taken.planner, ghosts, hides, taken.motion, ghost, taken.road
        )
        budget = QueryBudget(queries, price, QUERIES)
        super().__init__(game, num_envs, max_episode_steps, budget, render_mode)
