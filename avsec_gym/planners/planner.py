"""The motion planner M: A* and GBFS over motion primitives (thesis, section 5.3.3)."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from avsec_gym.argument_checks import flag, number, shown, whole_number
from avsec_gym.errors import ConfigurationError, PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import CollisionWorld, collides, collision_world_of, within_reach
from avsec_gym.planners.estimates import Limits
from avsec_gym.planners.goal import goal_arrays, reaches
from avsec_gym.planners.goal_room import is_full, occupied_steps
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.planners.primitives import MotionPrimitives, standard_primitives
from avsec_gym.planners.problem import Problem, plain
from avsec_gym.planners.reachability import reach_table
from avsec_gym.planners.search import EXHAUSTED, FOUND, FULL, PAUSED, advance, refuse_the_rest
from avsec_gym.planners.search_state import (
    COS,
    ELAPSED,
    EXPANDED,
    GOAL,
    GOAL_NODE,
    NODES,
    PARENT,
    REFUSED,
    SIN,
    SearchState,
    X,
    Y,
    grown,
    new_state,
)
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario

_FIRST_SLICE, _SLICE = 256, 1e-3
"""Nodes to expand before the first look at the clock, and seconds between two looks."""
_LEAST_TIME = 1e-9
"""Seconds: a limit of 0 would plan nothing."""
_ROOM = 2048
"""Nodes to make room for at first."""
_FEW = 16
"""So many obstacles are faster kept than sorted out."""
_memories = threading.local()
_NO_TABLE = np.zeros((0, 1, 6))
_WIDE_SPEED, _WIDE_STEP = 20.0, 2.0
"""Highest and spacing of the speeds where no road type gives them, m/s."""
_ROLLING_BACK = 0.1
"""m/s: so fast do vehicles move backwards that stand and are recorded."""
_FASTER = 10.0
"""m/s above the fastest start of the primitives: nothing faster is planned with them."""


class Algorithm(StrEnum):
    """What orders the queue."""

    ASTAR = "astar"
    """Elapsed time plus the estimated time to go."""
    GBFS = "gbfs"
    """The estimated time to go alone."""


class Mode(StrEnum):
    """How the space is searched; see `avsec_gym.planners.search`."""

    COMPLETE = "complete"
    REFERENCE = "reference"


class Planner(Protocol):
    """Anything that plans."""

    def plan(self, scenario: PlanningScenario) -> Plan:
        """Find a trajectory from the scenario's start to its goal."""


@dataclass(frozen=True)
class MotionPrimitivePlanner:
    """A best-first search over motion primitives.

    Args:
        algorithm: A* or GBFS.
        mode: ``complete`` (the default) always ends, with a certificate where nothing is found;
            ``reference`` expands the nodes that commonroad-search expands.
        primitives: The set to use; None generates the one of the scenario's road type, and
            primitives that lead onto its grid where the start speed lies off it.
        node_limit: Most nodes to expand.
        time_limit: Most seconds to search.
        keep_tree: Return the nodes with every plan, for pictures.

    Example:
        >>> from avsec_gym.scenario.builder import build_planning_scenario
        >>> from avsec_gym.boxes import Boxes3D
        >>> plan = MotionPrimitivePlanner().plan(build_planning_scenario(Boxes3D.empty()))
        >>> plan.status.value, round(plan.cost, 1)
        ('found', 1.7)
    """

    algorithm: Algorithm = Algorithm.ASTAR
    mode: Mode = Mode.COMPLETE
    primitives: MotionPrimitives | None = None
    node_limit: int = 100_000
    time_limit: float = 30.0
    keep_tree: bool = False

    def __post_init__(self) -> None:
        for name, kind in (("algorithm", Algorithm), ("mode", Mode)):
            value = getattr(self, name)
            try:
                object.__setattr__(self, name, kind(value))
            except ValueError:
                known = ", ".join(kind)
                raise ConfigurationError(
                    f"the planner's {name} is one of {known}, got {value!r}"
                ) from None
        if self.primitives is not None and not isinstance(self.primitives, MotionPrimitives):
            raise ConfigurationError(
                f"primitives is None or a set of MotionPrimitives, got {shown(self.primitives)}"
            )
        checked = {
            "node_limit": whole_number("node_limit", self.node_limit, 1),
            "time_limit": number("time_limit", self.time_limit, _LEAST_TIME, math.inf),
            "keep_tree": flag("keep_tree", self.keep_tree),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def plan(
        self,
        scenario: PlanningScenario,
        *,
        world: CollisionWorld | None = None,
        explain: bool = True,
    ) -> Plan:
        """Find a trajectory.

        Args:
            scenario: The believed scenario.
            world: The scenario's obstacles and road edge where they are laid out already.
            explain: Whether the reason is found out where nothing is found.

        Raises:
            PlanningError: The problem has no goal, no primitive starts at the start speed, or the
                start speed is negative or far above all that primitives start at.
        """
        # The problem, and the part of the world that the vehicle can come to.
        begun = time.perf_counter()
        primitives = self.primitives or suitable_primitives(scenario)
        problem, parts = self._prepared(scenario, primitives)
        start, vehicle = scenario.start, primitives.vehicle
        believed = collision_world_of(scenario, exact=problem.reference) if world is None else world
        world = believed
        if not problem.reference and len(world.poses) > _FEW:
            horizon = max(0, scenario.last_step - start.step)
            distance = horizon * problem.limits.step_distance + vehicle.length
            world = within_reach(world, start.x, start.y, distance)
        if not grown.overloads:
            _load_kernels(problem, parts, world)
            begun = time.perf_counter()
        # Search.
        outcome, trajectory, state = self._search(problem, parts, world, begun)
        expanded, tree = int(state.counters[EXPANDED]), None
        if self.keep_tree:
            refuse_the_rest(problem, world, state)
            tree = _tree(state, problem.limits)
        seconds = time.perf_counter() - begun
        if outcome == FOUND:
            return Plan(
                Status.FOUND,
                trajectory,
                start.step,
                problem.speed,
                float(state.pose[state.counters[GOAL_NODE], ELAPSED]),
                expanded,
                seconds,
                tree=tree,
            )
        # Nothing was found: proven, or given up; and why.
        status = Status.EXHAUSTED if outcome == EXHAUSTED else Status.LIMIT
        if (
            expanded >= self.node_limit
            and not problem.reference
            and is_full(scenario.goals, believed, vehicle)
        ):
            # What the search could not try to the end has no end: there is no place to end at.
            status = Status.EXHAUSTED
        occupied, reason = math.nan, None
        if explain:
            steps, reason = _explain(status, scenario, believed, vehicle)
            occupied = steps * scenario.dt
        return Plan(
            status,
            start_speed=problem.speed,
            expanded=expanded,
            seconds=seconds,
            reason=reason,
            goal_occupied=occupied,
            tree=tree,
        )

    def problem(self, scenario: PlanningScenario, primitives: MotionPrimitives) -> Problem:
        """What the search kernel needs to know of a scenario besides its obstacles.

        Raises:
            PlanningError: The scenario has no goal, or no primitive starts at its start speed.
        """
        return self._prepared(scenario, primitives)[0]

    def _prepared(
        self, scenario: PlanningScenario, primitives: MotionPrimitives
    ) -> tuple[Problem, tuple[Any, ...]]:
        """The problem, and the form of it that the kernel is called with."""
        if abs(primitives.dt - scenario.dt) > 1e-9:
            raise PlanningError(
                f"{scenario.id}: time steps of {scenario.dt} s, but the primitives of"
                f" {primitives.name} have {primitives.dt} s"
            )
        try:
            return _problem(self.algorithm, self.mode, primitives, scenario.start, scenario.goals)
        except PlanningError as error:
            raise PlanningError(f"{scenario.id}: {error}") from None

    def _search(
        self, problem: Problem, parts: tuple[Any, ...], world: CollisionWorld, begun: float
    ) -> tuple[int, Floats, SearchState]:
        """Search in slices of about a millisecond, looking at the clock in between."""
        state = _empty_memory(problem.reference)
        nodes, paused = _FIRST_SLICE, begun
        while True:
            budget = min(nodes, self.node_limit - int(state.counters[EXPANDED]))
            outcome, trajectory = advance(parts, tuple(world), tuple(state), budget)
            if outcome in (FOUND, EXHAUSTED):
                return outcome, trajectory, state
            now = time.perf_counter()
            if now - begun > self.time_limit or state.counters[EXPANDED] >= self.node_limit:
                return PAUSED, trajectory, state
            if outcome == FULL:
                state = grown(state, problem.primitives.end_class)
            else:
                nodes = min(2 * nodes, max(1, int(nodes * _SLICE / (now - paused))))
            paused = time.perf_counter()


def _empty_memory(reference: bool) -> SearchState:
    """Where this thread's searches begin; the next one overwrites what is in it."""
    kept: dict[bool, SearchState] = vars(_memories).setdefault("kept", {})
    state = kept.get(reference)
    if state is None:
        state = kept[reference] = new_state(_ROOM, 2 if reference else _ROOM)
    state.counters.fill(0)
    state.table.fill(-1)
    return state


def _load_kernels(problem: Problem, parts: tuple[Any, ...], world: CollisionWorld) -> None:
    """Compile them, or load them from disk: once in a process, and no part of a search's time."""
    state = new_state(_ROOM, 2)
    advance(parts, tuple(world), tuple(state), 0)
    grown(state, problem.primitives.end_class)


@lru_cache(maxsize=4096)
def _problem(
    algorithm: Algorithm,
    mode: Mode,
    primitives: MotionPrimitives,
    start: EgoState,
    goals: tuple[Goal, ...],
) -> tuple[Problem, tuple[Any, ...]]:
    reference = mode == Mode.REFERENCE
    # commonroad-search starts with straight wheels whatever the file states.
    steering = 0.0 if reference else start.steering_angle
    _check_start_speed(start.velocity, primitives)
    speed = primitives.nearest_speed(start.velocity, endless_only=reference)
    root = primitives.starting_at(speed, steering, endless_only=reference)
    if not len(root):
        raise PlanningError(
            f"no primitive of {primitives.name} starts at {speed:g} m/s with a steering angle of"
            f" {steering:g} rad"
        )
    laid_out = goal_arrays(goals)
    horizon = max(0, max(goal.steps[1] for goal in goals) - start.step)
    offset = primitives.vehicle.rear_axle
    x, y = start.x - offset * math.cos(start.heading), start.y - offset * math.sin(start.heading)
    problem = Problem(
        root=root,
        primitives=primitives.arrays,
        branching=max(len(root), int(np.diff(primitives.arrays.first_successor).max())),
        goals=laid_out,
        limits=_limits(primitives),
        reach=_NO_TABLE if reference else reach_table(primitives, horizon),
        start=np.array([x, y, start.heading]),
        speed=speed,
        steering_angle=steering,
        step=start.step,
        at_goal=bool(reaches(start.x, start.y, start.heading, speed, start.step, laid_out)),
        greedy=algorithm == Algorithm.GBFS,
        reference=reference,
    )
    return problem, plain(problem)


def _check_start_speed(velocity: float, primitives: MotionPrimitives) -> None:
    """Refuse a start that drives backwards, or far faster than the primitives.

    Slower ones than the slowest primitive are planned: the thesis' scenarios say 0 m/s.
    """
    fastest = float(primitives.states[:, 0, 2].max())
    if not -_ROLLING_BACK <= velocity <= fastest + _FASTER:
        raise PlanningError(
            f"the start's velocity is {velocity:g} m/s; expected 0 to {fastest + _FASTER:g} m/s,"
            f" {_FASTER:g} m/s above the fastest start of the primitives {primitives.name}."
            " Correct the velocity, or name other primitives"
        )


def suitable_primitives(scenario: PlanningScenario) -> MotionPrimitives:
    """The generated set for a scenario's road type, or one of all speeds where it has none.

    Where the start speed lies off the grid, primitives that lead onto it are added.
    """
    start = scenario.start.velocity
    if scenario.road_type is not None:
        grid = driving_constraints(scenario.road_type).primitive_speeds
    else:
        wanted = [start, *(goal.velocity[0] for goal in scenario.goals if goal.velocity)]
        fastest = min(BMW_320I.max_velocity, max(_WIDE_SPEED, *wanted))
        grid = tuple(np.arange(0.0, fastest + _WIDE_STEP, _WIDE_STEP).tolist())
    return standard_primitives(grid, () if start in grid else (start,))


def _explain(
    status: Status, scenario: PlanningScenario, world: CollisionWorld, vehicle: Vehicle
) -> tuple[int, Reason]:
    """Time steps without room in the goal region, and why nothing was found."""
    start = scenario.start
    at_start = (start.x, start.y, math.cos(start.heading), math.sin(start.heading))
    footprint = (vehicle.length / 2, vehicle.width / 2, start.step)
    free_ground = world._replace(edges=np.zeros((0, 4)))
    window = scenario.last_step - min(goal.steps[0] for goal in scenario.goals) + 1
    occupied = occupied_steps(scenario.goals, world, vehicle)
    if status == Status.LIMIT:
        return occupied, Reason.LIMIT
    if collides(*at_start, *footprint, free_ground):
        return occupied, Reason.START_OCCUPIED
    if collides(*at_start, *footprint, world):
        return occupied, Reason.OFF_ROAD
    if occupied == window:
        empty_road = within_reach(world, 0.0, 0.0, -math.inf)
        nowhere = occupied_steps(scenario.goals, empty_road, vehicle) == window
        return occupied, Reason.OFF_ROAD if nowhere else Reason.GOAL_OCCUPIED
    return occupied, Reason.UNREACHABLE


@lru_cache(maxsize=64)
def _limits(primitives: MotionPrimitives) -> Limits:
    vehicle = primitives.vehicle
    heading = primitives.states[..., 3]
    centre = primitives.states[..., :2] + vehicle.rear_axle * np.stack(
        [np.cos(heading), np.sin(heading)], axis=-1
    )
    return Limits(
        half_length=vehicle.length / 2,
        half_width=vehicle.width / 2,
        centre_offset=vehicle.rear_axle,
        dt=primitives.dt,
        step_distance=float(np.linalg.norm(np.diff(centre, axis=1), axis=-1).max()),
    )


def _tree(state: SearchState, limits: Limits) -> Floats:
    """The nodes whose ways are free, as centres x, y and numbers of their parents."""
    used = int(state.counters[NODES])
    pose, link = state.pose[:used], state.link[:used]
    free = link[:, GOAL] != REFUSED
    number = np.append(np.cumsum(free) - 1, -1)
    offset = limits.centre_offset
    return np.column_stack(
        [
            pose[:, X] + offset * pose[:, COS],
            pose[:, Y] + offset * pose[:, SIN],
            number[link[:, PARENT]],
        ]
    )[free]
