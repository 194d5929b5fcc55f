"""The motion planner M: A* and GBFS over motion primitives (thesis, section 5.3.3)."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners import search as kernel
from avsec_gym.planners.collision import World, collides, vanishing, within_reach, world_of
from avsec_gym.planners.goal import goal_arrays, occupied_steps
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.planners.primitives import MotionPrimitives, standard_primitives
from avsec_gym.planners.reachability import reach_table
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.constraints import RoadType, driving_constraints
from avsec_gym.scenario.planning_scenario import PlanningScenario

_EXPANSIONS_AT_A_TIME = 20_000
"""Between two looks at the clock."""
_NO_TABLE = np.zeros((0, 1, 6))


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

    Example:
        >>> from avsec_gym.scenario.builder import build_planning_scenario
        >>> from avsec_gym.boxes import Boxes3D
        >>> plan = MotionPrimitivePlanner().plan(build_planning_scenario(Boxes3D.empty()))
        >>> plan.status.value, round(plan.cost, 1)
        ('found', 1.9)
    """

    algorithm: Algorithm = Algorithm.ASTAR
    mode: Mode = Mode.COMPLETE
    primitives: MotionPrimitives | None = None
    node_limit: int = 200_000
    time_limit: float = 30.0

    def plan(
        self,
        scenario: PlanningScenario,
        *,
        world: World | None = None,
        keep_tree: bool = False,
        explain: bool = True,
    ) -> Plan:
        """Find a trajectory.

        Args:
            scenario: What the planner believes.
            world: The scenario's obstacles and road edge where they are laid out already.
            keep_tree: Return the nodes as well, for pictures.
            explain: Find out why, where nothing is found.

        Raises:
            PlanningError: The problem has no goal, or no primitive starts at the start speed.
        """
        begun = time.perf_counter()
        reference = self.mode == Mode.REFERENCE
        primitives = self._primitives_for(scenario)
        if abs(primitives.dt - scenario.dt) > 1e-9:
            raise PlanningError(
                f"{scenario.id}: time steps of {scenario.dt} s, but the primitives of"
                f" {primitives.name} have {primitives.dt} s"
            )
        goals = goal_arrays(scenario.goals)
        vehicle, start = primitives.vehicle, scenario.start
        # commonroad-search starts with straight wheels whatever the file says.
        steering = 0.0 if reference else start.steering_angle
        speed, root = _starting(primitives, start.velocity, steering, reference)
        if not len(root):
            raise PlanningError(
                f"{scenario.id}: no primitive of {primitives.name} starts at {speed:g} m/s with a"
                f" steering angle of {steering:g} rad"
            )
        limits = _limits(primitives)
        horizon = max(0, scenario.last_step - start.step)
        if world is None:
            world = world_of(scenario)
        if reference:
            world = vanishing(world)
        else:
            distance = horizon * limits.step_distance + vehicle.length
            world = within_reach(world, start.x, start.y, distance)
        reach = _NO_TABLE if reference else reach_table(primitives, horizon)
        at_goal = kernel.reaches(start.x, start.y, start.heading, speed, start.step, goals)
        rear = (
            start.x - vehicle.rear_axle * math.cos(start.heading),
            start.y - vehicle.rear_axle * math.sin(start.heading),
            start.heading,
        )
        state = _start_state(rear, speed, start.step, 0 if at_goal else -1)
        outcome = kernel.PAUSED
        while outcome == kernel.PAUSED:
            left = self.node_limit - int(state.counters[2])
            if left <= 0 or time.perf_counter() - begun > self.time_limit:
                break
            outcome = kernel.search(
                root,
                primitives.arrays,
                goals,
                limits,
                reach,
                world,
                state,
                min(left, _EXPANSIONS_AT_A_TIME),
                self.algorithm == Algorithm.GBFS,
                reference,
            )
            if outcome == kernel.PAUSED:
                state = _grown(state, primitives)
        tree = _tree(state, limits) if keep_tree else None
        expanded = int(state.counters[2])
        if outcome == kernel.FOUND:
            node = int(state.counters[3])
            return Plan(
                Status.FOUND,
                trajectory=kernel.trajectory_to(
                    node, primitives.arrays, limits, state, start.steering_angle
                ),
                first_step=start.step,
                cost=float(state.elapsed[node]),
                expanded=expanded,
                seconds=time.perf_counter() - begun,
                tree=tree,
            )
        status = Status.EXHAUSTED if outcome == kernel.EXHAUSTED else Status.LIMIT
        seconds = time.perf_counter() - begun
        if not explain:
            return Plan(status, expanded=expanded, seconds=seconds, tree=tree)
        occupied = occupied_steps(scenario.goals, world, vehicle)
        return Plan(
            status,
            expanded=expanded,
            seconds=seconds,
            reason=_reason(status, scenario, world, vehicle, occupied),
            goal_occupied=occupied * scenario.dt,
            tree=tree,
        )

    def _primitives_for(self, scenario: PlanningScenario) -> MotionPrimitives:
        if self.primitives is not None:
            return self.primitives
        road_type = scenario.road_type or _road_type_by_speed(scenario.start.velocity)
        grid = driving_constraints(road_type).primitive_speeds
        extra = () if scenario.start.velocity in grid else (scenario.start.velocity,)
        return standard_primitives(grid, extra)


def _road_type_by_speed(velocity: float) -> RoadType:
    """The road type whose start speed is nearer."""
    return min(
        RoadType, key=lambda road: abs(driving_constraints(road).start_speed - velocity)
    )


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
def _limits(primitives: MotionPrimitives) -> kernel.Limits:
    vehicle = primitives.vehicle
    heading = primitives.states[..., 3]
    centre = primitives.states[..., :2] + vehicle.rear_axle * np.stack(
        [np.cos(heading), np.sin(heading)], axis=-1
    )
    return kernel.Limits(
        half_length=vehicle.length / 2,
        half_width=vehicle.width / 2,
        centre_offset=vehicle.rear_axle,
        dt=primitives.dt,
        step_distance=float(np.linalg.norm(np.diff(centre, axis=1), axis=-1).max()),
    )


def _start_state(rear: tuple[float, float, float], speed: float, step: int, goal_index: int) -> kernel.SearchState:
    state = _empty_state(nodes=1024, table=2048)
    state.pose[0] = rear
    state.elapsed[0], state.velocity[0] = 0.0, speed
    state.parent[0], state.primitive[0] = -1, -1
    state.step[0], state.goal_index[0] = step, goal_index
    state.key[0], state.item[0] = 0.0, 0
    state.counters[:] = (1, 1, 0, -1, 0)
    return state


def _empty_state(nodes: int, table: int) -> kernel.SearchState:
    return kernel.SearchState(
        pose=np.empty((nodes, 3)),
        elapsed=np.empty(nodes),
        velocity=np.empty(nodes),
        parent=np.empty(nodes, np.int64),
        primitive=np.empty(nodes, np.int64),
        step=np.empty(nodes, np.int64),
        goal_index=np.empty(nodes, np.int64),
        key=np.empty(nodes),
        item=np.empty(nodes, np.int64),
        table=np.full(table, -1, np.int64),
        counters=np.zeros(5, np.int64),
    )


def _grown(state: kernel.SearchState, primitives: MotionPrimitives) -> kernel.SearchState:
    used = int(state.counters[0])
    new = _empty_state(nodes=2 * len(state.parent), table=2 * len(state.table))
    for name in ("pose", "elapsed", "velocity", "parent", "primitive", "step", "goal_index"):
        getattr(new, name)[:used] = getattr(state, name)[:used]
    queued = int(state.counters[1])
    new.key[:queued], new.item[:queued] = state.key[:queued], state.item[:queued]
    new.counters[:] = state.counters
    kernel.rehash(primitives.arrays, state, new)
    return new


def _tree(state: kernel.SearchState, limits: kernel.Limits) -> Floats:
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
