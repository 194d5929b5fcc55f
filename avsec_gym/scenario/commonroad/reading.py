"""CommonRoad XML to planning scenarios."""

from __future__ import annotations

import warnings
from collections.abc import Container, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import DataError, PlanningError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.commonroad.format import MARK, finite, import_quietly, points_of
from avsec_gym.scenario.commonroad.grammar import check_elements
from avsec_gym.scenario.commonroad.obstacle_forms import as_read, with_named_roles
from avsec_gym.scenario.commonroad.quantities import check_numbers
from avsec_gym.scenario.commonroad.words import check_words
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, Shape
from avsec_gym.storage.json_files import parse_json
from avsec_gym.storage.xml_tree import Element, as_bytes, read_plain_xml


def read_commonroad(path: str | Path, problem_id: int | None = None) -> PlanningScenario:
    """Read one planning problem.

    References to lanelets that the file lacks, as a part cut out of a larger map has them, are left
    out.

    Args:
        path: A CommonRoad XML file (format 2018b or 2020a).
        problem_id: Number of the planning problem; None: the file's first one.

    Raises:
        DataError: The file is not CommonRoad XML, or uses something that cannot be planned with.
    """
    import_quietly()
    from commonroad.common.file_reader import CommonRoadFileReader
    from commonroad.common.util import FileFormat

    # The text first, then commonroad-io, which trusts it and gets nothing else.
    path = Path(path)
    root = with_named_roles(_checked_root(read_plain_xml(path)))
    check_elements(root)
    check_numbers(root)
    check_words(root)
    _check_ids(root)
    content = as_bytes(as_read(root))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scenario, problems = CommonRoadFileReader(content, FileFormat.XML).open()
    except Exception as error:
        raise DataError(
            f"this is not a CommonRoad file that commonroad-io can read"
            f" ({type(error).__name__}: {error}).",
            path=path,
            remedy="Write CommonRoad 2020a XML, with at least one planningProblem.",
        ) from error
    problem = _asked_problem(problems.planning_problem_dict, problem_id, path)
    # What the format has no place for.
    notes = _notes(scenario.source)
    # Our classes are stricter: what they refuse is an error of the file.
    try:
        start = problem.initial_state
        return PlanningScenario(
            id=notes.get("id", path.stem),
            start=EgoState(
                x=finite(start.position[0]),
                y=finite(start.position[1]),
                velocity=finite(start.velocity),
                heading=finite(start.orientation),
                steering_angle=finite(notes.get("steering_angle", 0.0)),
                step=int(start.time_step),
            ),
            goals=_goals(problem.goal),
            road=_road(scenario.lanelet_network.lanelets),
            obstacles=_obstacles(scenario),
            dt=float(scenario.dt),
            road_type=RoadType(notes["road_type"]) if "road_type" in notes else None,
            intention=Intention(notes["intention"]) if "intention" in notes else None,
        )
    except PlanningError as error:
        raise DataError(str(error), path=path, remedy=_IN_BOUNDS) from error
    except (TypeError, AttributeError, ValueError, IndexError) as error:
        raise DataError(
            f"a part of the scenario cannot be planned with ({error}).",
            path=path,
            remedy="States need exact, finite values; obstacles need a shape and a trajectory.",
        ) from error


def _asked_problem(known: Mapping[int, Any], asked: int | None, path: Path) -> Any:
    """The planning problem of that number; of None, the first."""
    if not known or (asked is not None and asked not in known):
        raise DataError(
            "the file does not hold any planning problem."
            if asked is None
            else f"the file does not hold the planning problem {asked}; it has {sorted(known)}.",
            path=path,
            remedy="Add a planningProblem element, or name one that is there.",
        )
    return known[next(iter(known)) if asked is None else asked]


_IN_BOUNDS = "Correct the number; lengths are in m, angles in rad, times in steps."


def _notes(source: str | None) -> dict[str, Any]:
    if not source or not source.startswith(MARK):
        return {}
    try:
        notes = parse_json(source[len(MARK) :])
    except ValueError:
        return {}
    return notes if isinstance(notes, dict) else {}


def _checked_root(root: Element) -> Element:
    if root.name != "commonRoad":
        root.refuse(
            f"the outermost element is {root.tag}.", "Write CommonRoad 2020a XML, in <commonRoad>."
        )
    return root


def _check_ids(root: Element) -> None:
    seen: dict[str, Element] = {}
    for child in root.children:
        id = child.attributes.get("id")
        if id is not None and seen.setdefault(id, child) is not child:
            child.refuse(
                f"a second element has the id {id[:40]}; the first is in line {seen[id].line}.",
                "Give each an id of its own.",
            )


def _road(lanelets: list[Any]) -> Road:
    known = {int(lanelet.lanelet_id) for lanelet in lanelets}
    return Road(tuple(_lanelet(lanelet, known) for lanelet in lanelets))


def _lanelet(lanelet: Any, known: Container[int]) -> Lanelet:
    """A lanelet with its references to lanelets that are there."""

    def neighbour(id: int | None, same: bool | None) -> tuple[int, bool] | None:
        return None if id is None or id not in known else (int(id), bool(same))

    return Lanelet(
        id=int(lanelet.lanelet_id),
        left=points_of(lanelet.left_vertices),
        right=points_of(lanelet.right_vertices),
        predecessors=tuple(id for id in lanelet.predecessor if id in known),
        successors=tuple(id for id in lanelet.successor if id in known),
        adjacent_left=neighbour(lanelet.adj_left, lanelet.adj_left_same_direction),
        adjacent_right=neighbour(lanelet.adj_right, lanelet.adj_right_same_direction),
        types=tuple(sorted({kind.value for kind in lanelet.lanelet_type} - {"unknown"})),
    )


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
                heading=None if heading is None else (finite(heading.start), finite(heading.end)),
                velocity=None
                if velocity is None
                else (finite(velocity.start), finite(velocity.end)),
                lanelets=tuple(lanelets.get(i, ())),
            )
        )
    return tuple(goals)


def _shape(shape: Any) -> Shape:
    from commonroad.geometry import shape as commonroad

    if isinstance(shape, commonroad.Rectangle):
        x, y = (finite(value) for value in shape.center)
        return Rectangle(finite(shape.length), finite(shape.width), x, y, finite(shape.orientation))
    if isinstance(shape, commonroad.Circle):
        return Disc(finite(shape.radius), finite(shape.center[0]), finite(shape.center[1]))
    if isinstance(shape, commonroad.Polygon):
        points = points_of(shape.vertices)
        return Polygon(points[:-1] if points[0] == points[-1] else points)
    if isinstance(shape, commonroad.ShapeGroup):
        return Group(tuple(_shape(part) for part in shape.shapes))  # type: ignore[misc]
    raise TypeError(f"a position given as {type(shape).__name__}")


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
