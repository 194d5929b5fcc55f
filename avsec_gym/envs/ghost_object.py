"""`avsec/GhostObject-v0`: an attacker that puts ghost objects into the detections."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.object_injection import hide_objects, inject_ghosts
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.ghost_game import FEATURES, NEAREST, OUTCOMES, GhostGame, Round
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.safety import SAFE
from avsec_gym.scenario.scene import Motion

QUERIES = 10


class GhostObjectEnv(DrawnEnv[NDArray[np.float32]]):
    """Make a safe drive unsafe by changing what the car believes to be around it.

    ## Description
    A car plans a lane change, or to keep its lane, among the objects of a traffic scene, with A*
    over motion primitives.  The attacker controls the detections: it puts ghosts in, and may
    hide real objects.  An episode is one scene with one driving intention that the car drives
    safely when nobody attacks.  Every step is one query: the car plans anew on the attacked
    detections, and its trajectory is held against what is really there.  No image is involved.

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
    1 when the safe drive becomes unsafe (collision, or no plan), less 0.02 for the query and 0.02
    for each ghost placed and each object hidden.

    ## Episode end
    Terminated when the drive became unsafe; truncated after `max_episode_steps` (10) or `queries`
    steps, whichever is less.

    ## Info
    `planned`, `collision`, `safe`, `is_success`, `cost` (planned time in s, nan if unplanned),
    `outcome` (`safe`, `collision`, `unplanned`; `reset` at reset), `scenario`, `intention`,
    `queries` (spent), `ghosts` (placed), `hidden`.

    ## Arguments
    * `scenarios="layouts"`: 200 procedural layouts; a folder of labelled scenarios or of KITTI
      labels; or a dictionary such as `{"name": "layouts", "seed": 1, "count": 1000}`.
    * `planner="astar"`: or `"gbfs"`, or a dictionary such as `{"name": "astar", "node_limit": 99}`.
    * `ghosts=2`, `hides=0`: how many an action controls.
    * `motion="static"`: the planner takes everything to stand, as detections carry no motion;
      `"truth"`: it knows how the real objects move (then, without hides, no drive can collide).
    * `ghost="patch"`: ghosts of 1 x 1 m, 10 m ahead or more, what a patch of the thesis' size can
      show; where to put two of them depends on the scene.  `"car"`: whole cars from 5 m on; one
      of them right ahead blocks every drive, whatever the scene: the easy version.
    * `queries=None`: the budget that the observation counts; None: 10.  Gymnasium does not tell an
      environment of its `max_episode_steps`: for a budget of 20 pass both as 20.
    * `price=0.02`
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, safe or not; where the
    drive is unsafe without an attack, there is no success to be had.

    ## Versions
    * v0: first.
    """

    title = "avsec/GhostObject-v0"
    metadata: dict[str, Any] = DrawnEnv.metadata | {"render_fps": 4}

    def __init__(
        self,
        scenarios: Any = "layouts",
        planner: Any = "astar",
        ghosts: int = 2,
        hides: int = 0,
        motion: Motion | str = Motion.STATIC,
        ghost: str = "patch",
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        check_budget(queries, price)
        self.game = GhostGame(scenarios, planner, ghosts, hides, motion, ghost)
        self.queries, self.price = queries, price
        self.action_space = gym.spaces.Box(-1.0, 1.0, (self.game.action_size,), np.float32)
        self.observation_space = gym.spaces.Box(
            -1.0, 1.0, (self.game.observation_size,), np.float32
        )
        self._round: Round | None = None
        self._action = np.full(self.game.action_size, -1.0)
        self._spent = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode; ``options`` may pick a ``scenario`` and an ``intention``."""
        super().reset(seed=seed)
        self._round = self.game.draw(self.np_random, options)
        self._action = np.full(self.game.action_size, -1.0)
        self._spent = 0
        self.shown()
        return self._observe(None, np.nan), self._info(None, np.nan, 0, 0)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Query the car once."""
        if self._round is None:
            raise gym.error.ResetNeeded("call reset before step")
        self._action = checked_action(action, self.game.action_size)
        outcomes, costs, ghosts, hidden = self.game.play([self._round], self._action[None])
        outcome, cost = OUTCOMES[int(outcomes[0])], float(costs[0])
        placed, gone = int(ghosts[0]), int(hidden[0])
        self._spent += 1
        success = outcome != SAFE and self.game.is_safe(self._round.index, self._round.intention)
        reward = float(success) - self.price * (1 + placed + gone)
        self.shown()
        return (
            self._observe(outcome, cost),
            reward,
            success,
            not success and self._ends_itself and self._spent >= self._budget,
            self._info(outcome, cost, placed, gone, success),
        )

    def picture(self) -> NDArray[np.uint8] | None:
        """The scene as it is, as it is believed to be, and the drive that follows."""
        return None if self._round is None else _picture(self.game, self._round, self._action)

    @property
    def _budget(self) -> int:
        return QUERIES if self.queries is None else self.queries

    @property
    def _ends_itself(self) -> bool:
        """False where gym.make's time limit, which an environment is not told of, decides."""
        return self.queries is not None or self.spec is None

    def _observe(self, outcome: str | None, cost: float) -> NDArray[np.float32]:
        assert self._round is not None
        return observe(
            self.game,
            [self._round],
            np.array([-1 if outcome is None else OUTCOMES.index(outcome)]),
            np.array([cost]),
            np.array([1.0 - self._spent / self._budget]),
            self._action[None],
        )[0]

    def _info(
        self, outcome: str | None, cost: float, ghosts: int, hidden: int, success: bool = False
    ) -> dict[str, Any]:
        assert self._round is not None
        return {
            "planned": outcome in ("safe", "collision"),
            "collision": outcome == "collision",
            "safe": outcome == "safe",
            "is_success": success,
            "cost": cost,
            "outcome": outcome or "reset",
            "scenario": self._round.scene.id,
            "intention": str(self._round.intention),
            "queries": self._spent,
            "ghosts": ghosts,
            "hidden": hidden,
        }


def check_budget(queries: int | None, price: float) -> None:
    """Refuse a budget of nothing, and a price that is none.

    Raises:
        ConfigurationError: Fewer than one query, or a price that is not a finite number.
    """
    if not isinstance(price, int | float) or not np.isfinite(price):
        raise ConfigurationError(f"price is a finite number, got {price!r}")
    if queries is not None and queries < 1:
        raise ConfigurationError(f"queries is 1 or more, got {queries}")


def observe(
    game: GhostGame,
    rounds: list[Round],
    outcomes: NDArray[np.int64],
    costs: NDArray[np.float64],
    left: NDArray[np.float64],
    actions: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Observations of B episodes, a new array.

    Args:
        game: The rules.
        rounds: B rounds.
        outcomes: Row of `OUTCOMES`, -1 before the first query, shape (B,).
        costs: Planned time, s, nan if unplanned, shape (B,).
        left: Share of the queries left, shape (B,).
        actions: The last ones, -1 before the first query, shape (B, action_size).

    Returns:
        Shape (B, observation_size), float32.
    """
    scene = 8 + NEAREST * FEATURES
    out = np.zeros((len(rounds), game.observation_size), np.float32)
    out[:, :scene] = [r.features for r in rounds]
    asked = np.nonzero(outcomes >= 0)[0]
    out[asked, scene + outcomes[asked]] = 1.0
    out[:, scene + 3] = np.where(np.isnan(costs), 0.0, np.minimum(costs / 3.0, 1.0))
    out[:, scene + 4] = np.maximum(left, 0.0)
    ghosts = actions[:, : 4 * game.ghosts].reshape(len(rounds), -1, 4)
    last = out[:, scene + 5 : scene + 5 + 5 * game.ghosts].reshape(len(rounds), -1, 5)
    last[..., 0] = ghosts[..., 0] > 0
    last[..., 1:3] = ghosts[..., 1:3]
    last[..., 3], last[..., 4] = np.cos(np.pi * ghosts[..., 3]), np.sin(np.pi * ghosts[..., 3])
    out[:, scene + 5 : scene + 5 + 5 * game.ghosts] = last.reshape(len(rounds), -1)
    out[:, scene + 5 + 5 * game.ghosts :] = actions[:, 4 * game.ghosts :]
    return out


def _picture(game: GhostGame, round: Round, action: NDArray[np.float64]) -> NDArray[np.uint8]:
    from avsec_gym.metrics.safety import judge
    from avsec_gym.pipeline import Drive
    from avsec_gym.report.scenario_picture import draw_drive, picture_array
    from avsec_gym.scenario.builder import is_obstacle

    scene = round.scene
    on, poses = game.range.decode(action[: 4 * game.ghosts].reshape(-1, 4))
    obstacles = np.nonzero(is_obstacle(scene.boxes))[0]
    nearest = obstacles[np.argsort(np.hypot(*scene.boxes.poses[obstacles, :2].T), kind="stable")]
    hidden = game.hidden(action[None, 4 * game.ghosts :])[0]
    gone = nearest[hidden[(hidden >= 0) & (hidden < len(nearest))]]
    believed = inject_ghosts(hide_objects(scene.boxes, gone), poses[on], game.range.dimensions)
    problem = scene.problem(round.intention, believed, game.motion)
    plan, truth = replace(game.victim, keep_tree=True).plan(problem), scene.truth()
    return picture_array(draw_drive(Drive(problem, plan, truth, judge(plan, problem, truth))))
