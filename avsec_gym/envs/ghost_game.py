"""The game behind `avsec/GhostObject-v0`, for any number of episodes side by side.

An episode is one scene with one intention that is driven safely without an attack.  Each query
changes the detections, plans on them and checks the trajectory for collisions with what is real.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.attacks.object_injection import GHOSTS, hide_objects, inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.ghost_round import (
    NEAREST,
    OUTCOMES,
    SCENE_SIZE,
    Queried,
    Round,
    observation,
    round_of,
)
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.batch_measures import batch_measures
from avsec_gym.metrics.collision_check import TrajectoryBatch, batch_collides
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED
from avsec_gym.planners.batch import RectangleTracks, plan_batch
from avsec_gym.planners.planner import Mode, MotionPrimitivePlanner
from avsec_gym.planners.primitives import suitable_primitives
from avsec_gym.planners.problem import Problem
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.registry import Kind, make
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.roads import OWN, ROADS, THESIS, on_own_roads
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_arguments import scene_arguments
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import scene_set

_NO_SENSORS = "nothing is sensed here, the attacker changes what is detected"
OBJECT_LEVEL = {
    "attack": "the agent plays it",
    **dict.fromkeys(
        ("detector", "classifier", "selector", "validator", "clean", "response", "score_threshold"),
        _NO_SENSORS,
    ),
}
"""Parts that have no meaning in a game without images."""
MOST_GHOSTS = 32
"""As many ghosts as the real objects that an observation shows."""
_SAFE, _COLLISION, _UNPLANNED = map(OUTCOMES.index, (SAFE, COLLISION, UNPLANNED))
FAR = 1e7
"""Metres; where obstacles are put that are not there."""

Pick = Callable[[np.random.Generator, int, int], int]
"""Draws one of so many scenes and one of so many intentions: scene times intentions, plus
intention."""


def two_integers(generator: np.random.Generator, scenes: int, intentions: int) -> int:
    """A scene and an intention, as episodes of `avsec/GhostObject-v0` always drew them."""
    return int(generator.integers(scenes)) * intentions + int(generator.integers(intentions))


def one_number(generator: np.random.Generator, scenes: int, intentions: int) -> int:
    """The same from one uniform number, in a sixth of the time."""
    return int(generator.random() * scenes * intentions)


class GhostGame:
    """Rules and scenes.

    Args:
        scenarios: The scenes: a name or folder, or a dictionary of arguments, as of
            `avsec_gym.scenario.scene_sets.scene_set`; or a live `SceneSet`.
        planner: The victim's motion planner: a name, a dictionary or a live one.
        ghosts: Ghost objects that an action can place, at most `MOST_GHOSTS`.
        hides: Real objects that an action can hide, at most as many as an observation shows.
        motion: How much the planner knows of moving objects.
        ghost: The kind of ghosts, a key of `GHOSTS`.
        road: The road that the car drives on, one of `avsec_gym.scenario.roads.ROADS`.

    Raises:
        ConfigurationError: There is nothing to place or hide, the set is empty or unknown, its
            scenes have no road of their own that is asked for, or the planner does not plan in
            batches.
    """

    def __init__(
        self,
        scenarios: Any = "layouts",
        planner: Any = "astar",
        ghosts: int = 2,
        hides: int = 0,
        motion: Motion | str = Motion.STATIC,
        ghost: str = "patch",
        road: str = THESIS,
    ) -> None:
        self.range = GHOSTS[one_of("ghost", ghost, GHOSTS)]
        self.motion = Motion.without_classifier(motion)
        self.ghosts = whole_number("ghosts", ghosts, 0, MOST_GHOSTS)
        self.hides = whole_number("hides", hides, 0, NEAREST)
        if self.ghosts + self.hides == 0:
            raise ConfigurationError(
                "an attacker places ghosts or hides objects, got ghosts=0 and hides=0: for "
                "instance, give ghosts=1"
            )
        victim = make(Kind.PLANNER, planner)
        if not isinstance(victim, MotionPrimitivePlanner) or victim.mode != Mode.COMPLETE:
            raise ConfigurationError(
                "the ghost-object environment plans in batches: its planner is a"
                f" MotionPrimitivePlanner in complete mode, got {planner!r}"
            )
        self.scenes = _scenes(scenarios)
        if one_of("road", road, ROADS) == OWN:
            self.scenes = on_own_roads(self.scenes)
        self.victim = victim
        self._labelled = self.scenes.labelled
        self._ids = {scene.id: index for index, scene in enumerate(self._labelled)}
        self._rounds: dict[tuple[int, Intention], Round] = {}
        self._safe: dict[tuple[int, Intention], bool] = {}
        self._problems: dict[tuple[Any, ...], Problem] = {}
        self._drawable: dict[tuple[bool, tuple[Intention, ...]], dict[int, Round | None]] = {}
        """Rounds by number of scene and intention, None where they may not be drawn; with a further
        condition, which is always the same one, apart."""

    @property
    def action_size(self) -> int:
        """Four numbers for each ghost, one for each object to hide."""
        return 4 * self.ghosts + self.hides

    @property
    def observation_size(self) -> int:
        """Start, goal, objects, and the last query."""
        return SCENE_SIZE + 5 + 5 * self.ghosts + self.hides

    def draw_all(
        self,
        generators: Sequence[np.random.Generator],
        options: dict[str, Any] | None,
        fits: Callable[[Round], bool] | None = None,
        pick: Pick = two_integers,
    ) -> list[Round]:
        """Rounds that are driven safely without an attack, or those that options ask for.

        Args:
            generators: The random numbers that each round is drawn by.
            options: The user's options, which may pick ``scenario`` and ``intention``.
            fits: A further condition on a drawn round; None: there is none.
            pick: Function that draws a scene and an intention.

        Raises:
            ConfigurationError: No scene has the id, no such intention, or no round is safe.
        """
        options = reset_options(options)
        intentions = intentions_named(options.get("intention"))
        wanted = options.get("scenario")
        if wanted is not None:
            index = self._index(str(wanted))
            ways = self._labelled[index].possible(intentions)
            return [self.round(index, ways[int(g.integers(len(ways)))]) for g in generators]
        # Most of what is drawn was drawn before.
        known = self._drawable.setdefault((fits is None, intentions), {})
        count = len(self.scenes)

        def drawn(generator: np.random.Generator) -> Round:
            for _ in range(50 * count):
                number = pick(generator, count, len(intentions))
                if number not in known:
                    index, way = divmod(number, len(intentions))
                    known[number] = self._drawn(index, intentions[way], fits)
                round = known[number]
                if round is not None:
                    return round
            raise ConfigurationError(
                f"no scene of {self.scenes.name} is driven safely without an attack"
                f"{'' if fits is None else ' and unsafely with one'}: nothing to attack"
            )

        return [drawn(generator) for generator in generators]

    def _drawn(
        self, index: int, intention: Intention, fits: Callable[[Round], bool] | None
    ) -> Round | None:
        """The round, if it may be drawn."""
        if not self.scenes.plays(self._labelled[index].id, intention):
            return None
        if not self.is_safe(index, intention):
            return None
        safe = self.round(index, intention)
        return safe if fits is None or fits(safe) else None

    def round(self, index: int, intention: Intention) -> Round:
        """The round of one scene and intention."""
        key = (index, intention)
        if key not in self._rounds:
            self._rounds[key] = round_of(index, self._labelled[index], intention, self.motion)
        return self._rounds[key]

    def is_safe(self, index: int, intention: Intention) -> bool:
        """Whether a round is driven safely without an attack."""
        key = (index, intention)
        if key not in self._safe:
            idle = np.full((1, self.action_size), -1.0)
            answer = self.play([self.round(index, intention)], idle)
            self._safe[key] = bool(answer.outcome[0] == _SAFE)
        return self._safe[key]

    def play(self, rounds: Sequence[Round], actions: Floats) -> Queried:
        """One query in each round.

        Args:
            rounds: B rounds.
            actions: Shape (B, action_size), in [-1, 1].
        """
        count = len(rounds)
        on, ghosts = self.range.decode(actions[:, : 4 * self.ghosts].reshape(count, -1, 4))
        hidden = self.hidden(actions[:, 4 * self.ghosts :]) if self.hides else None
        return self.query(rounds, on, ghosts, hidden)

    def query(
        self,
        rounds: Sequence[Round],
        on: NDArray[np.bool_],
        ghosts: Floats,
        hidden: NDArray[np.int64] | None = None,
    ) -> Queried:
        """`play` for ghosts and hidden objects that are named in units.

        Args:
            rounds: B rounds.
            on: Flags of the ghosts that are there, shape (B, G).
            ghosts: Poses of the ghosts: x, y (m), heading (rad), shape (B, G, 3).
            hidden: Rows of the nearest objects to hide, -1 for none, shape (B, H); None: none.
        """
        count = len(rounds)
        unplanned, measured = np.full(count, _UNPLANNED), np.full((4, count), np.nan)
        hides = np.zeros(count, np.int64)
        answer = Queried(
            unplanned, measured[0], measured[1], measured[2], measured[3], on.sum(axis=1), hides
        )
        # Rounds of one kind differ in their obstacles only: they are planned as one batch.
        alike: dict[tuple[Any, ...], list[int]] = {}
        for b, each in enumerate(rounds):
            alike.setdefault(each.kind, []).append(b)
        for kind, members in alike.items():
            group = [rounds[b] for b in members]
            # The world as it is believed to be: real objects and ghosts, less what is hidden.
            half_sizes, tracks, real = self._lay_out(group, on[members], ghosts[members])
            if hidden is not None:
                for row, (b, each) in enumerate(zip(members, group, strict=True)):
                    gone = np.unique(hidden[b][(hidden[b] >= 0) & (hidden[b] < len(each.poses))])
                    tracks[row, gone, :, :2] = FAR
                    hides[b] = len(gone)
            # Plan in the believed world.
            problem = group[0].problem
            plans = plan_batch(
                self._problem(kind, problem),
                problem.last_step - problem.start.step + 1,
                problem.road.closed_edges,
                RectangleTracks(half_sizes, tracks),
                self.victim.node_limit,
            )
            if not plans.found.any():
                continue
            # Check the trajectories for collisions in the real one, and measure them there; where
            # all were found, nothing has to be copied.
            found: Any = slice(None) if plans.found.all() else plans.found
            planned = np.array(members)[found]
            batch = TrajectoryBatch(
                plans.trajectories[found],
                plans.lengths[found],
                real[found],
                half_sizes[found, : real.shape[1]],
            )
            collided = batch_collides(batch, BMW_320I)
            measures = batch_measures(batch, BMW_320I, problem)
            answer.outcome[planned] = np.where(collided, _COLLISION, _SAFE)
            measured[:, planned] = (plans.cost[found], *measures)
        return answer

    def observe(
        self,
        rounds: Sequence[Round],
        outcomes: NDArray[np.int64],
        costs: Floats,
        left: Floats,
        actions: Floats,
    ) -> NDArray[np.float32]:
        """Observations of B episodes, a new array.

        Args:
            rounds: B rounds.
            outcomes: Row of `OUTCOMES`, -1 before the first query, shape (B,).
            costs: Planned time, s, nan if unplanned, shape (B,).
            left: Share of the queries left, shape (B,).
            actions: The last actions, -1 before the first query, shape (B, action_size).

        Returns:
            Shape (B, observation_size), float32.
        """
        ghosts = actions[:, : 4 * self.ghosts].reshape(len(rounds), -1, 4)
        angle = np.pi * ghosts[..., 3:]
        last = [ghosts[..., :1] > 0, ghosts[..., 1:3], np.cos(angle), np.sin(angle)]
        placed = np.concatenate(last, axis=-1).reshape(len(rounds), -1)
        tail = np.concatenate([placed, actions[:, 4 * self.ghosts :]], axis=1)
        return observation(rounds, outcomes, costs, left, tail)

    def believed(self, round: Round, action: Floats) -> Boxes3D:
        """The detections that the car plans on after an action, shape (action_size,)."""
        boxes = round.scene.boxes
        on, poses = self.range.decode(action[: 4 * self.ghosts].reshape(-1, 4))
        obstacles = np.nonzero(is_obstacle(boxes))[0]
        nearest = obstacles[np.argsort(np.hypot(*boxes.poses[obstacles, :2].T), kind="stable")]
        hidden = self.hidden(action[None, 4 * self.ghosts :])[0]
        gone = nearest[hidden[(hidden >= 0) & (hidden < len(nearest))]]
        return inject_ghosts(hide_objects(boxes, gone), poses[on], self.range.dimensions)

    def _lay_out(
        self, group: list[Round], on: NDArray[np.bool_], ghosts: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Half sizes, what is believed (ghosts last) and what is real, padded with far objects."""
        counts = [len(each.poses) for each in group]
        rows, steps = max(counts), group[0].poses.shape[1]
        half_sizes = np.zeros((len(group), rows + ghosts.shape[1], 2))
        tracks = np.full((len(group), rows + ghosts.shape[1], steps, 4), FAR)
        for b, (each, n) in enumerate(zip(group, counts, strict=True)):
            half_sizes[b, :n], tracks[b, :n] = each.half_sizes, each.believed
        # What is real differs from that only where something moves.
        real = tracks[:, :rows].copy()
        if steps > 1:
            for b, (each, n) in enumerate(zip(group, counts, strict=True)):
                real[b, :n] = each.poses
        half_sizes[:, rows:] = 0.5 * np.array(self.range.dimensions[:0:-1])
        tracks[:, rows:, :, :2] = np.where(on[..., None], ghosts[..., :2], FAR)[:, :, None]
        tracks[:, rows:, :, 2] = np.cos(ghosts[..., 2])[..., None]
        tracks[:, rows:, :, 3] = np.sin(ghosts[..., 2])[..., None]
        return half_sizes, tracks, real

    def _problem(self, kind: tuple[Any, ...], scenario: PlanningScenario) -> Problem:
        if kind not in self._problems:
            primitives = self.victim.primitives or suitable_primitives(scenario)
            self._problems[kind] = self.victim.problem(scenario, primitives)
        return self._problems[kind]

    def hidden(self, actions: Floats) -> NDArray[np.int64]:
        """Which of the nearest objects each action hides; -1: none.

        Args:
            actions: Numbers in [-1, 1], shape (B, hides): 33 equal parts, the first for none.
        """
        part = np.floor(0.5 * (np.clip(actions, -1, 1) + 1.0) * (NEAREST + 1)).astype(np.int64)
        return np.minimum(part, NEAREST) - 1

    def _index(self, id: str) -> int:
        if id not in self._ids:
            raise ConfigurationError(
                f"{self.scenes.name} has no scene {id!r}; the first is {self._labelled[0].id!r}"
            )
        return self._ids[id]


@lru_cache(maxsize=16)
def _kept(arguments: tuple[tuple[str, Any], ...]) -> SceneSet:
    return scene_set(**dict(arguments))


def _scenes(scenarios: Any) -> SceneSet:
    """The set that is named, made once, or a live one.

    Raises:
        ConfigurationError: These are no arguments of `scene_set`, or the set is empty.
        DataError: A folder or file is missing or broken.
    """
    if isinstance(scenarios, SceneSet):
        scenes = scenarios
    else:
        scenes = _kept(tuple(sorted(scene_arguments(scenarios, scene_set).items())))
    if not len(scenes):
        raise ConfigurationError(f"the scene set {scenes.name} is empty")
    return scenes
