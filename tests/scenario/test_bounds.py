"""Every number of a planning problem, given as none that a problem can have."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import DataError, PlanningError
from avsec_gym.scenario.commonroad import read_commonroad, write_commonroad
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle
from tests.strange_values import STRANGE

NEVER = (math.nan, math.inf, -math.inf, 1e300, -1e300)
ABOVE_ZERO = {"length", "width", "radius", "dt"}
NOT_BELOW_ZERO = {"step", "steps", "first_step"}
NUMBERS = {"float", "int", "Floats", "tuple[int, int]", "NDArray[np.int64]"}
"""Annotations of fields that hold numbers; None may stand beside them."""
COUNTED = {"ids", "id", "steps of Obstacles", "adjacent_left", "adjacent_right"}
"""Numbers that count or name things."""

OBJECTS: tuple[Any, ...] = (
    EgoState(1.0, 2.0, 3.0, 0.4, 0.1, 2),
    Goal((3, 9), (Disc(1.0),), (-0.5, 0.5), (2.0, 4.0)),
    Rectangle(4.0, 2.0, 1.0, 1.0, 0.3),
    Disc(1.0, 2.0, 3.0),
    Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
    Lanelet(1, ((0.0, 1.0), (9.0, 1.0)), ((0.0, -1.0), (9.0, -1.0))),
    Obstacles.rectangles(np.array([[9.0, 1.0, 0.1]]), np.ones(1), np.ones(1), np.ones(1)),
    PlanningScenario("some", EgoState(), (Goal((0, 3)),)),
)


def replaced(value: Any, bad: float) -> Iterator[Any]:
    """Copies of a number, tuple or array in which one number is bad."""
    if isinstance(value, np.ndarray):
        for index in np.ndindex(value.shape):
            array = value.astype(float)
            array[index] = bad
            yield array
    elif isinstance(value, tuple):
        for i, member in enumerate(value):
            for changed in replaced(member, bad):
                yield (*value[:i], changed, *value[i + 1 :])
    else:
        yield bad


def numeric_fields() -> Iterator[tuple[Any, str]]:
    for owner in OBJECTS:
        for field in fields(owner):
            kind = str(field.type).removesuffix(" | None")
            name = f"{field.name} of {type(owner).__name__}"
            if (kind in NUMBERS or "float" in kind) and not {field.name, name} & COUNTED:
                yield owner, field.name


def test_the_fields_are_all_there() -> None:
    assert len(list(numeric_fields())) == 24


@pytest.mark.parametrize(
    ("owner", "name"),
    [pytest.param(*case, id=f"{type(case[0]).__name__}.{case[1]}") for case in numeric_fields()],
)
def test_every_number_of_the_objects(owner: Any, name: str) -> None:
    bad = [*NEVER]
    bad += [-4.0, 0.0] if name in ABOVE_ZERO else [-1.0] if name in NOT_BELOW_ZERO else []
    for number in bad:
        for value in replaced(getattr(owner, name), number):
            with pytest.raises(PlanningError, match="expected"):
                replace(owner, **{name: value})


def written(folder: Path) -> Path:
    """A file with an obstacle of every kind and shape and all that a goal can ask."""
    moving = Obstacles.rectangles(
        np.array([[20.0, 0, 0], [30.0, 3, 0.2]]), np.ones(2), np.ones(2), np.array([3.0, 0.0]),
        last_step=4,
    )  # fmt: skip
    scenario = PlanningScenario(
        "all",
        EgoState(velocity=6.0),
        (
            Goal((4, 30), (Rectangle(5.0, 3.5, 15.0, 3.5, 0.1),), (-0.5, 0.5), (6.0, 8.0)),
            Goal((4, 30), (Disc(2.0, 15.0, 0.0),)),
        ),
        Road(straight_lanes(1)),
        replace(moving, shapes=(Rectangle(4.0, 2.0), Disc(1.0, 0.5, 0.5))),
    )
    path = folder / "all.xml"
    write_commonroad(scenario, path)
    return path


def values(root: ElementTree.Element) -> Iterator[tuple[str, Callable[[str], None]]]:
    """Every number in a file, and how to change it."""
    yield "timeStepSize", lambda text: root.set("timeStepSize", text)
    for owner in root:
        if owner.tag in ("location", "scenarioTags"):
            continue
        parents = {child: parent for parent in owner.iter() for child in parent}
        for element in owner.iter():
            if len(element) == 0 and re.fullmatch(
                r"-?[\d.]+(e-?\d+)?", (element.text or "").strip()
            ):
                parent = parents[element].tag
                name = element.tag if element.tag[:5] not in ("exact", "inter") else parent
                yield name, lambda text, element=element: setattr(element, "text", text)  # type: ignore[misc]


def test_every_number_of_a_file(tmp_path: Path) -> None:
    path = written(tmp_path)
    read_commonroad(path)
    root = ElementTree.parse(path).getroot()
    names = [name for name, _ in values(root)]
    asked = {"length", "width", "radius", "orientation", "velocity", "time", "x", "y"}
    assert asked | {"timeStepSize"} <= set(names)
    seen: set[str] = set()
    for i, name in enumerate(names):
        if names.count(name) > 3 and i % 5 and name in seen:
            continue  # Points of bounds and states are many and alike.
        seen.add(name)
        bad = ["nan", "inf", "-inf", "1e300", "", "word"]
        bad += ["-4", "0"] if name in ABOVE_ZERO | {"timeStepSize"} else []
        bad += ["-1"] if name == "time" else []
        for text in bad:
            changed = ElementTree.parse(path).getroot()
            list(values(changed))[i][1](text)
            broken = tmp_path / "broken.xml"
            ElementTree.ElementTree(changed).write(broken)
            with pytest.raises(DataError, match=rf"broken\.xml:\d+: .*{name}"):
                read_commonroad(broken)


@pytest.mark.parametrize(
    "declaration",
    [
        '<!DOCTYPE commonRoad [<!ENTITY a "6.0">]>',
        "<!DOCTYPE commonRoad>",
        '<!DOCTYPE commonRoad SYSTEM "http://localhost/x.dtd">',
    ],
)
def test_declarations_are_refused(declaration: str, tmp_path: Path) -> None:
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r"<commonRoad", f"{declaration}\n<commonRoad", text, count=1))
    with pytest.raises(DataError, match=r"all\.xml:\d+: .*declares"):
        read_commonroad(path)


@pytest.mark.parametrize("bad", ["6", 1j, np.ones(2), [1.0], {}], ids=repr)
def test_what_is_no_number_is_no_number_of_a_problem(bad: Any) -> None:
    """Comparing it would be an error of Python's, which names nothing."""
    for name in ("x", "y", "velocity", "heading", "steering_angle", "step"):
        with pytest.raises(PlanningError, match=r"expected a (whole )?number"):
            EgoState(**{name: bad})
    with pytest.raises(PlanningError, match="length"):
        Rectangle(bad, 2.0)
    with pytest.raises(PlanningError, match="time window is no number"):
        Goal((0, bad))  # type: ignore[arg-type]


def test_numpy_s_numbers_are_numbers() -> None:
    assert EgoState(np.float32(1.0), np.int64(2), np.float64(3.0), step=np.int64(4)).y == 2  # type: ignore[arg-type]


def misfits(array: np.ndarray) -> Iterator[Any]:
    """An array with a row too few, a row too many, an axis too many, of another kind, as a list."""
    yield array[:-1]
    yield np.concatenate([array, array[:1]])
    yield array[..., None]
    yield array.astype("datetime64[s]") if array.dtype.kind in "iu" else array.astype(bytes)
    yield array.tolist()


@pytest.mark.parametrize("name", [field.name for field in fields(Obstacles)])
def test_arrays_of_obstacles_that_do_not_belong_together(name: str) -> None:
    """A shape too few was an obstacle that the planner drove through."""
    obstacles = Obstacles.rectangles(
        np.array([[9.0, 1.0, 0.1], [20.0, 0.0, 0.0]]), np.ones(2), np.ones(2), np.ones(2),
        last_step=3,
    )  # fmt: skip
    given = getattr(obstacles, name)
    bad = misfits(given) if isinstance(given, np.ndarray) else (given[:-1], given + given, [None])
    for value in bad:
        with pytest.raises(PlanningError, match=r"expected|shapes"):
            replace(obstacles, **{name: value})


@pytest.mark.parametrize("steps", [0, -5, 5])
def test_no_more_states_of_an_obstacle_are_known_than_it_has_poses(steps: int) -> None:
    """The search would read what lies behind the array."""
    obstacles = Obstacles.rectangles(
        np.array([[9.0, 1.0, 0.1]]), np.ones(1), np.ones(1), np.ones(1), last_step=3
    )
    with pytest.raises(PlanningError, match="whole number from 1 to 4"):
        replace(obstacles, steps=np.array([steps]))


@pytest.mark.parametrize(
    "given",
    [{"length": np.ones(1)}, {"width": np.ones(3)}, {"speed": np.ones(1)}, {"last_step": -1},
     {"last_step": 10**9}, {"dt": -0.1}],
    ids=str,
)  # fmt: skip
def test_rectangles_of_arrays_that_do_not_fit(given: dict[str, Any]) -> None:
    fit = {"length": np.ones(2), "width": np.ones(2), "speed": np.ones(2)}
    with pytest.raises(PlanningError, match="expected"):
        Obstacles.rectangles(np.zeros((2, 3)), **(fit | given))


@pytest.mark.parametrize(
    ("name", "given"),
    [
        *((name, bad) for name in ("steps", "heading", "velocity") for bad in ((4, 3), (4,), ())),
        *((name, (3, 4, 5)) for name in ("steps", "heading", "velocity")),
        ("steps", (3.0, 4.5)),
        ("region", ()),
        ("region", (None,)),
        ("region", Disc(1.0)),
    ],
)
def test_goals_that_no_state_can_meet(name: str, given: Any) -> None:
    """A search that is exhausted would vouch for what the goal never asked."""
    with pytest.raises(PlanningError, match=r"expected|ends before it begins"):
        replace(Goal((3, 9)), **{name: given})


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((), ()),
        (((0, 1),), ((0, -1),)),
        (((0, 1, 0), (9, 1, 0)), ((0, -1, 0), (9, -1, 0))),
    ],
)
def test_bounds_of_lanelets_that_are_no_lines(left: Any, right: Any) -> None:
    with pytest.raises(PlanningError, match=r"two points \(x, y\)"):
        Lanelet(1, left, right)


def test_a_road_without_an_area() -> None:
    line = ((0.0, 1.0), (9.0, 1.0))
    with pytest.raises(PlanningError, match="no area"):
        _ = Road((Lanelet(1, line, line),)).closed_edges


@pytest.mark.parametrize("shapes", [(), (None,), (Group((Disc(1.0),)),)], ids=repr)
def test_groups_hold_simple_shapes(shapes: Any) -> None:
    """A group of nothing is an obstacle that is nowhere."""
    with pytest.raises(PlanningError, match="one or more"):
        Group(shapes)


@pytest.mark.parametrize("goals", [[Goal((3, 9))], Goal((3, 9)), (None,)], ids=repr)
def test_goals_are_a_tuple(goals: Any) -> None:
    with pytest.raises(PlanningError, match="a tuple of Goal"):
        PlanningScenario("some", EgoState(), goals)


def test_intervals_of_a_file_that_end_before_they_begin(tmp_path: Path) -> None:
    path = written(tmp_path)
    tree = ElementTree.parse(path)
    intervals = [each for each in tree.getroot().iter() if each.find("intervalStart") is not None]
    assert {each.tag for each in intervals} == {"time", "orientation", "velocity"}
    for number in range(len(intervals)):
        tree = ElementTree.parse(path)
        each = [e for e in tree.getroot().iter() if e.find("intervalStart") is not None][number]
        first, last = (each.find(name) for name in ("intervalStart", "intervalEnd"))
        assert first is not None
        assert last is not None
        first.text, last.text = last.text, first.text
        tree.write(tmp_path / "broken.xml")
        with pytest.raises(DataError, match=r"broken\.xml"):
            read_commonroad(tmp_path / "broken.xml")


def test_rectangles_of_lists_are_those_of_arrays() -> None:
    rows = [[9, 1, 0.1], [20, 0, 0]], [4, 4.5], [2, 1.8], [0, 3]
    listed = Obstacles.rectangles(*rows, last_step=3)  # type: ignore[arg-type]
    arrays = Obstacles.rectangles(*(np.array(row, float) for row in rows), last_step=3)
    for field in fields(Obstacles):
        np.testing.assert_array_equal(getattr(listed, field.name), getattr(arrays, field.name))
    assert not len(Obstacles.rectangles([], [], []))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["poses", "length", "width", "speed"])
def test_rectangles_of_anything_else_are_refused_by_name(name: str) -> None:
    fit = {"poses": np.zeros((2, 3)), **dict.fromkeys(("length", "width", "speed"), np.ones(2))}
    for value in STRANGE:
        with suppress(PlanningError):
            Obstacles.rectangles(**(fit | {name: value}))
    for value in (5, "ab", ["1", "2"], [None, 1], [[1], [2, 3]], [True, False], np.ones((2, 2))):
        with pytest.raises(PlanningError, match=rf"(?s){name}s? of obstacles .*list of numbers"):
            Obstacles.rectangles(**(fit | {name: value}))


@pytest.mark.parametrize("make", [Polygon, lambda points: Lanelet(1, points, points)])
def test_points_of_anything_else_are_refused(make: Callable[[Any], object]) -> None:
    for value in STRANGE:
        with suppress(PlanningError):
            make(value)
