"""Whether what was read can be: values that no sound file holds, in whatever a reader returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_FARTHEST = 1e3
_EARTH = 3e7


def finite(value: Any) -> str | None:
    """Every number is finite and below 10^12; NaN is no value here."""
    for name, numbers in _numbers(value, ""):
        if not np.isfinite(numbers).all():
            return f"{name or 'a value'} is not finite"
        if numbers.size and np.abs(numbers).max() > 1e12:
            return f"{name or 'a value'} is {numbers.flat[np.abs(numbers).argmax()]:.3g}"
    return None


def detections(value: Any) -> str | None:
    """Boxes of a detector, whose headings are up to two turns: many sum two angles."""
    return boxes(value, most_turns=2)


def boxes(value: Any, most_turns: int = 1) -> str | None:
    """Boxes of labels, with headings of a turn at most, or of detections."""
    for item in value.values() if isinstance(value, Mapping) else [value]:
        item = getattr(item, "boxes", item)
        if problem := finite(item):
            return problem
        real = (item.category != "DontCare") & (item.location != -1000).any(axis=1)
        if len(item) and real.any():
            if np.abs(item.location[real]).max() > _FARTHEST:
                return "an object is farther than a kilometre"
            if (item.dimensions[real] < 0).any() and not (item.dimensions[real] == -1).all():
                return "an object has a negative size"
        box2d = item.box2d
        if box2d is not None and (box2d[:, 2:] < box2d[:, :2]).any():
            return "a 2D box ends before it begins"
        # All but the 2D box of a DontCare line is placeholders.
        cared = item[item.category != "DontCare"]
        if cared.occlusion is not None and not np.isin(cared.occlusion, (-1, 0, 1, 2, 3)).all():
            return "an occlusion is none of 0 to 3"
        if (
            cared.truncation is not None
            and ((cared.truncation > 1) | (cared.truncation < -1)).any()
        ):
            return "a truncation is not from -1 to 1"
        known = item.rotation_y[real & (item.rotation_y != -10)]
        if len(known) and np.abs(known).max() > most_turns * 2 * np.pi + 0.01:
            return f"a rotation is more than {most_turns} x 360 degrees"
    return None


def calibration(value: Any) -> str | None:
    """Cameras with a focal length."""
    for camera in value.cameras:
        matrix = value.projection(camera)
        if matrix[0, 0] <= 0 or matrix[1, 1] <= 0:
            return f"camera {camera} has a focal length of {matrix[0, 0]:.3g}, {matrix[1, 1]:.3g}"
        if not np.allclose(matrix[2, :3], (0, 0, 1), atol=1e-6):
            return f"the third row of camera {camera} is {matrix[2]}"
    return finite(value)


def scan(value: Any) -> str | None:
    """Points near the car, with reflectances."""
    if problem := finite(value):
        return problem
    if value.size and np.abs(value[:, :3]).max() > _FARTHEST:
        return "a point is farther than a kilometre"
    if value.size and ((value[:, 3] < 0) | (value[:, 3] > 1)).any():
        return "a reflectance is not in 0 to 1"
    return None


def disparity(value: Any) -> str | None:
    """Disparities, NaN where unknown."""
    known = value[~np.isnan(value)]
    return None if np.isfinite(known).all() and (known > 0).all() else "a disparity is not above 0"


def primitives(value: Any) -> str | None:
    """Primitives that a car can drive: speeds of 0 to 100 m/s, steering within a quarter turn."""
    if problem := finite(value.states):
        return problem
    speeds, steering = value.states[..., 2], value.states[..., 4]
    if speeds.min() < 0 or speeds.max() > 100:
        return f"speeds from {speeds.min():.3g} to {speeds.max():.3g} m/s"
    if np.abs(steering).max() > np.pi / 2:
        return f"a steering angle of {np.abs(steering).max():.3g} rad"
    return None


def problem(value: Any) -> str | None:
    """A planning problem with sizes, a time step, and places on this earth."""
    for name, numbers in _numbers(value, ""):
        last = name.rpartition(".")[2]
        if not np.isfinite(numbers).all():
            return f"{name} is not finite"
        if numbers.size and np.abs(numbers).max() > _EARTH and last not in ("id", "seed"):
            return f"{name} is {np.abs(numbers).max():.3g}"
        if last in ("length", "width", "radius", "time_step", "dt") and (numbers <= 0).any():
            return f"{name} is {numbers.min():.3g}"
    return None


def problem_of_file(value: Any) -> str | None:
    """A planning problem with all obstacles that its file holds."""
    scenario, shapes = value
    if len(scenario.obstacles) != shapes:
        return f"{len(scenario.obstacles)} obstacles of {shapes}"
    return problem(scenario)


def shares(value: Any) -> str | None:
    """Shares from 0 to 1."""
    numbers = value.shares
    return None if ((numbers >= 0) & (numbers <= 1)).all() else "a share is not in 0 to 1"


def nothing(_: Any) -> str | None:
    """Reading it is all."""
    return None


def _numbers(value: Any, name: str) -> Any:
    """Every number and array in a tree of dataclasses, containers and arrays, with its place."""
    if isinstance(value, bool) or value is None:
        return
    if isinstance(value, (int, float, np.number)):
        yield name, np.asarray([float(value)]) if abs(value) < 1e300 else np.asarray([np.inf])
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "fiu":
            yield name, value.astype(float)
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _numbers(inner, f"{name}.{key}")
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from _numbers(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, (list, tuple, set, frozenset)):
        for inner in value:
            yield from _numbers(inner, name)
    elif type(value).__module__.startswith("torch") and value.is_floating_point():
        yield name, value.detach().double().numpy()
