"""The motion planner M: A* and GBFS over motion primitives (thesis, section 5.3.3)."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from avsec_gym.argument_checks import flag, keep_checked, number, shown, whole_number
from avsec_gym.errors import ConfigurationError, PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import CollisionWorld, collision_world_of, within_reach
from avsec_gym.planners.explanation import why_nothing_was_found
from avsec_gym.planners.goal_room import is_full
from avsec_gym.planners.handles import handle_of
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.planners.primitives import MotionPrimitives, suitable_primitives
from avsec_gym.planners.problem import Problem, problem_of
from avsec_gym.planners.search import EXHAUSTED, FOUND, FULL, PAUSED, advance, refuse_the_rest
from avsec_gym.planners.search_memory import ROOM, first_memory, more_memory
from avsec_gym.planners.search_state import SearchState, grown, move, new_state
from avsec_gym.planners.search_tree import search_tree
from avsec_gym.scenario.planning_scenario import PlanningScenario

_FIRST_SLICE, _SLICE = 256, 1e-3
"""Nodes to expand before the first look at the clock, and seconds between two looks."""
_LEAST_TIME = 1e-9
"""Seconds: a limit of 0 would plan nothing."""
_FEW = 16
"""So many obstacles are faster kept than sorted out."""


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
        node_limit: Most nodes to expand; the memory's end (`Reason.MEMORY`) is a limit, too.
        time_limit: Most seconds to search.
        keep_tree: Whether every plan comes with its nodes, for pictures.

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
                    f"the planner's {name} is one of {known}, got {shown(value)}"
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
        keep_checked(self, checked)

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
        problem, asked = self._prepared(scenario, primitives)
        start, vehicle = scenario.start, primitives.vehicle
        believed = collision_world_of(scenario, exact=problem.reference) if world is None else world
        world = believed
        if not problem.reference and len(world.poses) > _FEW:
            horizon = max(0, scenario.last_step - start.step)
            distance = horizon * problem.limits.step_distance + vehicle.length
            world = within_reach(world, start.x, start.y, distance)
        if not getattr(grown, "overloads", True):  # NUMBA_DISABLE_JIT leaves nothing to load.
            _load_kernels(problem, asked, world)
            begun = time.perf_counter()
        # Search.
        outcome, trajectory, cost, expanded, state = self._search(problem, asked, world, begun)
        tree = None
        if self.keep_tree:
            refuse_the_rest(problem, world, state)
            tree = search_tree(state, problem.limits.centre_offset)
        seconds, speed = time.perf_counter() - begun, problem.speed
        if outcome == FOUND:
            return Plan(
                Status.FOUND, trajectory, start.step, speed, cost, expanded, seconds, tree=tree
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
        occupied, bound, reason = math.nan, math.nan, None
        if status == Status.LIMIT and self.algorithm == Algorithm.ASTAR and not problem.reference:
            # Every way to a goal leads through a node that is still in the queue.
            bound = max(0.0, (math.floor(state.key[0]) - start.step) * scenario.dt)
        if explain:
            steps, reason = why_nothing_was_found(status, scenario, believed, vehicle)
            occupied = steps * scenario.dt
            if outcome == FULL:
                reason = Reason.MEMORY
        return Plan(
            status,
            start_speed=speed,
            expanded=expanded,
            seconds=seconds,
            reason=reason,
            goal_occupied=occupied,
            lower_bound=bound,
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
    ) -> tuple[Problem, Any]:
        """The problem, and the handle on it that the kernel is called with."""
        if abs(primitives.dt - scenario.dt) > 1e-9:
            raise PlanningError(
                f"{scenario.id}: time steps of {scenario.dt} s, but the primitives of"
                f" {primitives.name} have {primitives.dt} s"
            )
        try:
            return problem_of(
                primitives,
                scenario.start,
                scenario.goals,
                greedy=self.algorithm is Algorithm.GBFS,
                reference=self.mode is Mode.REFERENCE,
            )
        except PlanningError as error:
            raise PlanningError(f"{scenario.id}: {error}") from None

    def _search(
        self, problem: Problem, asked: Any, world: CollisionWorld, begun: float
    ) -> tuple[int, Floats, float, int, SearchState]:
        """Search in slices of about a millisecond, looking at the clock in between.

        The last slice is as long as the time that is left.

        Returns:
            FOUND, EXHAUSTED, PAUSED (at a limit) or FULL (no memory is left); the trajectory, its
            cost in seconds, how many nodes were expanded; all nodes.
        """
        memory, around = first_memory(problem.reference), tuple(world)
        nodes, pace, paused = _FIRST_SLICE, _FIRST_SLICE / _SLICE, time.perf_counter()
        expanded, begins = 0, True
        while True:
            left_in_time = max(1.0, pace * (begun + self.time_limit - paused))
            budget = int(min(nodes, self.node_limit - expanded, left_in_time))
            outcome, trajectory, cost, expanded = advance(
                asked, around, memory.handle, budget, begins
            )
            if outcome in (FOUND, EXHAUSTED):
                return outcome, trajectory, cost, expanded, memory.state
            now, begins = time.perf_counter(), False
            if now - begun > self.time_limit or expanded >= self.node_limit:
                return PAUSED, trajectory, cost, expanded, memory.state
            if outcome == FULL:
                try:
                    memory = more_memory(memory.state, problem.primitives.end_class)
                except MemoryError:
                    return FULL, trajectory, cost, expanded, memory.state
            else:
                pace = budget / (now - paused)
                nodes = min(2 * nodes, max(1, int(pace * _SLICE)))
            paused = time.perf_counter()


def _load_kernels(problem: Problem, asked: Any, world: CollisionWorld) -> None:
    """Compile them, or load them from disk: once in a process, and no part of a search's time."""
    state, end_class = new_state(ROOM, 2), problem.primitives.end_class
    advance(asked, tuple(world), handle_of(state), 0, True)
    move(state, grown(state, end_class), end_class)
