"""`PlanningScenario`: the input of a motion planner (thesis, section 5.3.1).

A scenario is written in one plane frame (metres, radians, x forward and y left of the ego vehicle
where it was built from a KITTI frame) and in time steps of ``dt`` seconds.  Numbers that no problem
can have, such as a position that is not finite, are a `PlanningError` as soon as an object is made
of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from avsec_gym.argument_checks import shown
from avsec_gym.errors import PlanningError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.bounds import (
    ANGLE,
    COORDINATE,
    DURATION,
    SPEED,
    TIME_STEP,
    Bounds,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.road import Road
from avsec_gym.scenario.shapes import Shape


@dataclass(frozen=True)
class EgoState:
    """The ego vehicle's state s = (p, v, phi, omega) at the start; the position is its centre."""

    x: float = 0.0
    y: float = 0.0
    velocity: float = 0.0
    heading: float = 0.0
    steering_angle: float = 0.0
    step: int = 0

    def __post_init__(self) -> None:
        COORDINATE.check(self.x, "the start's x")
        COORDINATE.check(self.y, "the start's y")
        SPEED.check(self.velocity, "the start's velocity")
        ANGLE.check(self.heading, "the start's heading")
        ANGLE.check(self.steering_angle, "the start's steering angle")
        TIME_STEP.check(self.step, "the start's time step")


@dataclass(frozen=True)
class Goal:
    """A goal region: the vehicle's centre within a region, its state within intervals."""

    steps: tuple[int, int]
    """First and last time step."""
    region: tuple[Shape, ...] | None = None
    """The centre lies in one of these; None: anywhere."""
    heading: tuple[float, float] | None = None
    velocity: tuple[float, float] | None = None
    lanelets: tuple[int, ...] = ()
    """The lanelets that the region stands for, where a file gave it that way."""

    def __post_init__(self) -> None:
        for interval, bounds, what in (
            (self.steps, TIME_STEP, "time window"),
            (self.heading, ANGLE, "heading interval"),
            (self.velocity, SPEED, "velocity interval"),
        ):
            if interval is not None:
                _check_interval(interval, bounds, what)
        if self.region is not None and not _are(Shape, self.region):
            raise PlanningError(
                f"a goal's region is {shown(self.region)}; expected a tuple of shapes, or None for"
                " anywhere."
            )


def _are(kind: Any, values: Any) -> bool:
    """Whether this is a tuple of one or more of a kind."""
    return isinstance(values, tuple) and bool(values) and all(isinstance(v, kind) for v in values)


def _check_interval(interval: tuple[float, float], bounds: Bounds, what: str) -> None:
    bounds.check_all(interval, f"an end of a goal's {what}")
    if len(interval) != 2:
        raise PlanningError(f"a goal's {what} is {shown(interval)}; expected two numbers.")
    if interval[0] > interval[1]:
        raise PlanningError(f"a goal's {what} {interval} ends before it begins.")


@dataclass(frozen=True)
class PlanningScenario:
    """A planning problem: start, goals, road and obstacles."""

    id: str
    start: EgoState
    goals: tuple[Goal, ...]
    road: Road = field(default_factory=Road)
    obstacles: Obstacles = field(default_factory=Obstacles.none)
    dt: float = 0.1
    road_type: RoadType | None = None
    intention: Intention | None = None

    def __post_init__(self) -> None:
        DURATION.check(self.dt, f"{self.id}: the duration of a time step")
        if self.goals and not _are(Goal, self.goals):
            raise PlanningError(f"{self.id}: goals are a tuple of Goal, got {shown(self.goals)}.")

    def with_obstacles(self, obstacles: Obstacles) -> PlanningScenario:
        """The same problem among other obstacles."""
        return replace(self, obstacles=obstacles)

    @property
    def last_step(self) -> int:
        """The latest time step that any goal accepts."""
        return max(goal.steps[1] for goal in self.goals)
