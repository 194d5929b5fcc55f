"""Motion primitives in CommonRoad's XML format (commonroad-search reads and writes it)."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.planners.primitives import MotionPrimitives
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.xml_tree import Element, read_plain_xml

_FIELDS = ("x", "y", "velocity", "orientation", "steering_angle")
_DECIMAL_SECOND = 0.1
_UNIT = "deci-second"
_FARTHEST, _FASTEST = 1e3, 100.0
"""Metres and m/s: farther and faster leads no primitive."""
_SPEED = _FIELDS.index("velocity")
_SLACK = 0.05
"""Metres beyond what the greater of two speeds leads to within a decisecond: enough for any way of
integrating; those of commonroad-search's generator keep to it exactly."""
_NOISE = 1e-6
"""m/s: a speed of 0 that was integrated."""
_ROUNDED = 1e-3
"""The rounding: by so much may a steering angle exceed the vehicle's limit, rad."""


def read_primitives(path: str | Path) -> MotionPrimitives:
    """Read a primitive file; repeated (initial, final) pairs count once.

    The length of a primitive is the number of its states: ``Duration`` is 5 deciseconds even
    where a primitive was cut short, so it has to be no shorter.

    Raises:
        DataError: The file is not such XML, names another vehicle, or holds a broken trajectory,
            such as one of states that are not each a decisecond after the one before.
    """
    path = Path(path)
    root = read_plain_xml(path)
    vehicle = root.child("VehicleType").text
    if vehicle != BMW_320I.name:
        raise DataError(
            f"these are primitives of the vehicle {vehicle or '(none named)'!r}.",
            path=path,
            remedy=f"Only {BMW_320I.name} can be driven.",
        )
    trajectories, seen = [], set()
    for number, node in enumerate(_all(root.child("Trajectories"), "Trajectory"), start=1):
        nodes = [node.child("Initial"), *_all(node.child("Path"), "State"), node.child("Final")]
        _check_times(node, nodes)
        states = [_state(state) for state in nodes]
        _check(np.array(states), number, path)
        identity = (len(states), *states[0], *states[-1])
        if identity not in seen:
            seen.add(identity)
            trajectories.append(states)
    if not trajectories:
        raise DataError("the file holds no trajectory.", path=path, remedy=_REMEDY)
    longest = max(len(states) for states in trajectories)
    return MotionPrimitives(
        states=np.array(
            [states + [states[-1]] * (longest - len(states)) for states in trajectories]
        ),
        steps=np.array([len(states) - 1 for states in trajectories]),
        vehicle=BMW_320I,
        dt=_DECIMAL_SECOND,
        name=path.stem,
    )


def write_primitives(
    primitives: MotionPrimitives, path: str | Path, *, overwrite: bool = False
) -> None:
    """Write a primitive file; `read_primitives` reads the same numbers back.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    root = ElementTree.Element("MotionPrimitiveFile")
    ElementTree.SubElement(root, "VehicleType").text = primitives.vehicle.name
    all_nodes = ElementTree.SubElement(root, "Trajectories")
    for states, steps in zip(primitives.states, primitives.steps.tolist(), strict=True):
        node = ElementTree.SubElement(all_nodes, "Trajectory")
        ElementTree.SubElement(node, "Duration", unit=_UNIT).text = str(steps)
        _add_state(node, "Initial", states[0], 0)
        _add_state(node, "Final", states[steps], steps)
        way = ElementTree.SubElement(node, "Path")
        for step in range(1, steps):
            _add_state(way, "State", states[step], step)
    ElementTree.indent(root)
    content = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    write_bytes(path, content, overwrite=overwrite)


def _check_times(trajectory: Element, states: list[Element]) -> None:
    """Refuse states at other times than 0, 1, 2, ... deciseconds; a file may leave times out.

    Raises:
        DataError: A time, or the duration, is another one, or of another unit.
    """
    for step, state in enumerate(states):
        if (written := state.number("time_step", step)) != step:
            state.refuse(f"<time_step> of state {step} is {written:g}; expected {step}.", _REMEDY)
    last = len(states) - 1
    duration = trajectory.find("Duration")
    if duration is not None and (unit := duration.attributes.get("unit", _UNIT)) != _UNIT:
        duration.refuse(f"the unit of <Duration> is {unit[:40]!r}; expected {_UNIT}.", _REMEDY)
    if not (written := trajectory.number("Duration", last)) >= last:
        trajectory.refuse(f"<Duration> is {written:g}; expected {last} or more.", _REMEDY)


def _check(states: Floats, number: int, path: Path) -> None:
    """Refuse what the vehicle cannot drive.

    Args:
        states: States in the order of `_FIELDS`, shape (T, 5).
        number: Number of the trajectory in the file.
        path: The file.

    Raises:
        DataError: A value is not finite or impossible.
    """
    steering = BMW_320I.max_steering_angle + _ROUNDED
    place, turn = (-_FARTHEST, _FARTHEST), (-2 * np.pi, 2 * np.pi)
    limits = (place, place, (-_NOISE, _FASTEST), turn, (-steering, steering))
    for name, (low, high), column in zip(_FIELDS, limits, states.T, strict=True):
        impossible = column[~((column >= low) & (column <= high))]
        if len(impossible):
            raise DataError(
                f"trajectory {number} has the {name} {impossible[0]:g}.",
                path=path,
                remedy=f"Expected {low:g} to {high:g}. {_REMEDY}",
            )
    speeds = np.maximum(states[1:, _SPEED], states[:-1, _SPEED])
    gone = np.hypot(*np.diff(states[:, :2], axis=0).T)
    farthest = speeds * _DECIMAL_SECOND + _SLACK
    if (gone > farthest).any():
        step = int((gone - farthest).argmax())
        raise DataError(
            f"trajectory {number} moves by {gone[step]:g} m from state {step} to the next one, at "
            f"{speeds[step]:g} m/s.",
            path=path,
            remedy=f"Expected {farthest[step]:g} m at most. {_REMEDY}",
        )


_REMEDY = "Write it as commonroad-search's motion primitive generator does."


def _all(parent: Element, name: str) -> list[Element]:
    """The children, which all have one name."""
    for child in parent.children:
        if child.name != name:
            child.refuse(f"{child.tag} is no {name}.", _REMEDY)
    return parent.children


def _state(node: Element) -> list[float]:
    return [node.number(name) for name in _FIELDS]


def _add_state(parent: ElementTree.Element, tag: str, state: np.ndarray, step: int) -> None:
    node = ElementTree.SubElement(parent, tag)
    for name, value in zip(_FIELDS, state.tolist(), strict=True):
        ElementTree.SubElement(node, name).text = repr(value)
    ElementTree.SubElement(node, "time_step").text = str(step)
