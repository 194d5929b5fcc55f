"""One drive: its row, its film, and how long it took."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.closed_loop.belief import belief_of
from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.closed_loop.drive_log import first_contact
from avsec_gym.closed_loop.drive_record import Outcome, goal_distance
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.navsim_score import COMFORT
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.closed_loop.planner_policy import Ambition, Replanning
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.drives.camera_views import CameraViews
from avsec_gym.drives.drive_row import drive_id
from avsec_gym.envs.drivers import PLANNER, Driver, driver_of
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.geometry import Floats
from avsec_gym.json_schemas import with_schema
from avsec_gym.metrics.safety import UNPLANNED, judge
from avsec_gym.scenario.scene import Motion

HARD_BRAKING = -COMFORT["longitudinal acceleration"][0]
"""m/s2: a deceleration above nuPlan's bound of comfort."""
_OF_INFO = (
    "outcome",
    "at_fault",
    "collision",
    "safe",
    "path_length",
    "progress",
    "smallest_distance",
    "time_to_collision",
    "cost_sm1",
    "navsim_score",
    "no_collision",
    "drivable",
    "ttc_bound",
    "progress_share",
    "comfort",
)
"""What the environment reports at the end."""


@dataclass(frozen=True)
class DriveTask:
    """A drive to be made.

    Args:
        setting: The name of the setting.
        scenario: The id of the scene.
        intention: The lane that the car wants to reach.
        seed: Seed of the environment's reset; the same under every setting.
    """

    setting: str
    scenario: str
    intention: str
    seed: int

    @property
    def id(self) -> str:
        """Names the drive among all others."""
        return drive_id(self.setting, self.scenario, self.intention)


@dataclass(frozen=True, eq=False)
class Driven:
    """A drive that was made.

    Args:
        row: What became of it, a `DriveRow`.
        film: All that can be shown of it.
        seconds: How long it took, without making the scene.
        views: What its left camera showed, see `CameraViews`.
    """

    row: dict[str, Any]
    film: DriveFilm
    seconds: float
    views: dict[int, bytes]


def drive(environment: Any, task: DriveTask, by: Any = PLANNER, *, views: bool = False) -> Driven:
    """Drive a scene to its end.

    Args:
        environment: The environment of the task's setting.
        task: The drive.
        by: Who drives: a name or a dictionary, as `driver_of` takes it.
        views: Whether what the left camera shows is kept, too.

    Raises:
        ConfigurationError: There is no such scene, or it has no lane for the intention.
        DataError: A file of the scene is missing or broken.
    """
    played = environment.unwrapped
    with one_thread():
        # The start of the drive.
        played.scenes.scene(task.scenario)
        driver = driver_of(by, environment)
        options = {"scenario": task.scenario, "intention": task.intention}
        begun = time.perf_counter()
        observation, info = environment.reset(seed=task.seed, options=options)
        start = played.surroundings()
        beliefs, elapsed, plans = [played.belief], [0.0], [-1]
        looking = CameraViews(played)
        if views:
            looking.look()
        # The drive: at each instant what is believed, when it is, and the number of the last plan.
        ended = False
        while not ended:
            action, _ = driver.predict(observation, deterministic=True)
            observation, _, terminated, truncated, info = environment.step(action)
            beliefs.append(played.belief)
            elapsed.append(played.elapsed)
            plans.append(len(_decisions(driver)) - 1)
            if views:
                looking.look()
            ended = terminated or truncated
        seconds = time.perf_counter() - begun
    # Its film and its row.
    decisions = _decisions(driver)
    plans[0] = min(0, len(decisions) - 1)
    film = _film(played, beliefs, elapsed, plans, decisions)
    stops = [each for each in decisions if each.ambition == Ambition.STOP]
    row: dict[str, Any] = {
        "id": task.id,
        "setting": task.setting,
        "scenario": task.scenario,
        "intention": task.intention,
        "seed": task.seed,
        "steps": len(elapsed) - 1,
        "duration": played.elapsed,
        **{name: _plain(info[name]) for name in _OF_INFO},
        "at_fault": bool(info["at_fault"]),
        "touched": _touched(played, film),
        "hardest_braking": round(float(film.braking.max()), 6),
        "emergency_stops": len(stops),
        "alarms": int(info["alarms"]),
        "first_plan": _first_plan(decisions[0], start, played.scene.lanes)
        if decisions
        else UNPLANNED,
    }
    return Driven(with_schema("drive.row", row), film, seconds, looking.pictures)


def _decisions(driver: Driver) -> list[Replanning]:
    """What a driver has planned so far; nothing, where it makes no plans."""
    return driver.policy.decisions if isinstance(driver, PlannerDriver) else []


def _first_plan(decision: Replanning, start: Surroundings, lanes: Lanes) -> str:
    """The outcome of a single query: of the plan to the intended lane, were it driven to its end.

    The car itself begins with something less ambitious where no stop would be left.

    Args:
        decision: The first decision.
        start: The truth at the start, whose objects go on at constant velocity.
        lanes: The lanes, which these follow where they bend.
    """
    if decision.single is None:
        return UNPLANNED
    truth = belief_of(TruthPerception().perceive(start), start, Motion.TRUTH)
    return judge(decision.single, decision.problem, truth.obstacles(lanes)).outcome


def _plain(value: Any) -> Any:
    """None where a number is not finite: there is no such thing, or never one near."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _touched(played: Any, film: DriveFilm) -> str:
    """The category of what the car has collided with; empty: with nothing."""
    row = int(film.contact[0])
    return "" if row < 0 else str(played.scene.tracks.categories[row])


def _film(
    played: Any,
    beliefs: list[Any],
    elapsed: list[float],
    plans: list[int],
    decisions: list[Replanning],
) -> DriveFilm:
    log, scene = played.log(), played.scene
    rows = np.round(np.array(elapsed) / log.dt).astype(int)
    car, speeds = log.car[rows], log.car[rows, 2]
    spans = np.diff(np.array(elapsed), prepend=-1.0)
    line = scene.lanes.line(scene.start_lane)
    ways = [line.heading(line.coordinates(x, y)[0]) for x, y in car[:, :2].tolist()]
    sides = [
        np.array(bound, float) for lane in scene.road.lanelets for bound in (lane.left, lane.right)
    ]
    points = [_points(each) for each in decisions]
    contact = first_contact(log) if played.outcome == Outcome.COLLISION else None
    return DriveFilm(
        times=np.array(elapsed),
        car=car,
        braking=np.maximum(-np.diff(speeds, prepend=speeds[0]) / spans, 0.0),
        ways=np.array(ways),
        sizes=log.sizes.reshape(-1, 2),
        poses=log.poses[rows],
        present=log.present[rows],
        believed=np.vstack(
            [np.column_stack([each.poses, each.lengths, each.widths]) for each in beliefs]
        ),
        believed_at=np.repeat(np.arange(len(beliefs)), [len(each.lengths) for each in beliefs]),
        plans=np.vstack([np.zeros((0, 2)), *points]),
        plan_of=np.repeat(np.arange(len(points)), np.array([len(each) for each in points], int)),
        planned=np.array(plans),
        stops=np.array(
            [number >= 0 and decisions[number].ambition == Ambition.STOP for number in plans]
        ),
        bounds=np.vstack(sides),
        bound_of=np.repeat(np.arange(len(sides)), [len(side) for side in sides]),
        goal=_goal_line(played),
        contact=np.array([-1 if contact is None else contact.actor]),
    )


def _points(decision: Replanning) -> Floats:
    trajectory = decision.plan.trajectory
    assert trajectory is not None, "an emergency stop is a trajectory, too"
    return np.asarray(trajectory[:, :2], float)


def _goal_line(played: Any) -> Floats:
    """The line across the intended lane that the car is to cross, shape (2, 2)."""
    scene = played.scene
    lane = scene.target_lane(played.intention)
    line, half = scene.lanes.line(lane), 0.5 * scene.lanes.width(lane)
    along = line.coordinates(scene.start.x, scene.start.y)[0] + goal_distance(
        scene, played.duration
    )
    return np.array([line.place(along, half), line.place(along, -half)])
