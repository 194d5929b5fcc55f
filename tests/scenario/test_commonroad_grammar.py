"""Every element of a CommonRoad file, where and as often as the format says: else refused."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.scenario.commonroad import read_commonroad, write_commonroad
from avsec_gym.scenario.commonroad.grammar import GRAMMAR
from avsec_gym.scenario.commonroad.words import known_words
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle

TRIANGLE = Polygon(((0.0, 0.0), (0.0, 1.0), (1.0, 0.0)))


@pytest.fixture
def tree(tmp_path: Path) -> ElementTree.Element:
    """A file with each element that is planned with."""
    obstacles = Obstacles.rectangles(
        np.array([[20.0, 0, 0], [30.0, 3.5, 0]]),
        np.array([4.0, 4.0]),
        np.array([2.0, 2.0]),
        np.array([0.0, 7.0]),
        last_step=2,
    )
    scenario = PlanningScenario(
        "all",
        EgoState(velocity=6.0),
        (Goal((4, 30), (Rectangle(5.0, 3.5, 15.0), TRIANGLE), (-0.5, 0.5), (6.0, 8.0)),),
        Road(straight_lanes(3)),
        Obstacles(
            **{
                **vars(obstacles),
                "shapes": (Group((Rectangle(4.0, 2.0), Disc(1.0), TRIANGLE)), Rectangle(4, 2)),
            }
        ),
    )
    write_commonroad(scenario, tmp_path / "all.xml")
    return ElementTree.parse(tmp_path / "all.xml").getroot()


def places(
    root: ElementTree.Element, seen: set[str] | None = None, way: str = ""
) -> Iterator[tuple[str, ElementTree.Element, int]]:
    """Elements that are planned with, one for each way from the root: the way, parent, index."""
    seen = set() if seen is None else seen
    for i, child in enumerate(root):
        if child.tag in ("location", "scenarioTags"):
            continue
        here = f"{way}/{child.tag}"
        if here not in seen:
            seen.add(here)
            yield here, root, i
        yield from places(child, seen, here)


def read(root: ElementTree.Element, folder: Path) -> PlanningScenario:
    path = folder / "changed.xml"
    path.write_bytes(ElementTree.tostring(root))
    return read_commonroad(path)


def each_changed(
    root: ElementTree.Element,
) -> Iterator[tuple[str, ElementTree.Element, list[ElementTree.Element]]]:
    """The way to each element, a copy of the tree, and in it the parent and the element."""
    for number, (way, _, _) in enumerate(places(root)):
        copy = deepcopy(root)
        _, parent, index = list(places(copy))[number]
        yield way, copy, [parent, parent[index]]


def refused(root: ElementTree.Element, folder: Path) -> bool:
    try:
        read(root, folder)
    except DataError as raised:
        error = raised
    else:
        return False
    assert error.remedy
    assert str(folder / "changed.xml") in str(error)
    return True


SEVERAL = {
    "/lanelet/laneletType",
    "/staticObstacle/shape/rectangle",
    "/staticObstacle/shape/circle",
    "/staticObstacle/shape/polygon",
    "/staticObstacle/shape/polygon/point",
    "/dynamicObstacle/shape/rectangle",
    "/planningProblem/goalState",
    "/planningProblem/goalState/position/rectangle",
    "/planningProblem/goalState/position/polygon",
    "/planningProblem/goalState/position/polygon/point",
}
"""What may come twice with the same content."""

OPTIONAL = {
    "/lanelet", "/staticObstacle", "/dynamicObstacle", "/dynamicObstacle/trajectory",
    "/lanelet/laneletType", "/lanelet/adjacentLeft", "/lanelet/adjacentRight",
    "/staticObstacle/shape/rectangle", "/staticObstacle/shape/circle",
    "/staticObstacle/shape/polygon", "/planningProblem/goalState/position/rectangle",
    "/planningProblem/goalState/position/polygon",
}  # fmt: skip
OPTIONAL_ENDS = (
    "rectangle/orientation", "center", "State/velocity", "state/velocity", "goalState/position",
    "goalState/orientation", "goalState/velocity", "lineMarking", "acceleration",
    "yawRate", "slipAngle", "steeringAngle",
    "polygon/point",  # Its first one, which closes the ring.
)  # fmt: skip
"""What need not be there: the ways, or their ends."""


def test_doubled_elements(tree: ElementTree.Element, tmp_path: Path) -> None:
    taken = set()
    for way, root, (parent, element) in each_changed(tree):
        parent.insert(0, deepcopy(element))
        if not refused(root, tmp_path):
            taken.add(way)
    assert taken == SEVERAL


def test_several_shapes_are_one_obstacle(tree: ElementTree.Element, tmp_path: Path) -> None:
    shape = tree.find("dynamicObstacle/shape")
    assert shape is not None
    behind = deepcopy(shape[0])
    centre = ElementTree.SubElement(behind, "center")
    ElementTree.SubElement(centre, "x").text = "-6.0"
    ElementTree.SubElement(centre, "y").text = "0.0"
    shape.append(behind)
    read_back = read(tree, tmp_path).obstacles.shapes[1]
    assert read_back == Group((Rectangle(4.0, 2.0), Rectangle(4.0, 2.0, -6.0)))


def test_misspelt_elements(tree: ElementTree.Element, tmp_path: Path) -> None:
    for way, root, (_, element) in each_changed(tree):
        element.tag += "s"
        assert refused(root, tmp_path), way


def test_missing_elements(tree: ElementTree.Element, tmp_path: Path) -> None:
    passed_over = []
    for way, root, (parent, element) in each_changed(tree):
        parent.remove(element)
        may_lack = way in OPTIONAL or (
            way.endswith(OPTIONAL_ENDS) and way != "/planningProblem/initialState/velocity"
        )
        if not (may_lack or refused(root, tmp_path)):
            passed_over.append(way)
    assert not passed_over


def test_text_among_elements_and_elements_among_text(
    tree: ElementTree.Element, tmp_path: Path
) -> None:
    for way, root, (_, element) in each_changed(tree):
        if len(element):
            element[0].tail = "7"
        else:
            ElementTree.SubElement(element, "b").text = "1"
        assert refused(root, tmp_path), way


@pytest.mark.parametrize("id", ["1.5", "", "x", "9" * 400, "1_0", "٣"])
@pytest.mark.parametrize("place", ["lanelet", "lanelet/adjacentLeft", "staticObstacle"])
def test_ids_that_are_none(tree: ElementTree.Element, tmp_path: Path, place: str, id: str) -> None:
    element = tree.find(place)
    assert element is not None
    name = "id" if "id" in element.attrib else "ref"
    element.set(name, id)
    with pytest.raises(DataError, match=rf"changed\.xml:\d+: the {name} of <"):
        read(tree, tmp_path)


def words(element: ElementTree.Element) -> Iterator[tuple[str, Callable[[str], None]]]:
    """Each word in and on an element, and what writes another one in its place."""
    for name, value in element.attrib.items():
        if not value.lstrip("-").isdigit():
            yield value, partial(element.set, name)
    text = (element.text or "").strip()
    if text and not re.fullmatch(r"-?[\d.]+(e-?\d+)?", text):
        yield text, partial(setattr, element, "text")


def with_every_word(tree: ElementTree.Element) -> ElementTree.Element:
    lane = tree.find("lanelet")
    assert lane is not None
    for name, word in (("userOneWay", "car"), ("userBidirectional", "bicycle")):
        ElementTree.SubElement(lane, name).text = word
    for side in ("leftBound", "rightBound"):
        bound = lane.find(side)
        assert bound is not None
        if bound.find("lineMarking") is None:
            ElementTree.SubElement(bound, "lineMarking").text = "dashed"
    return tree


@pytest.mark.parametrize("slip", ["{}e", "", "nan", "{}  x", "Opposite"])
def test_words_that_the_format_does_not_know(
    tree: ElementTree.Element, tmp_path: Path, slip: str
) -> None:
    """A driving direction "samee" was the opposite one, and the road had no way to the goal."""
    found = set()
    for _, root, (_, element) in each_changed(with_every_word(tree)):
        for word, write in words(element):
            write(slip.format(word))
            with pytest.raises(
                DataError, match=rf"(?s)changed\.xml:\d+: .*<{element.tag}.*xpected"
            ):
                read(root, tmp_path)
            write(word)
            found.add(element.tag)
    assert found >= {"type", "laneletType", "userOneWay", "userBidirectional", "lineMarking"}
    assert found >= {"adjacentLeft", "adjacentRight"}


@pytest.mark.parametrize(
    ("place", "name"),
    [
        *(("adjacentLeft", name) for name in ("ref", "drivingDir")),
        *(("adjacentRight", name) for name in ("ref", "drivingDir")),
        *((place, "ref") for place in ("predecessor", "successor", "trafficSignRef")),
    ],
)
def test_what_a_neighbour_is_known_by_has_to_be_there(
    tree: ElementTree.Element, tmp_path: Path, place: str, name: str
) -> None:
    element, lane = tree.find(f"lanelet/{place}"), tree.find("lanelet")
    if element is None:
        assert lane is not None
        element = ElementTree.SubElement(lane, place, ref="1")
    del element.attrib[name]
    with pytest.raises(
        DataError, match=rf"changed\.xml:\d+: (<{place}> lacks a {name}|the {name} of <{place}>)"
    ):
        read(tree, tmp_path)


def test_the_formats_own_words_are_known() -> None:
    """Each enumeration of commonroad-io's schema in what is planned with, word for word."""
    import commonroad

    path = next(Path(commonroad.__file__).parent.rglob("XML_commonRoad_XSD.xsd"))
    schema = ElementTree.parse(path).getroot()
    prefix = "{http://www.w3.org/2001/XMLSchema}"
    enumerations = {
        kind.get("name"): {each.get("value") for each in kind.iter(f"{prefix}enumeration")}
        for kind in schema.iter(f"{prefix}simpleType")
        if kind.get("name")
    }
    asked = set()
    for owner in schema.iter(f"{prefix}complexType"):
        if owner.get("name") not in {*GRAMMAR, "bound", "laneletAdjacentRef"}:
            continue
        for member in (*owner.iter(f"{prefix}element"), *owner.iter(f"{prefix}attribute")):
            known = enumerations.get(member.get("type"))
            if known and member.get("name") != "role":
                asked.add(str(member.get("name")))
                assert known <= set(known_words()[str(member.get("name"))]), member.get("name")
    assert asked == set(known_words())


@pytest.mark.parametrize("name", ["group", "staticobstacle", "building", "obstacles"])
def test_strange_elements_are_named(tree: ElementTree.Element, tmp_path: Path, name: str) -> None:
    tree.append(ElementTree.Element(name, id="9"))
    with pytest.raises(DataError, match=rf"changed\.xml:\d+: <{name} id='9'> is none of"):
        read(tree, tmp_path)


def test_what_is_not_planned_with_may_hold_anything(
    tree: ElementTree.Element, tmp_path: Path
) -> None:
    before = read(tree, tmp_path).obstacles.poses
    for name in ("initialSignalState", "signalSeries", "wheelbase"):
        for obstacle in tree.findall("dynamicObstacle"):
            ElementTree.SubElement(obstacle, name)
    assert (read(tree, tmp_path).obstacles.poses == before).all()


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (4, 2), (4, 0), (0, 2)],
        [(0, 0), (1, 0), (2, 0)],
        [(0, 0), (1, 0)],
        [(0, 0), (2, 0), (2, 2), (2, 0), (0, 2)],
    ],
    ids=["bow tie", "line", "two points", "spike"],
)
@pytest.mark.parametrize("owner", ["staticObstacle/shape", "planningProblem/goalState/position"])
def test_polygons_without_an_area(
    tree: ElementTree.Element, tmp_path: Path, points: list[tuple[int, int]], owner: str
) -> None:
    polygon = tree.find(f"{owner}/polygon")
    assert polygon is not None
    polygon.clear()
    for x, y in points:
        point = ElementTree.SubElement(polygon, "point")
        for name, value in (("x", x), ("y", y)):
            ElementTree.SubElement(point, name).text = str(value)
    with pytest.raises(DataError, match=r"changed\.xml:\d+: .*polygon"):
        read(tree, tmp_path)


def test_the_table_holds_the_formats_own() -> None:
    """Nothing that commonroad-io's schema knows of the planned elements is missing."""
    import commonroad

    path = next(Path(commonroad.__file__).parent.rglob("XML_commonRoad_XSD.xsd"))
    schema = ElementTree.parse(path).getroot()
    prefix = "{http://www.w3.org/2001/XMLSchema}"
    for name in ("lanelet", "state", "initialState", "goalState", "rectangle", "circle", "point",
                 "planningProblem", "staticObstacle", "environmentObstacle", "shape"):  # fmt: skip
        kind = schema.find(f"{prefix}complexType[@name='{name}']")
        assert kind is not None
        known = {child.get("name") for child in kind.iter(f"{prefix}element")}
        written = GRAMMAR[name].replace("?", "").replace("*", "").replace("+", "").split()
        assert known <= set(written), name
