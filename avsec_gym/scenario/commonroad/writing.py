"""Planning scenarios to CommonRoad XML.

What is written is read back bit for bit.  Only the rectangles and discs of moving obstacles that
lie off the obstacle's origin become polygons, because commonroad-io writes them without their
place.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import Any

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.commonroad.format import MARK, import_quietly, points_of
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, Shape
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.write_errors import naming

_DECIMALS = 30
"""Enough for every double that is not denormally small."""


def write_commonroad(
    scenario: PlanningScenario, path: str | Path, *, overwrite: bool = False
) -> None:
    """Write a scenario as CommonRoad 2020a XML.

    Args:
        scenario: Scenario to write.
        path: Path of the file; its folder is made if need be.
        overwrite: Whether a file that is there is replaced.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    import_quietly()
    from commonroad.common.file_writer import CommonRoadFileWriter, OverwriteExistingFile
    from commonroad.scenario.scenario import Location, Tag
    from lxml.etree import LxmlError  # type: ignore[import-untyped]

    notes: dict[str, Any] = {"id": scenario.id}
    if scenario.road_type:
        notes["road_type"] = str(scenario.road_type)
    if scenario.intention:
        notes["intention"] = str(scenario.intention)
    if scenario.start.steering_angle:
        notes["steering_angle"] = scenario.start.steering_angle
    document, problems = to_commonroad(scenario)
    highway = scenario.road_type == RoadType.HIGHWAY
    with (
        naming(Path(gettempdir()), LxmlError),
        TemporaryDirectory(prefix="avsec-") as folder,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        own = Path(folder) / "scenario.xml"
        CommonRoadFileWriter(
            document,
            problems,
            author="avsec-gym",
            affiliation="avsec-gym",
            source=MARK + json.dumps(notes, sort_keys=True),
            tags={Tag.HIGHWAY if highway else Tag.URBAN},
            location=Location(),  # That of no place; left out, commonroad-io warns of it.
            decimal_precision=_DECIMALS,
        ).write_to_file(str(own), OverwriteExistingFile.ALWAYS)
        write_bytes(path, own.read_bytes(), overwrite=overwrite)


def to_commonroad(scenario: PlanningScenario) -> tuple[Any, Any]:
    """The scenario as commonroad-io's ``Scenario`` and ``PlanningProblemSet``."""
    import_quietly()
    from commonroad.planning.planning_problem import PlanningProblem, PlanningProblemSet
    from commonroad.scenario.lanelet import LaneletNetwork
    from commonroad.scenario.scenario import Scenario, ScenarioID
    from commonroad.scenario.state import InitialState

    document = Scenario(scenario.dt, ScenarioID.from_benchmark_id("ZAM_Avsec-1_1_T-1", "2020a"))
    lanelets = [_commonroad_lanelet(lanelet) for lanelet in scenario.road.lanelets]
    document.add_objects(LaneletNetwork.create_from_lanelet_list(lanelets))
    for i in range(len(scenario.obstacles)):
        document.add_objects(_commonroad_obstacle(scenario.obstacles, i))
    # The planning problem, under the first number that is free.
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
        _commonroad_goals(scenario.goals),
    )
    return document, PlanningProblemSet([problem])


def _commonroad_lanelet(lanelet: Lanelet) -> Any:
    """Its bounds are paired point by point.

    Raises:
        DataError: One bound has more points than the other.
    """
    from commonroad.scenario.lanelet import Lanelet as CommonRoadLanelet
    from commonroad.scenario.lanelet import LaneletType

    left, right = np.array(lanelet.left), np.array(lanelet.right)
    if left.shape != right.shape:
        raise DataError(
            f"lanelet {lanelet.id} has {len(left)} points on its left bound and {len(right)}"
            " on its right; CommonRoad pairs them.",
            remedy="Sample both bounds equally often.",
        )
    beside_left = lanelet.adjacent_left or (None, None)
    beside_right = lanelet.adjacent_right or (None, None)
    return CommonRoadLanelet(
        left,
        0.5 * (left + right),
        right,
        lanelet.id,
        predecessor=list(lanelet.predecessors),
        successor=list(lanelet.successors),
        adjacent_left=beside_left[0],
        adjacent_left_same_direction=beside_left[1],
        adjacent_right=beside_right[0],
        adjacent_right_same_direction=beside_right[1],
        lanelet_type={LaneletType(name) for name in lanelet.types},
    )


def _commonroad_goals(goals: Sequence[Goal]) -> Any:
    """The goal region: a state for each goal, any of which may be reached."""
    from commonroad.common.util import AngleInterval, Interval
    from commonroad.planning.goal import GoalRegion
    from commonroad.scenario.state import CustomState

    states, of_lanelets = [], {}
    for i, goal in enumerate(goals):
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
        states.append(CustomState(**state))
    return GoalRegion(states, of_lanelets or None)


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
    return Polygon(points_of(shape.polygon().exterior.coords)[:-1])


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
