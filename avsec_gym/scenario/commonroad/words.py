"""The words in a CommonRoad file, checked before commonroad-io reads it: some it takes for others.

A driving direction that is not ``same`` it takes for the opposite one, and a road is another one.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from functools import cache

from avsec_gym.scenario.commonroad.format import import_quietly
from avsec_gym.scenario.commonroad.grammar import NOT_PLANNED_WITH
from avsec_gym.storage.xml_tree import Element
from avsec_gym.suggestions import did_you_mean

DIRECTION = "drivingDir"
"""The attribute that states which way a neighbouring lanelet runs."""
REFERENCES = (
    "predecessor", "successor", "adjacentLeft", "adjacentRight", "trafficSignRef",
    "trafficLightRef",
)  # fmt: skip
"""Elements of lanelets that are nothing without what they refer to."""


@cache
def known_words() -> dict[str, tuple[str, ...]]:
    """The words that may be the text of an element, or the value of an attribute, by its name."""
    import_quietly()
    from commonroad.scenario.lanelet import LaneletType, LineMarking, RoadUser
    from commonroad.scenario.obstacle import ObstacleType

    enumerations: dict[str, type[Enum]] = {
        "type": ObstacleType,
        "laneletType": LaneletType,
        "userOneWay": RoadUser,
        "userBidirectional": RoadUser,
        "lineMarking": LineMarking,
    }
    known = {name: tuple(str(each.value) for each in words) for name, words in enumerations.items()}
    return {**known, DIRECTION: ("same", "opposite")}


def check_words(root: Element) -> None:
    """Refuse a file with a word that the format does not know where one of its own stands.

    Args:
        root: The file's outermost element, as `check_elements` has found it sound.

    Raises:
        DataError: A word of `known_words` is another one, or an element does not refer to anything.
    """
    for element in _planned_with(root):
        if element.name in known_words():
            _check(element, element.tag, element.text)
        if element.name.startswith("adjacent"):
            direction = element.attributes.get(DIRECTION, "")
            _check(element, f"the {DIRECTION} of {element.tag}", direction, DIRECTION)
        if element.name in REFERENCES and "ref" not in element.attributes:
            element.refuse(f"{element.tag} lacks a ref.", "Write the id that it refers to.")


def _planned_with(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        if child.name not in NOT_PLANNED_WITH:
            yield from _planned_with(child)


def _check(element: Element, what: str, word: str, kind: str | None = None) -> None:
    known = known_words()[kind or element.name]
    if word not in known:
        expected = f"Expected {', '.join(known)}."
        meant = did_you_mean(word, known)
        element.refuse(f"{what} is {word[:40]!r}.", f"{meant} {expected}".strip())
