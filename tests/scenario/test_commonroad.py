"""CommonRoad XML: lossless both ways, and clear about what is broken."""

from __future__ import annotations

import logging
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avsec_gym.errors import DataError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.commonroad import read_commonroad, write_commonroad
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle

numbers = st.floats(-1000, 1000).map(lambda value: value if abs(value) > 1e-9 else 0.0)
angles = st.floats(-3.1, 3.1).map(lambda value: value if abs(value) > 1e-9 else 0.0)
lengths = st.floats(0.1, 50)
speeds = st.floats(0, 40).map(lambda value: value if value > 1e-9 else 0.0)

rectangles = st.builds(Rectangle, lengths, lengths, numbers, numbers, angles)
discs = st.builds(Disc, lengths, numbers, numbers)


@st.composite
def polygons(draw: st.DrawFn) -> Polygon:
    """Clockwise, as commonroad-io turns every polygon."""
    radii = draw(st.lists(st.floats(1, 5), min_size=3, max_size=7))
    turn = -2 * np.pi * np.arange(len(radii)) / len(radii)
    return Polygon(
        tuple(
            (round(float(r * np.cos(a)), 12), round(float(r * np.sin(a)), 12))
            for r, a in zip(radii, turn, strict=True)
        )
    )


simple = st.one_of(rectangles, discs, polygons())
obstacle_shapes = st.one_of(
    simple, st.builds(Group, st.lists(simple, min_size=2, max_size=3).map(tuple))
)

# commonroad-io writes a moving obstacle's rectangles and discs without their place.
plain = st.one_of(st.builds(Rectangle, lengths, lengths), st.builds(Disc, lengths), polygons())
moving_shapes = st.one_of(
    plain, st.builds(Group, st.lists(plain, min_size=2, max_size=3).map(tuple))
)


@st.composite
def obstacles(draw: st.DrawFn) -> Obstacles:
    """Standing ones first, as commonroad-io lists them."""
    static = sorted(draw(st.lists(st.booleans(), max_size=4)), reverse=True)
    count = len(static)
    if not count:
        return Obstacles.none()
    steps = np.array([1 if s else draw(st.integers(1, 4)) for s in static])
    longest = int(steps.max())
    poses, speed = np.zeros((count, longest, 3)), np.zeros((count, longest))
    for i in range(count):
        for t in range(longest):
            last = t >= steps[i]
            poses[i, t] = poses[i, t - 1] if last else [draw(numbers), draw(numbers), draw(angles)]
            speed[i, t] = speed[i, t - 1] if last else draw(speeds)
    return Obstacles(
        ids=np.arange(count) + 50,
        categories=np.array(
            [draw(st.sampled_from(["car", "parkedVehicle", "truck"])) for _ in static]
        ),
        shapes=tuple(draw(obstacle_shapes if s else moving_shapes) for s in static),
        poses=poses,
        speeds=speed,
        steps=steps,
        first_step=np.array([0 if s else draw(st.integers(0, 5)) for s in static]),
        static=np.array(static),
    )


intervals = st.tuples(st.floats(-1.5, 0), st.floats(0.1, 1.5)).map(
    lambda pair: tuple(value if abs(value) > 1e-9 else 0.0 for value in pair)
)
goals = st.builds(
    Goal,
    steps=st.tuples(st.integers(0, 20), st.integers(21, 60)),
    region=st.one_of(st.none(), st.lists(simple, min_size=1, max_size=3).map(tuple)),
    heading=st.one_of(st.none(), intervals),
    velocity=st.one_of(st.none(), st.tuples(speeds, speeds).map(lambda v: tuple(sorted(v)))),
)
scenarios = st.builds(
    PlanningScenario,
    id=st.text(min_size=1, max_size=20, alphabet="abc 0_-äß\"<&>'"),
    start=st.builds(EgoState, numbers, numbers, speeds, angles, angles, st.integers(0, 10)),
    goals=st.lists(goals, min_size=1, max_size=3).map(tuple),
    road=st.builds(lambda n: Road(straight_lanes(n, 3.5, -10.1, 60.3)), st.sampled_from([1, 3])),
    obstacles=obstacles(),
    dt=st.sampled_from([0.1, 0.04, 0.2]),
    road_type=st.one_of(st.none(), st.sampled_from(RoadType)),
    intention=st.one_of(st.none(), st.sampled_from(Intention)),
)


def assert_equal(one: PlanningScenario, two: PlanningScenario) -> None:
    empty = Obstacles.none()
    assert replace(one, obstacles=empty) == replace(two, obstacles=empty) or (
        (one.id, one.start, one.goals, one.road, one.dt, one.road_type, one.intention)
        == (two.id, two.start, two.goals, two.road, two.dt, two.road_type, two.intention)
    )
    assert one.obstacles.shapes == two.obstacles.shapes
    for name in ("ids", "categories", "poses", "speeds", "steps", "first_step", "static"):
        np.testing.assert_array_equal(
            getattr(one.obstacles, name), getattr(two.obstacles, name), err_msg=name
        )


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(scenario=scenarios)
def test_what_is_written_is_read(tmp_path: Path, scenario: PlanningScenario) -> None:
    path = tmp_path / "scenario.xml"
    write_commonroad(scenario, path, overwrite=True)
    assert_equal(read_commonroad(path), scenario)
    assert [file.name for file in tmp_path.iterdir()] == ["scenario.xml"]


def test_moving_shapes_off_the_origin_keep_their_area(
    scenario: PlanningScenario, tmp_path: Path
) -> None:
    shapes = (
        Rectangle(4.0, 2.0),
        Group((Rectangle(4.0, 2.0, 1.0, 0.5, 0.3), Disc(0.8, -2.0, 0.1))),
    )
    scenario = replace(scenario, obstacles=replace(scenario.obstacles, shapes=shapes))
    write_commonroad(scenario, tmp_path / "x.xml")
    again = read_commonroad(tmp_path / "x.xml")
    for one, two in zip(scenario.obstacles.polygons(3), again.obstacles.polygons(3), strict=True):
        assert one.symmetric_difference(two).area < 1e-9


def test_every_lane_detail_survives(tmp_path: Path) -> None:
    lanes = (
        Lanelet(1, ((0, 3.5), (10, 3.6)), ((0, 0.1), (10, 0.2)), successors=(2,), types=("urban",)),
        Lanelet(
            2,
            ((10, 3.6), (20, 3.5)),
            ((10, 0.2), (20, 0.1)),
            predecessors=(1,),
            adjacent_left=(3, False),
            types=("busLane", "urban"),
        ),
        Lanelet(3, ((20, 3.5), (10, 3.6)), ((20, 7), (10, 7)), adjacent_left=(2, False)),
    )
    lanes = tuple(
        replace(
            lane,
            left=tuple((float(x), float(y)) for x, y in lane.left),
            right=tuple((float(x), float(y)) for x, y in lane.right),
        )
        for lane in lanes
    )
    scenario = PlanningScenario("lanes", EgoState(), (Goal((0, 5)),), Road(lanes))
    write_commonroad(scenario, tmp_path / "lanes.xml")
    assert read_commonroad(tmp_path / "lanes.xml").road.lanelets == lanes


def test_references_to_lanelets_that_the_file_lacks_are_left_out(tmp_path: Path) -> None:
    road = Road(straight_lanes(3))
    path = tmp_path / "lanes.xml"
    write_commonroad(PlanningScenario("lanes", EgoState(), (Goal((0, 5)),), road), path)
    text = path.read_text()
    assert text.count('<adjacentRight ref="1"') == 1
    more = '<predecessor ref="150000000"/><successor ref="7"/><adjacentRight ref="150000000"'
    path.write_text(text.replace('<adjacentRight ref="1"', more))
    first, second, third = read_commonroad(path).road.lanelets
    assert (first, third) == (road.lanelets[0], road.lanelets[2])
    assert second == replace(road.lanelets[1], adjacent_right=None)


def test_a_goal_given_as_lanelets(tmp_path: Path) -> None:
    """Read as their areas, and written as lanelets again."""
    road = Road(straight_lanes(3))
    path = tmp_path / "scenario.xml"
    write_commonroad(PlanningScenario("x", EgoState(), (Goal((0, 5)),), road), path)
    text = path.read_text()
    assert "<position>" in text
    path.write_text(
        re.sub(
            r"(<goalState>.*?</time>)",
            r'\1<position><lanelet ref="2"/><lanelet ref="3"/></position>',
            text,
            flags=re.S,
        )
    )
    scenario = read_commonroad(path)
    (goal,) = scenario.goals
    assert goal.lanelets == (2, 3)
    assert goal.region is not None
    assert [shape.polygon().area for shape in goal.region] == pytest.approx([490, 490])
    write_commonroad(scenario, tmp_path / "again.xml")
    assert '<lanelet ref="3"/>' in (tmp_path / "again.xml").read_text()
    assert read_commonroad(tmp_path / "again.xml").goals == scenario.goals


@pytest.fixture
def scenario() -> PlanningScenario:
    return PlanningScenario(
        "simple",
        EgoState(velocity=6.0),
        (Goal((4, 30), (Rectangle(5.0, 3.5, 15.0, 0.0),), (-0.5, 0.5), (6.0, 8.0)),),
        Road(straight_lanes(3)),
        Obstacles.rectangles(
            np.array([[20.0, 0, 0], [30.0, 3.5, 0]]),
            np.array([4.0, 4.0]),
            np.array([2.0, 2.0]),
            np.array([0.0, 7.0]),
            last_step=5,
        ),
    )


@pytest.fixture
def file(scenario: PlanningScenario, tmp_path: Path) -> Path:
    write_commonroad(scenario, tmp_path / "simple.xml")
    return tmp_path / "simple.xml"


def test_nothing_is_printed(
    scenario: PlanningScenario, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nor logged: a caller without a log would see it on standard error."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(logging.getLogger(), "handlers", [])
        write_commonroad(scenario, tmp_path / "free.xml")
        read_commonroad(tmp_path / "free.xml")
    assert capfd.readouterr() == ("", "")


def test_nothing_is_overwritten_unasked(scenario: PlanningScenario, file: Path) -> None:
    before = file.read_bytes()
    other = replace(scenario, id="other")
    with pytest.raises(DataError, match="exists"):
        write_commonroad(other, file)
    assert file.read_bytes() == before
    write_commonroad(other, file, overwrite=True)
    assert read_commonroad(file).id == "other"


def test_bounds_that_commonroad_cannot_pair(scenario: PlanningScenario, tmp_path: Path) -> None:
    lane = Lanelet(7, ((0.0, 1.0), (5.0, 1.0), (9.0, 1.0)), ((0.0, 0.0), (9.0, 0.0)))
    with pytest.raises(DataError, match="lanelet 7 has 3 points"):
        write_commonroad(replace(scenario, road=Road((lane,))), tmp_path / "x.xml")
    assert not list(tmp_path.glob("x*"))


SET_PREDICTION = """<occupancySet><occupancy><shape><circle><radius>1.0</radius></circle></shape>
<time><exact>1</exact></time></occupancy></occupancySet>"""

BROKEN = {
    "truncated": (r"(?s)^(.{3000}).*", r"\1"),
    "empty": (r"(?s).*", ""),
    "not XML": (r"(?s).*", "Car 0 0 0 1 2 3"),
    "another XML": (r"(?s).*", "<a><b/></a>"),
    "no planning problem": (r"(?s)<planningProblem.*</planningProblem>", ""),
    "no goal": (r"(?s)<goalState>.*</goalState>", ""),
    "goal without time": (r"(?s)(<goalState>\s*)<time>.*?</time>", r"\1"),
    "no initial state": (r"(?s)(<planningProblem[^>]*>\s*)<initialState>.*?</initialState>", r"\1"),
    "no start velocity": (
        r"(?s)(<planningProblem.*?)<velocity>.*?</velocity>(.*?</initialState>)",
        r"\1\2",
    ),
    "no start position": (
        r"(?s)(<planningProblem.*?)<position>.*?</position>(.*?</initialState>)",
        r"\1\2",
    ),
    "a word for a number": (r"(?s)(<leftBound>\s*<point>\s*<x>)[^<]*", r"\1far"),
    "not finite": (r"(?s)(<planningProblem.*?<x>)[^<]*", r"\1nan"),
    "infinite obstacle": (r"(?s)(<staticObstacle.*?<x>)[^<]*", r"\g<1>inf"),
    "set-based prediction": (r"(?s)<trajectory>.*</trajectory>", SET_PREDICTION),
    "obstacle without a shape": (r"(?s)(<staticObstacle.*?)<shape>.*?</shape>", r"\1"),
    "a state is missing": (r"(?s)<state>((?!<state>).)*<exact>3</exact>.*?</state>", ""),
    "uncertain obstacle": (
        r"(?s)(<dynamicObstacle.*?<position>).*?</position>",
        r"\1<circle><radius>1.0</radius><center><x>3.0</x><y>0.0</y></center></circle></position>",
    ),
    "unknown lanelet": (
        r"(?s)(<goalState>.*?<position>).*?</position>",
        r'\1<lanelet ref="99"/></position>',
    ),
    "two of one id": (r'<lanelet id="2">', '<lanelet id="1">'),
    "strange version": (r'commonRoadVersion="2020a"', 'commonRoadVersion="1999"'),
    "no time step": (r'timeStepSize="[^"]*"', ""),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_are_named(file: Path, case: str) -> None:
    pattern, replacement = BROKEN[case]
    text = file.read_text()
    broken = re.sub(pattern, replacement, text, count=1)
    assert broken != text
    file.write_text(broken)
    with pytest.raises(DataError) as caught:
        read_commonroad(file)
    assert str(file) in str(caught.value)
    assert caught.value.remedy


def test_missing_file_folder_and_problem(file: Path) -> None:
    for path in (file.with_name("absent.xml"), file.parent):
        with pytest.raises(DataError, match=r"no such file|not a file"):
            read_commonroad(path)
    with pytest.raises(DataError, match=r"planning problem 5; it has \[100\]"):
        read_commonroad(file, problem_id=5)
    assert read_commonroad(file, problem_id=100).id == "simple"


def test_notes_of_others_are_ignored(file: Path) -> None:
    file.write_text(re.sub(r'source="[^"]*"', 'source="avsec-gym {broken"', file.read_text()))
    assert read_commonroad(file).id == "simple"


@pytest.mark.slow
def test_shared_files(shared: Path) -> None:
    files = sorted((shared / "planning").glob("scenarios*/*.xml"))
    assert len(files) == 36
    for path in files:
        scenario = read_commonroad(path)
        assert scenario.id == path.stem
        assert len(scenario.road.lanelets) >= 3
        assert len(scenario.road.edges) == 4
        assert scenario.goals[0].region
