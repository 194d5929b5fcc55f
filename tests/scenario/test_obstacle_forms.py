"""Obstacles in the words of one format in files of the other: planned with, or refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.scenario.commonroad import read_commonroad, write_commonroad
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Road, straight_lanes

SCENARIO = PlanningScenario(
    "old",
    EgoState(velocity=6.0),
    (Goal((4, 30)),),
    Road(straight_lanes(3)),
    Obstacles.rectangles(
        np.array([[20.0, 0, 0], [30.0, 3.5, 0]]),
        np.array([4.0, 4.0]),
        np.array([2.0, 2.0]),
        np.array([0.0, 7.0]),
        last_step=3,
    ),
)
WALL = """<environmentObstacle id="77"><type>building</type><shape><rectangle><length>0.5</length>
<width>30</width><orientation>0.2</orientation><center><x>7</x><y>1</y></center></rectangle></shape>
</environmentObstacle>"""
PHANTOM = """<phantomObstacle id="77"><occupancySet><occupancy><shape><circle><radius>1</radius>
</circle></shape><time><exact>1</exact></time></occupancy></occupancySet></phantomObstacle>"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    write_commonroad(SCENARIO, tmp_path / "old.xml")
    return tmp_path / "old.xml"


def with_roles(text: str) -> str:
    """The obstacles as format 2018b writes them."""
    for role in ("static", "dynamic"):
        text = re.sub(rf"<{role}Obstacle([^>]*)>", rf"<obstacle\1><role>{role}</role>", text)
        text = text.replace(f"</{role}Obstacle>", "</obstacle>")
    return text


def change(path: Path, *replaced: tuple[str, str]) -> None:
    text = path.read_text()
    for old, new in replaced:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text)


@pytest.mark.parametrize("version", ["2018b", "2020a"])
@pytest.mark.parametrize("old_words", [True, False])
def test_roles_and_named_obstacles(file: Path, version: str, old_words: bool) -> None:
    """Each format's words in files of each format: the same obstacles."""
    expected = read_commonroad(file).obstacles
    assert len(expected) == 2
    change(file, ('commonRoadVersion="2020a"', f'commonRoadVersion="{version}" tags="urban"'))
    if old_words:
        file.write_text(with_roles(file.read_text()))
    obstacles = read_commonroad(file).obstacles
    assert obstacles.ids.tolist() == expected.ids.tolist()
    assert obstacles.static.tolist() == [True, False]
    np.testing.assert_array_equal(obstacles.poses, expected.poses)
    assert obstacles.shapes == expected.shapes


@pytest.mark.parametrize("version", ["2018b", "2020a"])
def test_a_building_stands_where_its_shape_says(file: Path, version: str, tmp_path: Path) -> None:
    change(
        file,
        ('commonRoadVersion="2020a"', f'commonRoadVersion="{version}" tags="urban"'),
        ("<planningProblem", f"{WALL}<planningProblem"),
    )
    scenario = read_commonroad(file)
    (row,) = np.nonzero(scenario.obstacles.ids == 77)[0]
    assert scenario.obstacles.static[row]
    for step in (0, 50):
        area = scenario.obstacles.polygons(step)[row]
        assert area.area == pytest.approx(15)
        assert area.centroid.coords[0] == pytest.approx((7, 1))
    write_commonroad(scenario, tmp_path / "again.xml")
    again = read_commonroad(tmp_path / "again.xml").obstacles
    assert again.shapes == scenario.obstacles.shapes


def test_what_may_be_anywhere_is_refused(file: Path) -> None:
    text = file.read_text()
    change(file, ("<planningProblem", f"{PHANTOM}<planningProblem"))
    with pytest.raises(DataError, match=r"old\.xml:\d+: <phantomObstacle id='77'> holds places"):
        read_commonroad(file)
    file.write_text(re.sub(r"(?s)<trajectory>.*</trajectory>", "<occupancySet/>", text))
    with pytest.raises(DataError, match=r"old\.xml:\d+: <occupancySet> holds places"):
        read_commonroad(file)


@pytest.mark.parametrize(
    ("role", "message"),
    [("<role>ghost</role>", "role 'ghost'"), ("", "lacks a <role>"),
     ("<role>static</role><role>dynamic</role>", "second <role>")],
)  # fmt: skip
def test_roles_that_are_none(file: Path, role: str, message: str) -> None:
    file.write_text(with_roles(file.read_text()))
    change(file, ("<role>static</role>", role))
    with pytest.raises(DataError, match=message):
        read_commonroad(file)


def test_other_versions(file: Path) -> None:
    change(file, ('commonRoadVersion="2020a"', 'commonRoadVersion="2017a"'))
    with pytest.raises(DataError, match=r"'2017a'.*2018b or 2020a"):
        read_commonroad(file)
