"""What became of a drive: its outcome and its metrics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from avsec_gym.closed_loop.drive_log import DriveLog, first_contact, smallest_distance
from avsec_gym.closed_loop.fault import STANDING, at_fault
from avsec_gym.closed_loop.navsim_score import (
    TTC_BOUND,
    NavsimScore,
    is_comfortable,
    no_collision,
    progress_share,
    stays_drivable,
    time_to_collision,
)
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.metrics.trajectory_cost import path_length, sm1_cost
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import Goal, PlanningScenario

_NEITHER_VEHICLE_NOR_PERSON = ("Misc",)


class Outcome(StrEnum):
    """How a drive ended."""

    GOAL = "goal"
    """The car came as far as it was to, in the lane that it was to reach."""
    COLLISION = "collision"
    OFF_ROAD = "off_road"
    """Its centre left the drivable area."""
    STOPPED = "stopped"
    """The time was over, or a human took over, and it stood."""
    TIME = "time"
    """The time was over, and it drove on."""


@dataclass(frozen=True)
class DriveRecord:
    """A drive's outcome and metrics.

    Args:
        outcome: How it ended.
        at_fault: Whether it ended in a collision that the car is to blame for (`fault`).
        duration: How long it took, seconds.
        path_length: Length of the driven path, metres.
        progress: Metres along the road.
        smallest_distance: Least distance to any actor, m; inf where there never is one.
        time_to_collision: Least time to a collision, s; inf where none lies within 3 s.
        cost_sm1: CommonRoad's cost SM1 of the driven trajectory.
        score: NAVSIM's score, with its parts.
        other: Category of what was touched; empty: nothing was.
    """

    outcome: Outcome
    at_fault: bool
    duration: float
    path_length: float
    progress: float
    smallest_distance: float
    time_to_collision: float
    cost_sm1: float
    score: NavsimScore
    other: str = ""


def goal_distance(scene: TrafficScene, duration: float) -> float:
    """How far along the road the goal lies, m: five sixths of the time at cruising speed.

    Args:
        scene: The scene.
        duration: Seconds that the drive may take.
    """
    return scene.cruise[0] * duration * 5 / 6


def reaches_goal(
    scene: TrafficScene, intention: Intention, car: tuple[float, float, float], distance: float
) -> bool:
    """Whether a pose x, y, heading lies far enough along the intended lane, and within it."""
    lane = scene.target_lane(intention)
    line = scene.lanes.line(lane)
    along, left = line.coordinates(car[0], car[1])
    begun, _ = line.coordinates(scene.start.x, scene.start.y)
    turned = abs(math.remainder(car[2] - line.heading(along), 2 * math.pi))
    return along - begun >= distance and abs(left) <= 0.5 * scene.lanes.width(lane) and turned < 0.5


def outcome_of_time(log: DriveLog) -> Outcome:
    """The outcome of a drive whose time is over."""
    return Outcome.STOPPED if log.car[-1, 2] <= STANDING else Outcome.TIME


def record_of(
    log: DriveLog, scene: TrafficScene, intention: Intention, outcome: Outcome, duration: float
) -> DriveRecord:
    """The metrics of a drive that ended.

    Args:
        log: The drive.
        scene: Where it took place.
        intention: Where the car wanted to go.
        outcome: How it ended.
        duration: Seconds that it might have taken.
    """
    contact = first_contact(log) if outcome == Outcome.COLLISION else None
    fault = contact is not None and at_fault(log, contact, scene.lanes, scene.drivable)
    line = scene.lanes.line(scene.start_lane)
    begin, end = (line.coordinates(*log.car[row, :2].tolist())[0] for row in (0, -1))
    ttc = time_to_collision(log, scene.lanes, scene.drivable)
    # A car that stands, handed over or not, makes no more of its way in the time that is left.
    driving = duration if outcome == Outcome.STOPPED else log.duration
    other = "" if contact is None else str(scene.tracks.categories[contact.actor])
    score = NavsimScore(
        no_collision=no_collision(contact, fault, log, thing=other in _NEITHER_VEHICLE_NOR_PERSON),
        drivable=float(stays_drivable(log, scene.drivable)),
        time_to_collision=float(ttc > TTC_BOUND),
        progress=progress_share(end - begin, scene.cruise[0] * driving),
        comfort=float(is_comfortable(log)),
    )
    stride = max(1, round(0.1 / log.dt))
    driven = log.car[::stride]
    problem = PlanningScenario(
        scene.id, scene.start, (Goal((0, len(driven)), velocity=scene.cruise),), scene.road
    )
    return DriveRecord(
        outcome=outcome,
        at_fault=fault,
        duration=log.duration,
        path_length=path_length(log.car),
        progress=end - begin,
        smallest_distance=smallest_distance(log),
        time_to_collision=ttc,
        cost_sm1=sm1_cost(driven, problem) if len(driven) > 1 else float(np.nan),
        score=score,
        other=other,
    )
