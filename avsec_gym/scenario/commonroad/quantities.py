"""The numbers in a CommonRoad file, checked before commonroad-io reads it: it takes any."""

from __future__ import annotations

import re

from avsec_gym.errors import PlanningError
from avsec_gym.scenario.bounds import (
    ANGLE,
    COORDINATE,
    DURATION,
    SIZE,
    SPEED,
    TIME_STEP,
    Bounds,
)
from avsec_gym.scenario.shapes import Polygon
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.xml_tree import Element

BOUNDS: dict[str, Bounds] = {
    "x": COORDINATE,
    "y": COORDINATE,
    "length": SIZE,
    "width": SIZE,
    "radius": SIZE,
    "orientation": ANGLE,
    "velocity": SPEED,
    "time": TIME_STEP,
}
"""The bounds by the name of the element that holds a number, or its exact value or interval."""
OTHERWISE = Bounds(-1e8, 1e8)
"""The bounds of all other elements with values, such as accelerations."""
_WHOLE = re.compile(r"-?\d{1,18}", re.ASCII)
_VALUES = ("exact", "intervalStart", "intervalEnd")


def check_numbers(root: Element) -> None:
    """Refuse a file that holds a number with which nothing can be planned.

    Args:
        root: The file's outermost element.

    Raises:
        DataError: An id is no whole number; a number of `BOUNDS`, or the length of a time step, is
            none, not finite, or impossible; or a polygon is no area.
    """
    _check(root, root.attributes.get("timeStepSize", ""), DURATION, f"timeStepSize of {root.tag}")
    for owner in root.children:
        if owner.name in ("location", "scenarioTags"):
            continue
        for element in owner.descendants():
            for name in ("id", "ref"):
                if not _WHOLE.fullmatch(element.attributes.get(name, "0")):
                    element.refuse(
                        f"the {name} of {element.tag} is {element.attributes[name][:40]!r}.",
                        "Write a whole number of at most 18 digits.",
                    )
            if element.name == "polygon":
                _check_area(element, owner)
            values = [child for child in element.children if child.name in _VALUES]
            bounds = BOUNDS.get(element.name, OTHERWISE if values else None)
            if bounds is None:
                continue
            for value in values or ([] if element.children else [element]):
                where = element.name if value is element else f"{element.name}/{value.name}"
                _check(value, value.text, bounds, f"{where} in {owner.tag}")


def _check_area(polygon: Element, owner: Element) -> None:
    try:
        Polygon(
            tuple(
                (plain_number(p.child("x").text), plain_number(p.child("y").text))
                for p in polygon.children
            )
        )
    except (PlanningError, ValueError) as error:
        polygon.refuse(f"in {owner.tag}, {error}", "Correct its points.")


def _check(element: Element, text: str, bounds: Bounds, what: str) -> None:
    try:
        value = plain_number(text)
    except ValueError:
        element.refuse(f"{what} is {text[:40]!r}.", f"Write {bounds}.")
    try:
        bounds.check(int(value) if value.is_integer() else value, what)
    except PlanningError as error:
        element.refuse(str(error), "Correct the number.")
