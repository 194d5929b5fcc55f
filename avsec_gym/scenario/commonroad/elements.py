"""The numbers in a CommonRoad file, checked before commonroad-io reads it: it takes any."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from avsec_gym.errors import DataError, PlanningError
from avsec_gym.scenario.bounds import (
    ANGLE,
    COORDINATE,
    DURATION,
    SIZE,
    SPEED,
    TIME_STEP,
    Bounds,
)

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
"""By the name of the element that holds a number, or its exact value or interval."""
OTHERWISE = Bounds(-1e8, 1e8)
"""Of all other elements with values, such as accelerations."""
_VALUES = ("exact", "intervalStart", "intervalEnd")
_ROOT = "commonRoad"


def check_numbers(root: ElementTree.Element, path: Path) -> None:
    """Refuse a file that holds a number with which nothing can be planned.

    Args:
        root: The file's outermost element.
        path: The file, for messages.

    Raises:
        DataError: A number of `BOUNDS`, or the length of a time step, is none, not finite, or
            impossible.
    """
    if root.tag != _ROOT:
        raise DataError(
            f"the outermost element is <{root.tag}>.",
            path=path,
            remedy=f"Write CommonRoad 2020a XML, within <{_ROOT}>.",
        )
    _check(root.get("timeStepSize"), DURATION, f"timeStepSize of <{_ROOT}>", path)
    for owner in root:
        if owner.tag in ("location", "scenarioTags"):
            continue
        id = owner.get("id")
        name = f"<{owner.tag}>" if id is None else f"<{owner.tag} id={id}>"
        for element in owner.iter():
            values = [child for child in element if child.tag in _VALUES]
            bounds = BOUNDS.get(element.tag, OTHERWISE if values else None)
            if bounds is None:
                continue
            for value in values or ([] if len(element) else [element]):
                where = element.tag if value is element else f"{element.tag}/{value.tag}"
                _check(value.text, bounds, f"{where} in {name}", path)


def _check(text: str | None, bounds: Bounds, what: str, path: Path) -> None:
    try:
        value = float(text or "")
    except ValueError:
        raise DataError(
            f"{what} is {(text or '')[:40]!r}.", path=path, remedy=f"Write {bounds}."
        ) from None
    try:
        bounds.check(value, what)
    except PlanningError as error:
        raise DataError(str(error), path=path, remedy="Correct the number.") from None
