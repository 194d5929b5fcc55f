"""Which elements of a CommonRoad file stand where, and how often: commonroad-io does not look.

It takes the first of two shapes, passes over an obstacle whose name is misspelt, and reads 8 from
``<x>8<b>1</b></x>``.  An object that a planner never hears of is one that it drives through.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import Literal, NamedTuple

from avsec_gym.storage.xml_tree import Element
from avsec_gym.suggestions import did_you_mean

_OTHER_STATE_VALUES = (
    "acceleration", "accelerationY", "yawRate", "slipAngle", "steeringAngle",
    "steeringAngleSpeed", "rollAngle", "rollRate", "pitchAngle", "pitchRate", "velocityY",
    "positionZ", "velocityZ", "rollAngleFront", "rollRateFront", "velocityYFront",
    "positionZFront", "velocityZFront", "rollAngleRear", "rollRateRear", "velocityYRear",
    "positionZRear", "velocityZRear", "frontWheelAngularSpeed", "rearWheelAngularSpeed",
    "leftFrontWheelAngularSpeed", "rightFrontWheelAngularSpeed", "leftRearWheelAngularSpeed",
    "rightRearWheelAngularSpeed", "deltaYFront", "deltaYRear", "curvature", "curvatureChange",
    "jerk", "jounce", "hitchAngle", "longitudinalPosition", "lateralPosition",
)  # fmt: skip
_OTHERS = " ".join(f"{name}?" for name in _OTHER_STATE_VALUES)
_SIGNALS = "initialSignalState? signalSeries?"
_SHAPES = "rectangle* circle* polygon*"

GRAMMAR: dict[str, str] = {
    "commonRoad": "location? scenarioTags? lanelet* trafficSign* trafficLight* intersection*"
    " staticObstacle* dynamicObstacle* environmentObstacle* planningProblem*",
    # The road.
    "lanelet": "leftBound rightBound predecessor* successor* adjacentLeft? adjacentRight? stopLine?"
    " laneletType* userOneWay* userBidirectional* trafficSignRef* trafficLightRef* speedLimit?",
    "leftBound": "point+ lineMarking?",
    "rightBound": "point+ lineMarking?",
    # What is on it.
    "staticObstacle": f"type shape initialState {_SIGNALS}",
    "dynamicObstacle": f"type shape initialState trajectory? {_SIGNALS} wheelbase?",
    "environmentObstacle": "type shape",
    "trajectory": "state+",
    # Who drives.
    "planningProblem": "initialState goalState+",
    "planningProblem/initialState": f"position orientation velocity time {_OTHERS}",
    "goalState": "time position? orientation? velocity?",
    "goalState/position": f"{_SHAPES} | lanelet+",
    "position/lanelet": "",
    "goalState/time": "intervalStart intervalEnd",
    "goalState/orientation": "intervalStart intervalEnd",
    "goalState/velocity": "intervalStart intervalEnd",
    # States.
    **dict.fromkeys(("initialState", "state"), f"position orientation velocity? time {_OTHERS}"),
    **{
        f"{state}/{name}": "point" if name == "position" else "exact"
        for state in ("initialState", "state")
        for name in ("position", "orientation", "velocity", "time")
    },
    **dict.fromkeys(_OTHER_STATE_VALUES, "exact | intervalStart intervalEnd"),
    # Shapes.
    "shape": _SHAPES,
    "rectangle": "length width orientation? center?",
    "circle": "radius center?",
    "polygon": "point+",
    "center": "x y z?",
    "point": "x y z?",
}
"""The contents by an element's name, or its parent's and its own: at least one of all that stands
in it.

``?`` is at most once, ``*`` any number, ``+`` once or more, nothing is exactly once; ``|`` stands
between alternatives; the order does not count.  Elements that are not here hold a value and no
element, as those do for which nothing is written.
"""

NOT_PLANNED_WITH = {
    "location", "scenarioTags", "trafficSign", "trafficLight", "intersection", "stopLine",
    "initialSignalState", "signalSeries", "wheelbase",
}  # fmt: skip
"""Elements of the format that have no part in planning; what they hold is not looked at."""

Amount = Literal["", "?", "*", "+"]


class Content(NamedTuple):
    """What stands in an element."""

    alternatives: tuple[dict[str, Amount], ...]
    """Names, and how often each may come."""


def _content(written: str) -> Content:
    words = [re.findall(r"(\w+)([?*+]?)", part) for part in written.split("|")]
    return Content(tuple(dict(pairs) for pairs in words))


_CONTENTS = {name: _content(written) for name, written in GRAMMAR.items()}
_VALUE = _content("")


def check_elements(root: Element) -> None:
    """Refuse elements that do not belong where they stand, lack, or come too often.

    Args:
        root: The file's outermost element.

    Raises:
        DataError: One of these, or text where only elements stand, or the other way round.
    """
    # Files consist of the same few sequences of elements many thousand times.
    sound: set[tuple[str, ...]] = set()

    def check(element: Element, parent: str) -> None:
        name, children = element.name, element.children
        own = f"{parent}/{name}"
        content = _CONTENTS.get(own if own in _CONTENTS else name, _VALUE)
        if content == _VALUE:
            if children:
                children[0].refuse(
                    f"{children[0].tag} stands in <{name}>, which holds no elements.",
                    "Leave only the value.",
                )
            return
        if element.text:
            element.refuse(
                f"the text {element.text[:40]!r} stands in {element.tag}, which holds elements.",
                "Remove it, or put it into the element that it belongs to.",
            )
        sequence = (own, *[child.name for child in children])
        if sequence not in sound:
            _check_counts(element, content)
            sound.add(sequence)
        for child in children:
            if child.name not in NOT_PLANNED_WITH:
                check(child, name)

    check(root, "")


def _check_counts(element: Element, content: Content) -> None:
    counts = Counter(child.name for child in element.children)
    # The alternative that what stands first belongs to.
    first = element.children[0].name if element.children else None
    alternatives = (names for names in content.alternatives if first in names)
    allowed = next(alternatives, content.alternatives[0])
    expected = f"<{element.name}> holds {_in_words(content)}."
    for child in element.children:
        if child.name not in allowed:
            child.refuse(
                f"{child.tag} is none of the elements that may stand in {element.tag}.",
                did_you_mean(child.name, allowed) or expected,
            )
    for name, amount in allowed.items():
        if counts[name] > 1 and amount in ("", "?"):
            second = element.all(name)[1]
            second.refuse(f"there is a second <{name}> in {element.tag}.", "Leave the right one.")
        if not counts[name] and amount in ("", "+"):
            element.refuse(f"{element.tag} lacks a <{name}>.", expected)
    if not counts:
        element.refuse(f"{element.tag} is empty.", expected)


_AMOUNTS = {"": "one", "?": "at most one", "*": "any number of", "+": "one or more of"}


def _in_words(content: Content) -> str:
    return ", or ".join(
        ", ".join(
            f"{_AMOUNTS[amount]} <{name}>"
            for name, amount in names.items()
            if name not in _OTHER_STATE_VALUES
        )
        for names in content.alternatives
    )
