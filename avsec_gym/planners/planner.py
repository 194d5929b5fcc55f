"""The motion planner M: A* and GBFS over motion primitives (thesis, section 5.3.3)."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import World, collides, vanishing, within_reach, world_of
from avsec_gym.planners.estimates import Limits
from avsec_gym.planners.goal import GoalArrays, goal_arrays, reaches
from avsec_gym.planners.goal_room import occupied_steps
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.planners.primitives import MotionPrimitives, standard_primitives
from avsec_gym.planners.reachability import reach_table
from avsec_gym.planners.search import EXHAUSTED, FOUND, PAUSED, search
from avsec_gym.planners.search_state import SearchState, begin, grown, new_state, trajectory_to
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.planning_scenario import PlanningScenario

_EXPANSIONS_AT_A_TIME = 20_000
"""Between two looks at the clock."""
_NODES = 1024
"""Room at first."""
_NO_TABLE = np.zeros((0, 1, 6))
_WIDE_SPEED, _WIDE_STEP = 20.0, 2.0
"""Highest and spacing of the speeds where no road type says which, m/s."""


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

    def plan(
        self,
        scenario: PlanningScenario,
        *,
        world: World | None = None,
        explain: bool = True,
    ) -> Plan:
        """Find a trajectory.

        Args:
            scenario: What the planner believes.
            world: The scenario's obstacles and road edge where they are laid out already.
            explain: Find out why, where nothing is found.

        Raises:
            PlanningError: The problem has no goal, or no primitive starts at the start speed.
        """
        begun = time.perf_counter()
        setup = search_setup(self, scenario)
        primitives, start = setup.primitives, scenario.start
        if world is None:
            world = world_of(scenario)
        if self.mode == Mode.REFERENCE:
            world = vanishing(world)
        else:
            distance = setup.horizon * setup.limits.step_distance + primitives.vehicle.length
            world = within_reach(world, start.x, start.y, distance)
        state = new_state(_NODES, 2 * _NODES)
        begin(state, setup.start, setup.speed, start.step, setup.at_goal)
        outcome = PAUSED
        while outcome == PAUSED:
            left = self.node_limit - int(state.counters[2])
            if left <= 0 or time.perf_counter() - begun > self.time_limit:
                break
            outcome = search(
                setup.root,
                primitives.arrays,
                setup.goals,
                setup.limits,
                setup.reach,
                world,
                state,
                min(left, _EXPANSIONS_AT_A_TIME),
                setup.greedy,
                self.mode == Mode.REFERENCE,
            )
            if outcome == PAUSED:
                state = grown(state, primitives.arrays)
        tree = _tree(state, setup.limits) if self.keep_tree else None
        expanded = int(state.counters[2])
        if outcome == FOUND:
            node = int(state.counters[3])
            return Plan(
                Status.FOUND,
                trajectory=trajectory_to(
                    node,
                    primitives.arrays,
                    setup.limits.centre_offset,
                    state,
                    setup.steering_angle,
                    self.mode == Mode.REFERENCE,
                ),
                first_step=start.step,
                cost=float(state.elapsed[node]),
                expanded=expanded,
                seconds=time.perf_counter() - begun,
                tree=tree,
            )
        status = Status.EXHAUSTED if outcome == EXHAUSTED else Status.LIMIT
        seconds = time.perf_counter() - begun
        if not explain:
            return Plan(status, expanded=expanded, seconds=seconds, tree=tree)
        occupied = occupied_steps(scenario.goals, world, primitives.vehicle)
        return Plan(
            status,
            expanded=expanded,
            seconds=seconds,
            reason=_reason(status, scenario, world, primitives.vehicle, occupied),
            goal_occupied=occupied * scenario.dt,
            tree=tree,
        )


class SearchSetup(NamedTuple):
    """What the search kernel needs of a problem besides its obstacles."""

    primitives: MotionPrimitives
    root: NDArray[np.int64]
    """Primitives that may follow the start."""
    goals: GoalArrays
    limits: Limits
    reach: Floats
    start: Floats
    """Rear-axle x, y, heading."""
    speed: float
    """The speed that the primitives start with, m/s."""
    steering_angle: float
    """The steering angle that they start with, rad."""
    first_step: int
    """Time step of the start."""
    horizon: int
    """Steps from the start to the end of the last goal's time window."""
    node_limit: int
    greedy: bool
    at_goal: bool
    """The start is a goal state already."""


def search_setup(planner: MotionPrimitivePlanner, scenario: PlanningScenario) -> SearchSetup:
    """Prepare a search.

    Raises:
        PlanningError: The problem has no goal, or no primitive starts at the start speed.
    """
    reference = planner.mode == Mode.REFERENCE
    primitives = planner.primitives or suitable_primitives(scenario)
    if abs(primitives.dt - scenario.dt) > 1e-9:
        raise PlanningError(
            f"{scenario.id}: time steps of {scenario.dt} s, but the primitives of"
            f" {primitives.name} have {primitives.dt} s"
        )
    goals, start = goal_arrays(scenario.goals), scenario.start
    # commonroad-search starts with straight wheels whatever the file says.
    steering = 0.0 if reference else start.steering_angle
    speed, root = _starting(primitives, start.velocity, steering, reference)
    if not len(root):
        raise PlanningError(
            f"{scenario.id}: no primitive of {primitives.name} starts at {speed:g} m/s with a"
            f" steering angle of {steering:g} rad"
        )
    horizon, offset = max(0, scenario.last_step - start.step), primitives.vehicle.rear_axle
    x, y = start.x - offset * math.cos(start.heading), start.y - offset * math.sin(start.heading)
    return SearchSetup(
        primitives=primitives,
        root=root,
        goals=goals,
        limits=_limits(primitives),
        reach=_NO_TABLE if reference else reach_table(primitives, horizon),
        start=np.array([x, y, start.heading]),
        speed=speed,
        steering_angle=steering,
        first_step=start.step,
        horizon=horizon,
        node_limit=planner.node_limit,
        greedy=planner.algorithm == Algorithm.GBFS,
        at_goal=reaches(start.x, start.y, start.heading, speed, start.step, goals),
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


def _reason(
    status: Status, scenario: PlanningScenario, world: World, vehicle: Vehicle, occupied: int
) -> Reason:
    start = scenario.start
    cos, sin = math.cos(start.heading), math.sin(start.heading)
    half_length, half_width = vehicle.length / 2, vehicle.width / 2
    if collides(start.x, start.y, cos, sin, half_length, half_width, start.step, world):
        return Reason.START_OCCUPIED
    window = scenario.last_step - min(goal.steps[0] for goal in scenario.goals) + 1
    if occupied == window:
        return Reason.GOAL_OCCUPIED
    return Reason.LIMIT if status == Status.LIMIT else Reason.UNREACHABLE


@lru_cache(maxsize=256)
def _starting(
    primitives: MotionPrimitives, velocity: float, steering_angle: float, reference: bool
) -> tuple[float, NDArray[np.int64]]:
    speed = primitives.nearest_speed(velocity, endless_only=reference)
    return speed, primitives.starting_at(speed, steering_angle, endless_only=reference)


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
    used = int(state.counters[0])
    pose = state.pose[:used]
    offset = limits.centre_offset
    return np.column_stack(
        [
            pose[:, 0] + offset * np.cos(pose[:, 2]),
            pose[:, 1] + offset * np.sin(pose[:, 2]),
            state.parent[:used],
        ]
    )
