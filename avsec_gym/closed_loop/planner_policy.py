"""The planner as a driver: it replans from the state that was really reached, and follows its plan.

At every replanning a few goals are tried, from the most ambitious to the least:

1. the lane that the intention names, at cruising speed (a single query's goal, moved on);
2. the lane that the car is in, at cruising speed: the change waits;
3. the same lane, slower and nearer;
4. an emergency stop.

A plan counts only if the car can still stop after it has been driven to the next replanning.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from avsec_gym.argument_checks import number
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.fail_safe import braked, is_fail_safe, steps_to_rest, widened
from avsec_gym.closed_loop.following import follow
from avsec_gym.closed_loop.made_primitives import primitives_from, rounded_start
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.emergency_stop import DECELERATION, emergency_stop
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner
from avsec_gym.planners.primitives import suitable_primitives
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.registry import Kind, make
from avsec_gym.scenario.builder import (
    GOAL_DISTANCE,
    GOAL_HEADING,
    GOAL_LENGTH,
    GOAL_STEPS,
    TIME_STEP,
)
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.shapes import Rectangle

REPLANNING = 0.5
"""Seconds between two plans."""
_SLOWER = (2 / 3, 1 / 3)
"""Shares of the cruising speed that are tried where that is too fast."""
_HEADWAY = GOAL_DISTANCE / 6.0
"""Seconds to the goal at cruising speed on a street; slower goals lie as far ahead in time."""
_LEAST_SHARE = 0.5
"""Share of the distance to the goal below which a lane change that is not done begins anew."""
_LEAST_ROOM = 1.0
"""Metres that a goal is wide at least."""
_REACTION = 0.25
"""Seconds at cruising speed that a goal lies beyond the way that full braking takes."""
_STOPPING = 60.0
"""Metres of lane to brake on before the first plan."""
_NODES = 6_000
"""Nodes that the search for a goal after the first may expand."""


class Ambition(StrEnum):
    """What the car does at present."""

    CHANGE = "intended lane"
    KEEP = "keep lane"
    SLOWER = "slower"
    STOP = "emergency stop"


@dataclass(frozen=True, eq=False)
class Replanning:
    """The result of one replanning.

    Args:
        time: When, seconds since the start of the drive.
        ambition: The goal that was reached.
        plan: The trajectory to follow.
        problem: The problem that it answers: the world as the car believed it to be.
        single: What the planner found for the intended lane, before it was asked whether a stop is
            left: of the first decision, the answer of a single query.  None: nothing, or an alarm
            stops the car.
    """

    time: float
    ambition: Ambition
    plan: Plan
    problem: PlanningScenario
    single: Plan | None


class PlannerPolicy:
    """Drives by a motion planner.

    Args:
        planner: A name, a dictionary or a live planner, as everywhere.
        replanning: Seconds between two plans.
    """

    def __init__(self, planner: Any = "astar", replanning: float = REPLANNING) -> None:
        self.planner: Planner = make(Kind.PLANNER, planner)
        self.replanning = number("replanning", replanning, 0.05, 10.0)
        self.decisions: list[Replanning] = []
        """Of the present drive, in the order of time."""
        self._scene: TrafficScene | None = None
        self._target = 0
        self._changes_until: float | None = None

    def begin(self, scene: TrafficScene, intention: Intention) -> None:
        """Forget the last drive.

        Args:
            scene: The road, the start and the speeds matter, not the actors.
            intention: The lane that the car wants to reach, beside the one that it starts in.

        Raises:
            ConfigurationError: There is no such lane.
        """
        self._scene, self._target = scene, scene.target_lane(intention)
        self._intention, self.decisions = intention, []
        self._changes_until = None

    def drive(
        self, state: EgoState, belief: Belief, now: float | None = None
    ) -> tuple[float, float]:
        """Acceleration (m/s2) and steering angle (rad, to the left) until the next call.

        Args:
            state: The state that the car has really reached.
            belief: The car's last belief; where a plan is due, that of the present.
            now: Seconds since the start of the drive; None: the time of the belief.
        """
        now = belief.time if now is None else now
        due = not self.decisions or now > self.next_plan - 1e-6
        if due or (belief.stops and self.decisions[-1].ambition != Ambition.STOP):
            self.decisions.append(self._decision(state, belief))
        decision = self.decisions[-1]
        trajectory = decision.plan.trajectory
        assert trajectory is not None
        return follow(trajectory, now - decision.time, state)

    @property
    def next_plan(self) -> float:
        """When the next plan is due, seconds since the start of the drive; 0 before the first."""
        return self.decisions[-1].time + self.replanning if self.decisions else 0.0

    def _decision(self, state: EgoState, belief: Belief) -> Replanning:
        problem, single, cruise = self._problem(state, belief, ()), None, self._cruise(belief)
        if not belief.stops:
            for ambition, goal in self._goals(state, belief):
                problem = replace(problem, goals=(goal,))
                first = not self.decisions or ambition == Ambition.CHANGE
                found = self._searched(problem, cruise, thorough=first)
                if ambition == Ambition.CHANGE:
                    single = found
                plan = self._fail_safe(found, problem, cruise)
                if plan is not None:
                    return Replanning(belief.time, ambition, plan, problem, single)
        stop = self._stop(state, problem, belief.time)
        return Replanning(belief.time, Ambition.STOP, stop, problem, single)

    def _problem(
        self, state: EgoState, belief: Belief, goals: tuple[Goal, ...]
    ) -> PlanningScenario:
        assert self._scene is not None
        last_step = max(GOAL_STEPS[1], steps_to_rest(state.velocity, self.replanning, TIME_STEP))
        return PlanningScenario(
            id=self._scene.id,
            start=state,
            goals=goals,
            road=self._scene.road,
            obstacles=belief.obstacles(self._scene.lanes, last_step),
            dt=TIME_STEP,
            road_type=belief.road_type,
            intention=self._intention,
        )

    def _cruise(self, belief: Belief) -> tuple[float, float]:
        """The range of speeds r: the scene's own, or that of another type the car believes in."""
        assert self._scene is not None
        if belief.road_type == self._scene.road_type:
            return self._scene.cruise
        return driving_constraints(belief.road_type).goal_velocity

    def _goals(self, state: EgoState, belief: Belief) -> Iterator[tuple[Ambition, Goal]]:
        assert self._scene is not None
        low, high = self._cruise(belief)
        own = self._scene.lanes.at(state.x, state.y, state.heading)
        stopping = high**2 / (2 * DECELERATION) + _REACTION * high
        ahead = max(GOAL_DISTANCE, stopping)
        before = self._left_to_change(state, own, ahead) if self.decisions else ahead
        yield Ambition.CHANGE, self._goal(state, self._target, before, (low, high))
        if own != self._target:
            yield Ambition.KEEP, self._goal(state, own, ahead, (low, high))
        for share in _SLOWER:
            speed = share * low
            goal = self._goal(state, own, _HEADWAY * speed, (speed - 1.0, speed + 1.0))
            yield Ambition.SLOWER, goal

    def _left_to_change(self, state: EgoState, own: int, ahead: float) -> float:
        """Metres to the goal in the intended lane.

        Within that lane, it lies ahead by the full distance.  Before, it stays where it was when
        the change began: a goal that moved on with the car would put the change off for ever.
        Where it cannot be reached any more, the change begins anew.
        """
        assert self._scene is not None
        line = self._scene.lanes.line(self._target)
        along, left = line.coordinates(state.x, state.y)
        inside = own == self._target and abs(left) <= 0.5 * self._room(self._target)
        nearest = _LEAST_SHARE * ahead
        if inside or self._changes_until is None or self._changes_until - along < nearest:
            self._changes_until = along + ahead
        return self._changes_until - along

    def _room(self, lane: int) -> float:
        """Width within which the car's centre lies if all of it is in a lane, metres."""
        assert self._scene is not None
        return max(self._scene.lanes.width(lane) - BMW_320I.width, _LEAST_ROOM)

    def _goal(
        self, state: EgoState, lane: int, ahead: float, velocity: tuple[float, float]
    ) -> Goal:
        """A stretch of a lane, so far ahead."""
        assert self._scene is not None
        line, width = self._scene.lanes.line(lane), self._scene.lanes.width(lane)
        if self.decisions:  # The first plan is a single query's, whose goal is as wide as the lane.
            width = self._room(lane)
        along, _ = line.coordinates(state.x, state.y)
        x, y, heading = line.pose(along + ahead)
        # Headings are counted on from the car's, without a jump at half a turn.
        heading = state.heading + math.remainder(heading - state.heading, 2 * math.pi)
        return Goal(
            steps=GOAL_STEPS,
            region=(Rectangle(GOAL_LENGTH, width, x, y, heading),),
            heading=(heading - GOAL_HEADING, heading + GOAL_HEADING),
            velocity=velocity,
        )

    def _fail_safe(
        self, plan: Plan | None, problem: PlanningScenario, cruise: tuple[float, float]
    ) -> Plan | None:
        """The plan, or another to the same goal, that is fail-safe; None where none is found.

        The planner looks at time steps alone, as in the thesis, and no further than to the goal.
        Where that is not enough, it is shown larger obstacles, and asked once more.
        """
        if plan is None or self._holds(plan, problem):
            return plan
        wider = problem.with_obstacles(widened(problem.obstacles))
        plan = self._searched(wider, cruise, thorough=False)
        return plan if plan is not None and self._holds(plan, problem) else None

    def _holds(self, plan: Plan, problem: PlanningScenario) -> bool:
        """Whether the plan can be driven until the next one, and a stop is left then."""
        assert self._scene is not None
        trajectory, drivable = np.asarray(plan.trajectory), self._scene.drivable
        return is_fail_safe(trajectory, problem.obstacles, self.replanning, drivable)

    def _searched(
        self, problem: PlanningScenario, cruise: tuple[float, float], *, thorough: bool
    ) -> Plan | None:
        """What the planner finds; None: nothing."""
        planner = self.planner
        try:
            if not isinstance(planner, MotionPrimitivePlanner):
                plan = planner.plan(problem)
            else:
                speed = _speed_on_grid(problem, cruise) if planner.primitives is None else None
                if speed is not None:
                    problem = replace(problem, start=replace(problem.start, velocity=speed))
                elif planner.primitives is None:
                    start = problem.start
                    made = primitives_from(start.velocity, start.steering_angle, cruise)
                    planner = replace(planner, primitives=made)
                    problem = replace(problem, start=rounded_start(start, made))
                    thorough = False
                if not thorough:
                    planner = replace(planner, node_limit=min(_NODES, planner.node_limit))
                plan = planner.plan(problem, explain=False)
        except PlanningError:
            return None
        return plan if plan.found else None

    def _stop(self, state: EgoState, problem: PlanningScenario, time: float) -> Plan:
        """Full braking along the path of the last plan; before the first, along the lane."""
        if self.decisions:
            last = self.decisions[-1]
            path, elapsed = np.asarray(last.plan.trajectory), time - last.time
        else:
            path, elapsed = self._lane_ahead(state), 0.0
        trajectory = braked(path, elapsed, state.velocity)
        return replace(emergency_stop(problem), trajectory=trajectory)

    def _lane_ahead(self, state: EgoState) -> Floats:
        """States that keep the car's distance from its lane's middle, a metre apart."""
        assert self._scene is not None
        lanes = self._scene.lanes
        line = lanes.line(lanes.at(state.x, state.y, state.heading))
        along, left = line.coordinates(state.x, state.y)
        poses = [line.pose(along + way, left) for way in range(round(_STOPPING))]
        return np.array([(x, y, state.velocity, heading, 0.0) for x, y, heading in poses])


def _speed_on_grid(problem: PlanningScenario, cruise: tuple[float, float]) -> float | None:
    """The speed of the thesis' primitives that begin at the state that was reached.

    None where there are none, or where they do not serve the goal.
    """
    start = problem.start
    if problem.road_type is None:
        return None
    usual = driving_constraints(problem.road_type)
    velocity = problem.goals[0].velocity
    if cruise != usual.goal_velocity or velocity != cruise:
        return None
    primitives = suitable_primitives(replace(problem, start=EgoState(velocity=cruise[0])))
    speed = primitives.nearest_speed(start.velocity)
    if abs(speed - start.velocity) < 0.02 and len(
        primitives.starting_at(speed, start.steering_angle)
    ):
        return speed
    return None
