"""Planning scenarios to and from CommonRoad XML, by way of commonroad-io.

What `write_commonroad` writes, `read_commonroad` reads back bit for bit.  Road type, intention and
the scenario's own id have no place in the format; they travel in its ``source`` attribute.  Only
the rectangles and discs of moving obstacles that lie off the obstacle's origin become polygons,
because commonroad-io writes them without their place.
"""

from __future__ import annotations

import json
import math
import os
import warnings
import xml.etree.ElementTree as ElementTree
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.scenario.constraints import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import (
    EgoState,
    Goal,
    Lanelet,
    Obstacles,
    PlanningScenario,
    Road,
)
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, Shape

_MARK = "avsec-gym "
_DECIMALS = 30
"""Enough for every double that is not denormally small."""


def read_commonroad(path: str | Path, problem_id: int | None = None) -> PlanningScenario:
    """Read one planning problem.

    Args:
        path: A CommonRoad XML file (format 2018b or 2020a).
        problem_id: Which planning problem; None takes the file's first.

    Raises:
        DataError: The file is not CommonRoad XML, or uses something that cannot be planned with.
    """
    _import_quietly()
    from commonroad.common.file_reader import CommonRoadFileReader

    path = Path(path)
    if not path.is_file():
        raise DataError("there is no such file.", path=path, remedy="Check the path.")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            reader = CommonRoadFileReader(path)
            scenario, problems = reader.open()
    except Exception as error:
        raise DataError(
            f"this is not a CommonRoad file that commonroad-io can read"
            f" ({type(error).__name__}: {error}).",
            path=path,
            remedy="Write CommonRoad 2020a XML, with at least one planningProblem.",
        ) from error
    known = problems.planning_problem_dict
    if not known or (problem_id is not None and problem_id not in known):
        asked = "any" if problem_id is None else f"the planning problem {problem_id}"
        raise DataError(
            f"the file does not hold {asked} planning problem."
            if problem_id is None
            else f"the file does not hold {asked}; it has {sorted(known)}.",
            path=path,
            remedy="Add a planningProblem element, or name one that is there.",
        )
    problem = known[next(iter(known)) if problem_id is None else problem_id]
    _check_elements(path, problem.planning_problem_id)
    notes = _notes(scenario.source)
    try:
        start = problem.initial_state
        return PlanningScenario(
            id=notes.get("id", path.stem),
            start=EgoState(
                x=_finite(start.position[0]),
                y=_finite(start.position[1]),
                velocity=_finite(start.velocity),
                heading=_finite(start.orientation),
                steering_angle=_finite(notes.get("steering_angle", 0.0)),
                step=int(start.time_step),
            ),
            goals=_goals(problem.goal),
            road=Road(tuple(_lanelet(lanelet) for lanelet in scenario.lanelet_network.lanelets)),
            obstacles=_obstacles(scenario),
            dt=float(scenario.dt),
            road_type=RoadType(notes["road_type"]) if "road_type" in notes else None,
            intention=Intention(notes["intention"]) if "intention" in notes else None,
        )
    except (TypeError, AttributeError, ValueError, IndexError) as error:
        raise DataError(
            f"a part of the scenario cannot be planned with ({error}).",
            path=path,
            remedy="States need exact, finite values; obstacles need a shape and a trajectory.",
        ) from error


def write_commonroad(
    scenario: PlanningScenario, path: str | Path, *, overwrite: bool = False
) -> None:
    """Write a scenario as CommonRoad 2020a XML.

    Args:
        scenario: What to write.
        path: Where to; its folder must exist.
        overwrite: Replace a file that is there.

    Raises:
        DataError: The file exists.
    """
    _import_quietly()
    from commonroad.common.file_writer import CommonRoadFileWriter, OverwriteExistingFile
    from commonroad.scenario.scenario import Tag

    path = Path(path)
    if path.exists() and not overwrite:
        raise DataError("the file exists.", path=path, remedy="Name another, or allow overwriting.")
    notes: dict[str, Any] = {"id": scenario.id}
    if scenario.road_type:
        notes["road_type"] = str(scenario.road_type)
    if scenario.intention:
        notes["intention"] = str(scenario.intention)
    if scenario.start.steering_angle:
        notes["steering_angle"] = scenario.start.steering_angle
    document, problems = to_commonroad(scenario)
    highway = scenario.road_type == RoadType.HIGHWAY
    partial = path.with_suffix(f".{os.getpid()}.part")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        CommonRoadFileWriter(
            document,
            problems,
            author="avsec-gym",
            affiliation="avsec-gym",
            source=_MARK + json.dumps(notes, sort_keys=True),
            tags={Tag.HIGHWAY if highway else Tag.URBAN},
            decimal_precision=_DECIMALS,
        ).write_to_file(str(partial), OverwriteExistingFile.ALWAYS)
    os.replace(partial, path)


def to_commonroad(scenario: PlanningScenario) -> tuple[Any, Any]:
    """The scenario as commonroad-io's ``Scenario`` and ``PlanningProblemSet``."""
    _import_quietly()
    from commonroad.common.util import AngleInterval, Interval
    from commonroad.planning.goal import GoalRegion
    from commonroad.planning.planning_problem import PlanningProblem, PlanningProblemSet
    from commonroad.scenario.lanelet import Lanelet as CommonRoadLanelet
    from commonroad.scenario.lanelet import LaneletNetwork, LaneletType
    from commonroad.scenario.scenario import Scenario, ScenarioID
    from commonroad.scenario.state import CustomState, InitialState

    document = Scenario(scenario.dt, ScenarioID.from_benchmark_id("ZAM_Avsec-1_1_T-1", "2020a"))
    lanelets = []
    for lanelet in scenario.road.lanelets:
        left, right = np.array(lanelet.left), np.array(lanelet.right)
        if left.shape != right.shape:
            raise DataError(
                f"lanelet {lanelet.id} has {len(left)} points on its left bound and {len(right)}"
                " on its right; CommonRoad pairs them.",
                remedy="Sample both bounds equally often.",
            )
        lanelets.append(
            CommonRoadLanelet(
                left,
                0.5 * (left + right),
                right,
                lanelet.id,
                predecessor=list(lanelet.predecessors),
                successor=list(lanelet.successors),
                adjacent_left=lanelet.adjacent_left[0] if lanelet.adjacent_left else None,
                adjacent_left_same_direction=(
                    lanelet.adjacent_left[1] if lanelet.adjacent_left else None
                ),
                adjacent_right=lanelet.adjacent_right[0] if lanelet.adjacent_right else None,
                adjacent_right_same_direction=(
                    lanelet.adjacent_right[1] if lanelet.adjacent_right else None
                ),
                lanelet_type={LaneletType(name) for name in lanelet.types},
            )
        )
    document.add_objects(LaneletNetwork.create_from_lanelet_list(lanelets))
    for i in range(len(scenario.obstacles)):
        document.add_objects(_commonroad_obstacle(scenario.obstacles, i))
    goal_states, of_lanelets = [], {}
    for i, goal in enumerate(scenario.goals):
        state: dict[str, Any] = {"time_step": Interval(*goal.steps)}
        if goal.region is not None:
            shape = goal.region[0] if len(goal.region) == 1 else Group(goal.region)  # type: ignore[arg-type]
            state["position"] = _commonroad_shape(shape)
        if goal.lanelets:
            of_lanelets[i] = list(goal.lanelets)
        if goal.heading is not None:
            state["orientation"] = AngleInterval(*goal.heading)
        if goal.velocity is not None:
            state["velocity"] = Interval(*goal.velocity)
        goal_states.append(CustomState(**state))
    start = scenario.start
    used = {*scenario.obstacles.ids.tolist(), *(lanelet.id for lanelet in scenario.road.lanelets)}
    problem = PlanningProblem(
        next(number for number in range(100, 10**9) if number not in used),
        InitialState(
            position=np.array([start.x, start.y]),
            orientation=start.heading,
            velocity=start.velocity,
            time_step=start.step,
            acceleration=0.0,
            yaw_rate=0.0,
            slip_angle=0.0,
        ),
        GoalRegion(goal_states, of_lanelets or None),
    )
    return document, PlanningProblemSet([problem])


@cache
def _import_quietly() -> None:
    """commonroad-io's protobuf warns as it is imported, of what users cannot mend."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import_module("commonroad.common.file_reader")
        import_module("commonroad.common.file_writer")


def _notes(source: str | None) -> dict[str, Any]:
    if not source or not source.startswith(_MARK):
        return {}
    try:
        notes = json.loads(source[len(_MARK) :])
    except json.JSONDecodeError:
        return {}
    return notes if isinstance(notes, dict) else {}


def _check_elements(path: Path, problem_id: int) -> None:
    """Find what commonroad-io passes over: a start without values, no goal, one id given twice.

    Raises:
        DataError: One of these.
    """
    root = ElementTree.parse(path).getroot()
    ids = [child.get("id") for child in root if child.get("id") is not None]
    twice = next((id for id in ids if ids.count(id) > 1), None)
    if twice is not None:
        raise DataError(
            f"two elements have the id {twice}.", path=path, remedy="Give each an id of its own."
        )
    problem = root.find(f"planningProblem[@id='{problem_id}']")
    if problem is None:
        return
    needed = ("position", "orientation", "velocity", "time")
    missing = [name for name in needed if problem.find(f"initialState/{name}") is None]
    if missing:
        raise DataError(
            f"the initial state of planning problem {problem_id} has no {missing[0]}.",
            path=path,
            remedy=f"An initial state has {', '.join(needed[:-1])} and {needed[-1]}.",
        )
    if problem.find("goalState") is None:
        raise DataError(
            f"planning problem {problem_id} has no goal.",
            path=path,
            remedy="Add a goalState element.",
        )


def _finite(value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"the number {number} in it")
    return number


def _lanelet(lanelet: Any) -> Lanelet:
    def neighbour(id: int | None, same: bool | None) -> tuple[int, bool] | None:
        return None if id is None else (int(id), bool(same))

    return Lanelet(
        id=int(lanelet.lanelet_id),
        left=_points(lanelet.left_vertices),
        right=_points(lanelet.right_vertices),
        predecessors=tuple(lanelet.predecessor),
        successors=tuple(lanelet.successor),
        adjacent_left=neighbour(lanelet.adj_left, lanelet.adj_left_same_direction),
        adjacent_right=neighbour(lanelet.adj_right, lanelet.adj_right_same_direction),
        types=tuple(sorted({kind.value for kind in lanelet.lanelet_type} - {"unknown"})),
    )


def _points(vertices: Any) -> tuple[tuple[float, float], ...]:
    return tuple((_finite(x), _finite(y)) for x, y in np.asarray(vertices)[:, :2])


def _goals(region: Any) -> tuple[Goal, ...]:
    lanelets = region.lanelets_of_goal_position or {}
    goals = []
    for i, state in enumerate(region.state_list):
        position, heading = getattr(state, "position", None), getattr(state, "orientation", None)
        velocity = getattr(state, "velocity", None)
        shape = None if position is None else _shape(position)
        goals.append(
            Goal(
                steps=(int(state.time_step.start), int(state.time_step.end)),
                region=(
                    None
                    if shape is None
                    else tuple(shape.shapes)
                    if isinstance(shape, Group)
                    else (shape,)
                ),
                heading=None if heading is None else (_finite(heading.start), _finite(heading.end)),
                velocity=None
                if velocity is None
                else (_finite(velocity.start), _finite(velocity.end)),
                lanelets=tuple(lanelets.get(i, ())),
            )
        )
    return tuple(goals)


def _shape(shape: Any) -> Shape:
    from commonroad.geometry import shape as commonroad

    if isinstance(shape, commonroad.Rectangle):
        x, y = (_finite(value) for value in shape.center)
        return Rectangle(
            _finite(shape.length), _finite(shape.width), x, y, _finite(shape.orientation)
        )
    if isinstance(shape, commonroad.Circle):
        return Disc(_finite(shape.radius), _finite(shape.center[0]), _finite(shape.center[1]))
    if isinstance(shape, commonroad.Polygon):
        points = _points(shape.vertices)
        return Polygon(points[:-1] if points[0] == points[-1] else points)
    if isinstance(shape, commonroad.ShapeGroup):
        return Group(tuple(_shape(part) for part in shape.shapes))  # type: ignore[misc]
    raise TypeError(f"a position given as {type(shape).__name__}")


def _commonroad_shape(shape: Shape) -> Any:
    from commonroad.geometry import shape as commonroad

    if isinstance(shape, Rectangle):
        centre = np.array([shape.x, shape.y])
        return commonroad.Rectangle(shape.length, shape.width, centre, shape.heading)
    if isinstance(shape, Disc):
        return commonroad.Circle(shape.radius, np.array([shape.x, shape.y]))
    if isinstance(shape, Polygon):
        return commonroad.Polygon(np.array(shape.vertices))
    return commonroad.ShapeGroup([_commonroad_shape(part) for part in shape.shapes])


def _obstacles(scenario: Any) -> Obstacles:
    rows = []
    for obstacle in scenario.static_obstacles:
        rows.append((obstacle, [obstacle.initial_state], True))
    for obstacle in scenario.dynamic_obstacles:
        states = [obstacle.initial_state]
        if obstacle.prediction is not None:
            states += obstacle.prediction.trajectory.state_list
        rows.append((obstacle, states, False))
    if not rows:
        return Obstacles.none()
    longest = max(len(states) for _, states, _ in rows)
    poses, speeds = np.zeros((len(rows), longest, 3)), np.zeros((len(rows), longest))
    for i, (_, states, _) in enumerate(rows):
        steps = [int(state.time_step) for state in states]
        if steps != list(range(steps[0], steps[0] + len(steps))):
            raise ValueError("an obstacle's states skip a time step")
        known = len(states)
        poses[i, :known] = [(*state.position[:2], state.orientation) for state in states]
        speeds[i, :known] = [getattr(state, "velocity", None) or 0.0 for state in states]
        poses[i, known:], speeds[i, known:] = poses[i, known - 1], speeds[i, known - 1]
    if not (np.isfinite(poses).all() and np.isfinite(speeds).all()):
        raise ValueError("a number that is not finite in an obstacle's states")
    return Obstacles(
        ids=np.array([obstacle.obstacle_id for obstacle, _, _ in rows]),
        categories=np.array([obstacle.obstacle_type.value for obstacle, _, _ in rows]),
        shapes=tuple(_shape(obstacle.obstacle_shape) for obstacle, _, _ in rows),
        poses=poses,
        speeds=speeds,
        steps=np.array([len(states) for _, states, _ in rows]),
        first_step=np.array([int(states[0].time_step) for _, states, _ in rows]),
        static=np.array([static for _, _, static in rows]),
    )


def _without_offsets(shape: Shape) -> Shape:
    """The same shape in a form that commonroad-io can write for moving obstacles."""
    if isinstance(shape, Group):
        return Group(tuple(_without_offsets(part) for part in shape.shapes))  # type: ignore[misc]
    if isinstance(shape, Polygon):
        return shape
    plain: Shape
    if isinstance(shape, Rectangle):
        plain = Rectangle(shape.length, shape.width)
    else:
        plain = Disc(shape.radius)
    if shape == plain:
        return shape
    return Polygon(_points(shape.polygon().exterior.coords)[:-1])


def _commonroad_obstacle(obstacles: Obstacles, i: int) -> Any:
    from commonroad.prediction.prediction import TrajectoryPrediction
    from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType, StaticObstacle
    from commonroad.scenario.state import InitialState, KSState
    from commonroad.scenario.trajectory import Trajectory

    first, shape = int(obstacles.first_step[i]), obstacles.shapes[i]
    if not obstacles.static[i]:
        shape = _without_offsets(shape)
    shape = _commonroad_shape(shape)
    kind, number = ObstacleType(str(obstacles.categories[i])), int(obstacles.ids[i])
    x, y, heading = obstacles.poses[i, 0]
    initial = InitialState(
        position=np.array([x, y]),
        orientation=float(heading),
        velocity=float(obstacles.speeds[i, 0]),
        time_step=first,
    )
    if obstacles.static[i]:
        return StaticObstacle(number, kind, shape, initial)
    states = [
        KSState(
            position=obstacles.poses[i, t, :2].copy(),
            orientation=float(obstacles.poses[i, t, 2]),
            velocity=float(obstacles.speeds[i, t]),
            steering_angle=0.0,
            time_step=first + t,
        )
        for t in range(1, int(obstacles.steps[i]))
    ]
    prediction = TrajectoryPrediction(Trajectory(first + 1, states), shape) if states else None
    return DynamicObstacle(number, kind, shape, initial, prediction)
