"""What the planner believes is checked when it is made, and cannot be changed afterwards."""

from __future__ import annotations

import copy
import importlib
import pickle
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pytest

import avsec_gym.scenario
from avsec_gym.boxes import Boxes3D
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.shapes import Disc, Piece, Polygon


def boxes() -> Boxes3D:
    return Boxes3D(
        np.ones((2, 3)), np.ones((2, 3)), np.ones(2), np.ones(2), np.array(["Car", "Van"]),
        np.ones((2, 4)), np.zeros(2), np.zeros(2), np.zeros(2), np.array([True, False]),
    )  # fmt: skip


BELIEVED: dict[str, Callable[[], Any]] = {
    "Boxes3D": boxes,
    "Obstacles": lambda: Obstacles.rectangles(
        np.array([[9.0, 1.0, 0.1]]), np.ones(1), np.ones(1), np.ones(1), last_step=3
    ),
    "Road": lambda: Road(straight_lanes(3)),
    "Road of nothing": Road,
    "Scene": lambda: Scene("000000", boxes(), RoadType.STREET),
    "Piece": lambda: Piece(np.zeros((3, 2)), 0.0),
}


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Every array of a value: its fields, what it works out once, and what these are made of."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for each in value:
            yield from arrays_of(each)
    elif is_dataclass(value):
        kept = {name for name, each in vars(type(value)).items() if type(each) is cached_property}
        for name in kept | {field.name for field in fields(value)}:
            yield from arrays_of(getattr(value, name))


def array_classes() -> Iterator[str]:
    """The dataclasses of `avsec_gym.scenario` that have an array, given or worked out."""
    found = avsec_gym.scenario
    for module in pkgutil.walk_packages(found.__path__, f"{found.__name__}."):
        for name, each in vars(importlib.import_module(module.name)).items():
            if not (is_dataclass(each) and each.__module__ == module.name):
                continue
            kinds = [str(field.type) for field in fields(each)]
            worked_out = [at for at in vars(each).values() if type(at) is cached_property]
            kinds += [str(at.func.__annotations__["return"]) for at in worked_out]
            if any("Floats" in kind or "NDArray" in kind for kind in kinds):
                yield name


def test_every_class_with_an_array_is_asked() -> None:
    asked = set(array_classes())
    assert {"Obstacles", "Road"} <= asked
    assert asked <= set(BELIEVED)


@pytest.mark.parametrize("name", BELIEVED)
def test_no_array_can_be_written_into(name: str) -> None:
    """NaN in a wall's pose made it vanish: "found" straight through it."""
    made = BELIEVED[name]()
    assert list(arrays_of(made))
    copies = made, pickle.loads(pickle.dumps(made)), copy.deepcopy(made)
    for each in copies if name != "Piece" else copies[:1]:
        for array in arrays_of(each):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = array


def test_the_arrays_and_lists_of_the_caller_stay_the_callers() -> None:
    """They can be written into, and change nothing."""
    wall = Obstacles.rectangles([[8, 0, 0]], [4], [3])
    given = {each.name: getattr(wall, each.name) for each in fields(wall)}
    given = {name: each.copy() if name != "shapes" else [*each] for name, each in given.items()}
    line = [[0.0, 1.0], [9.0, 1.0]]
    lane = Lanelet(1, line, np.array(line) - [0, 2])  # type: ignore[arg-type]
    corners, lanes = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), [lane]
    polygon, road = Polygon(corners), Road(lanes)  # type: ignore[arg-type]
    columns = {field.name: np.array(getattr(boxes(), field.name)) for field in fields(Boxes3D)}
    cars, again = Boxes3D(**columns), Obstacles(**given)
    for array in (corners, *columns.values(), *given.values()):
        if isinstance(array, np.ndarray):
            array[...] = np.zeros((), array.dtype)
    given["shapes"].clear()
    line[0][0] = np.nan
    lanes.clear()
    assert again.poses.tolist() == [[[8.0, 0.0, 0.0]]]
    assert len(again) == 1
    assert lane.left == ((0.0, 1.0), (9.0, 1.0))
    assert polygon.vertices == ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    assert road.lanelets == (lane,)
    assert cars.location.tolist() == np.ones((2, 3)).tolist()


def test_a_wall_of_other_places_is_made_by_replacing_them() -> None:
    """What was written into the array is now given, and checked; the wall holds."""
    wall = Obstacles.rectangles([[8, 0, 0], [8, 3.5, 0], [8, -3.5, 0]], [4] * 3, [3.4] * 3)
    straight_on = PlanningScenario(
        "wall", EgoState(velocity=6.0), (Goal((0, 30), (Disc(2.0, 20.0),)),),
        Road(straight_lanes(3)), wall,
    )  # fmt: skip
    planner = MotionPrimitivePlanner()
    assert not planner.plan(straight_on).found
    aside = replace(wall, poses=wall.poses + np.array([0.0, 50.0, 0.0]))
    assert planner.plan(straight_on.with_obstacles(aside)).found
