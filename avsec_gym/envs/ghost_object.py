"""`avsec/GhostObject-v0`: an attacker that puts ghost objects into the detections, anywhere."""

from __future__ import annotations

from typing import Any

from avsec_gym.envs.detection_attack import DetectionAttackEnv
from avsec_gym.envs.ghost_game import OBJECT_LEVEL, GhostGame
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.registry import Kind

QUERIES = 10


@takes_parts(Kind.ATTACK, refused=OBJECT_LEVEL, scenarios="layouts")
class GhostObjectEnv(DetectionAttackEnv):
    """Make the car's safe plan unsafe by changing what the car believes to be around it.

    **Solved by a constant.**  With the default arguments two ghosts side by side 10 m ahead, at
    places that depend on the intention only, make every plan unsafe at the first query, whatever
    the scene (docs/environments.md has the figures).  `avsec/GhostObject-v1` is the game in which
    the scene decides; this one stays for free placement, for hiding objects, and for comparison
    with what was measured on it.

    ## Description
    A car plans a lane change, or to keep its lane, among the objects of a traffic scene, with A*
    over motion primitives.  The attacker controls the detections: it puts ghosts in, and may hide
    real objects.  An episode is one scene with one driving intention that the car drives safely
    without an attack.  Every step is one query: the car plans anew on the attacked detections, and
    its trajectory is checked for collisions with what is really there.  No image is involved.

    ## Observation
    `Box(-1, 1, (269 + 5 ghosts + hides,), float32)`: start speed / 15 m/s; 1 on a highway; the
    intention (left, straight, right; one-hot); the goal's x / 50 m and y / 20 m; number of objects
    / 32; the 32 nearest real objects, each as present, x / 50 m, y / 20 m, cos and sin of the
    heading, length / 10 m, width / 4 m, moving (ego frame, values cut at 1); and of the last query
    the outcome (safe, collision, unplanned; one-hot, zero at first), the planned time / 3 s (0 if
    unplanned), the share of queries left, each ghost as on, x and y as in the action, cos and sin
    of its heading, and each hide's action.

    ## Action
    `Box(-1, 1, (4 ghosts + hides,), float32)`.  For each ghost: above 0 puts it there; x in
    10..30 m ahead; y in -8..8 m (left is positive); heading in -pi..pi; each scaled linearly.  For
    each hide: 33 equal parts, the first hides nothing, part k the k-th nearest object.
    `GhostRange.encode` and `decode` convert ghosts.

    ## Reward
    1 when the safe plan becomes unsafe (collision, or no plan), less 0.02 for the query and 0.02
    for each ghost placed and each object hidden.

    ## Episode end
    Terminated when the plan became unsafe, or with the last query (10, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success`, `queries` (spent), `ghosts` (placed), `hidden`.

    ## Arguments
    * Of the car's parts those that need no sensors, see `avsec_gym.envs.parts.Parts`: `scenarios`,
      `planner`, `motion`, `road`.
    * `scenarios="layouts"`: 200 procedural layouts; `"mixed_contested"`; a folder of labelled
      scenarios or of KITTI labels; or a dictionary such as
      `{"name": "layouts", "seed": 1, "count": 1000}`.
    * `planner="astar"`: or `"gbfs"`, or a dictionary such as `{"name": "astar", "node_limit": 99}`.
    * `ghosts=2`, `hides=0`: how many an action controls.
    * `motion="static"`: the planner takes everything to stand, as detections carry no motion;
      `"truth"`: it knows how the real objects move (then, without hides, no plan can collide).
    * `ghost="patch"`: ghosts of 1 x 1 m, 10 m ahead or more, what a patch of the thesis' size can
      show.  `"car"`: whole cars from 5 m on; one of them right ahead blocks every way.
    * `queries=None`: the budget that the observation counts; None: 10.  A larger one needs a
      larger `max_episode_steps`, too: for 20 queries pass both as 20, or -1 for no limit.
    * `price=0.02`: from 0 to 1.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, safe or not; where the
    plan is unsafe without an attack, no attack succeeds.

    ## Versions
    * v0: first.  v1 offers places that depend on the scene.
    """

    title = "avsec/GhostObject-v0"

    def __init__(
        self,
        *,
        ghosts: int = 2,
        hides: int = 0,
        ghost: str = "patch",
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        game = GhostGame(
            taken.scenarios, taken.planner, ghosts, hides, taken.motion, ghost, taken.road
        )
        super().__init__(game, QueryBudget(queries, price, QUERIES), render_mode)
