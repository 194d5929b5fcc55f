"""`avsec/GhostObject-v1`: an attacker on detections that reaches only a few places."""

from __future__ import annotations

from typing import Any

from avsec_gym.envs.detection_attack import DetectionAttackEnv
from avsec_gym.envs.ghost_game import OBJECT_LEVEL
from avsec_gym.envs.ghost_place_game import GhostPlaceGame
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.registry import Kind

QUERIES = 1


@takes_parts(Kind.ATTACK, refused=OBJECT_LEVEL, scenarios="layouts")
class GhostPlaceEnv(DetectionAttackEnv):
    """Find the one place where a ghost makes the car's plan unsafe.

    ## Description
    A car plans a lane change, or to keep its lane, among the objects of a traffic scene, with A*
    over motion primitives.  A spoofer can put one ghost, a whole car, into the detections, but its
    equipment reaches only sixteen places.  On an empty road the car would pass a ghost on any of
    them: a ghost wins only together with what is really there, by closing the last gap.  At one
    place it does, at the others it does not.  An episode is one scene with one driving intention
    that the car drives safely without an attack, and the places; by default the attacker has one
    go.  The trajectory that the car plans on the attacked detections is checked for collisions with
    what is really there.  No image is involved.

    Places are spots of a grid of 1 m that can close a gap in some scene.  Spots that close many
    gaps are offered more often where they close none (`avsec_gym.envs.ghost_spots`), and their
    order is shuffled, so that neither a fixed action nor the nearest place wins often:
    ``benchmarks/ghost_places.py`` measures that, and docs/environments.md has the figures.

    ## Observation
    `Box(-1, 1, (269 + 7 places,), float32)`: start speed / 15 m/s; 1 on a highway; the intention
    (left, straight, right; one-hot); the goal's x / 50 m and y / 20 m; number of objects / 32; the
    32 nearest real objects, each as present, x / 50 m, y / 20 m, cos and sin of the heading, length
    / 10 m, width / 4 m, moving (ego frame, values cut at 1); of the last query the outcome (safe,
    collision, unplanned; one-hot, zero at first), the planned time / 3 s (0 if unplanned) and the
    share of queries left; each place as x / 20 m, y / 8 m, and the room from it to the nearest real
    object to the left, to the right, ahead and behind, each / 6 m, 1 for more (`PlaceFeatures`
    encodes and decodes them); and the place of the last query (one-hot).

    ## Action
    `Box(-1, 1, (places,), float32)`: a number for each place.  The ghost goes to the place with the
    highest, the first of equals.

    ## Reward
    1 when the safe plan becomes unsafe (no plan, or a collision), less 0.02 for the query and 0.02
    for the ghost.

    ## Episode end
    Terminated when the plan became unsafe, or with the last query (1, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.  Who may ask sixteen times can try all of
    them: success is compared at the first query.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success`, `queries` (spent), `ghosts` (1), `hidden` (0).

    ## Arguments
    * Of the car's parts those that need no sensors, see `avsec_gym.envs.parts.Parts`: `scenarios`,
      `planner`, `motion`, `road`.
    * `scenarios="layouts"`: 200 procedural layouts; `"mixed_contested"`; a folder of labelled
      scenarios or of KITTI labels; or a dictionary such as
      `{"name": "layouts", "seed": 1, "count": 1000}`.
    * `planner="astar"`: or `"gbfs"`, or a dictionary such as `{"name": "astar", "node_limit": 99}`.
    * `places=16`: from 2 to 16.
    * `road="thesis"`: straight lanes; `"own"`: the roads that the layouts lie on.  Played are those
      on which an empty road leaves room for a ghost on as many spots as there are places, which
      with 16 are highways; the spots' biases were found on the thesis' lanes.
    * `motion="static"`: the planner takes everything to stand, as detections carry no motion;
      `"truth"`: it knows how the real objects move.
    * `queries=None`: the budget that the observation counts; None: 1.  A larger one needs a
      larger `max_episode_steps`, too: for 3 queries pass both as 3, or -1 for no limit.
    * `price=0.02`: from 0 to 1.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, whether or not a place
    wins there.  The car's answers to all spots of a scene are planned when the scene is first
    drawn, and remembered: the first episodes of a set are slower.

    ## Versions
    * v1: places drawn for each scene.  v0, which stays, is solved by a constant.
    """

    title = "avsec/GhostObject-v1"

    def __init__(
        self,
        *,
        places: int = 16,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        game = GhostPlaceGame(taken.scenarios, taken.planner, places, taken.motion, taken.road)
        super().__init__(game, QueryBudget(queries, price, QUERIES), render_mode)
