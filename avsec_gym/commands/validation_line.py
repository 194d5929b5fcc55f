"""What `avsec validate` reports of a frame, on one line, for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.validation_picture import compared_in_words, damage_in_words, named
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.validator import SHARES


def validation_line(row: Mapping[str, Any]) -> str:
    """The sensor statuses, where the damage is, and why: probabilities, or the deciding share.

    Args:
        row: The row as `avsec_gym.validation.validation_folder.row_of` makes it.
    """
    why = [*_why(row), f"{row['seconds']:.2f} s"]
    if row["locating_seconds"] is not None:
        why.append(f"{row['locating_seconds']:.2f} s to locate")
    return f"{row['id']}  {_status(row)}  ({'; '.join(why)})"


def _status(row: Mapping[str, Any]) -> str:
    open = [
        named(_sensor(sensor))
        for sensor, status in row["statuses"].items()
        if status == "cannot tell"
    ]
    if not row["alarm"]:
        return f"no alarm, though nothing clears {', '.join(open)}" if open else "sound"
    if not row["attacked"]:
        return "ALARM: some sensor; which one, and where, is open"
    damage = {sensor: f" ({damage_in_words(found)})" for sensor, found in row["damage"].items()}
    names = ", ".join(named(sensor) + damage.get(str(sensor), "") for sensor in row["attacked"])
    return f"ALARM: {names}" + (f"; nothing clears {', '.join(open)}" if open else "")


def _why(row: Mapping[str, Any]) -> list[str]:
    if row["probabilities"] is not None:
        each = (f"{named(_sensor(sensor))} {p:.3f}" for sensor, p in row["probabilities"].items())
        return [f"P(attacked): {', '.join(each)}"]
    if not row["exceeded"]:
        return []
    first, *others = row["exceeded"]
    beyond = f"{SHARES[first['share']]} {first['value']:.3g} > {first['threshold']:.3g}"
    more = [f"{len(others)} more beyond their thresholds"] if others else []
    return [f"{beyond} of {compared_in_words(first['sensors'])}", *more]


def _sensor(text: str) -> Sensor:
    return LIDAR if text == LIDAR else int(text)
