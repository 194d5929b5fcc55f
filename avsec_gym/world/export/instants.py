"""``objects/ID.json`` of connected vehicles: who is where at an instant, and who sees whom."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats, Integers
from avsec_gym.storage.json_fields import fits
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.actors import Instant
from avsec_gym.world.rendering.planar_motion import PlanarMotion

SEEN_POINTS = 5
"""So many points make a vehicle see an object."""
_REACH = 80.0
"""Metres from a sensor vehicle within which objects are listed."""
_MOST_FRAMES = 10**9
ROADSIDE = -1
"""The number that stands for an actor's in the entry of a fixed LiDAR beside the road."""
_AGAIN = "Remove the last vehicle's label file of this instant and run `avsec world make` again."


@dataclass(frozen=True)
class SensorVehicle:
    """One of the connected vehicles at an instant.

    Args:
        actor: Number of the vehicle among all actors, as in `WorldObject`; negative: a fixed LiDAR
            beside the road, which is none.
        time: Time of its cameras' trigger, which is that of its scan and poses, after the instant,
            seconds.
        speed: Speed along its heading, m/s.
        turn_rate: How fast it turns to the left, rad/s.
    """

    actor: int
    time: float
    speed: float
    turn_rate: float

    @property
    def is_roadside(self) -> bool:
        """Whether this is a fixed LiDAR beside the road, without a vehicle's body about it."""
        return self.actor < 0


@dataclass(frozen=True)
class WorldObject:
    """A vehicle, cyclist or pedestrian at an instant; sensor vehicles are among them.

    Args:
        actor: The number of the actor, the same over a drive and for all vehicles.
        category: KITTI's name.
        location: Bottom centre in the world, metres.
        heading: Radians in the world, 0 along x, counter-clockwise.
        dimensions: Height, width, length, metres.
        speed: Speed along the heading, m/s.
        turn_rate: How fast it turns to the left, rad/s.
        moving: Whether it moves.
        points: Number of points that each vehicle's scan has on it.
    """

    actor: int
    category: str
    location: tuple[float, float, float]
    heading: float
    dimensions: tuple[float, float, float]
    speed: float
    turn_rate: float
    moving: bool
    points: tuple[int, ...]

    @property
    def seen_by(self) -> tuple[int, ...]:
        """Numbers of the vehicles with `SEEN_POINTS` points or more on it."""
        return tuple(i for i, count in enumerate(self.points) if count >= SEEN_POINTS)

    def pose_after(self, seconds: float) -> Floats:
        """Position x, y and heading so much later, such as at a vehicle's own time, shape (3,)."""
        ahead, left, turned = PlanarMotion(self.speed, self.turn_rate).after(seconds)
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        return np.array(
            [
                self.location[0] + ahead * cos - left * sin,
                self.location[1] + ahead * sin + left * cos,
                self.heading + turned,
            ]
        )


@dataclass(frozen=True)
class ConnectedInstant:
    """What is true at an instant that several vehicles see.

    Args:
        drive: Number of the drive, or of the place where instants stand alone.
        frame: Number of the instant in its drive, 0.1 s apart.
        vehicles: The sensor vehicles, by number.
        objects: All objects within 80 m of one of them.
    """

    drive: int
    frame: int
    vehicles: tuple[SensorVehicle, ...]
    objects: tuple[WorldObject, ...]

    @property
    def shared(self) -> float | None:
        """Share of the objects seen by any vehicle that two or more see; None without any."""
        return shared_objects([self])


def shared_objects(instants: Sequence[ConnectedInstant]) -> float | None:
    """Share of the objects seen by any vehicle that two or more see; None without any."""
    counts = [len(each.seen_by) for instant in instants for each in instant.objects]
    seen = sum(count >= 1 for count in counts)
    return sum(count >= 2 for count in counts) / seen if seen else None


def instant_of(
    instant: Instant, drive: int, frame: int, times: Sequence[float], points: Sequence[Integers]
) -> ConnectedInstant:
    """The truth of a rendered instant.

    Args:
        instant: Actors at the instant, with turn rates.
        drive: Number of the drive.
        frame: Number of the instant in its drive.
        times: Each vehicle's own time after the instant, seconds; where there is one more, it is
            that of a fixed LiDAR beside the road.
        points: Number of points of each scan on each actor, in the same order, shape (N,) each.
    """
    actors, egos = instant.actors, list(instant.egos)
    turn_rate = np.zeros(len(actors)) if instant.turn_rate is None else instant.turn_rate
    away = actors.pose[:, None, :2] - actors.pose[None, egos, :2]
    listed = np.hypot(away[..., 0], away[..., 1]).min(axis=1) < _REACH

    def number(value: float, digits: int = 6) -> float:
        return round(float(value), digits)

    vehicles = tuple(
        SensorVehicle(
            int(actors.id[own]), number(time), number(actors.speed[own]), number(turn_rate[own])
        )
        for own, time in zip(egos, times[: len(egos)], strict=True)
    )
    vehicles += tuple(
        SensorVehicle(ROADSIDE, number(time), 0.0, 0.0) for time in times[len(egos) :]
    )
    objects = tuple(
        WorldObject(
            actor=int(actors.id[i]),
            category=str(actors.category[i]),
            location=(
                number(actors.pose[i, 0]),
                number(actors.pose[i, 1]),
                number(actors.z[i]),
            ),
            heading=number(actors.pose[i, 2]),
            dimensions=(
                number(actors.dimensions[i, 0]),
                number(actors.dimensions[i, 1]),
                number(actors.dimensions[i, 2]),
            ),
            speed=number(actors.speed[i]),
            turn_rate=number(turn_rate[i]),
            moving=bool(actors.moving[i]),
            points=tuple(int(counts[i]) for counts in points),
        )
        for i in np.flatnonzero(listed).tolist()
    )
    return ConnectedInstant(drive, frame, vehicles, objects)


def write_instant(path: Path, instant: ConnectedInstant) -> None:
    """Write ``objects/ID.json``, over an earlier one."""
    write_text(path, json.dumps(asdict(instant), indent=1) + "\n", overwrite=True)


def read_instant(path: str | Path) -> ConnectedInstant:
    """Read ``objects/ID.json``.

    Raises:
        DataError: It cannot be read, or is none.
    """
    facts = read_json_object(path, remedy=_AGAIN)
    try:
        vehicles = tuple(SensorVehicle(**_row(SensorVehicle, row)) for row in facts["vehicles"])
        objects = tuple(WorldObject(**_row(WorldObject, row)) for row in facts["objects"])
        drive, frame = facts["drive"], facts["frame"]
        if not all(type(each) is int and 0 <= each <= _MOST_FRAMES for each in (drive, frame)):
            raise ValueError(f"drive and frame are whole numbers from 0 to {_MOST_FRAMES:,}")
        if any(len(each.points) != len(vehicles) for each in objects):
            raise ValueError("an object has a number of points for each vehicle")
        if any(each.actor < 0 for each in objects):
            raise ValueError("an object's actor is 0 or more")
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(
            f"This describes no instant of connected vehicles: {error}.", path=path, remedy=_AGAIN
        ) from error
    return ConnectedInstant(drive, frame, vehicles, objects)


_BETWEEN: dict[str, tuple[float, float]] = {
    "actor": (-(10**9), 10**9),
    "time": (-10.0, 10.0),
    "speed": (-1e3, 1e3),
    "turn_rate": (-1e3, 1e3),
    "location": (-3e7, 3e7),
    "heading": (-1e3, 1e3),
    "dimensions": (1e-3, 1e3),
    "points": (0, 10**9),
}
"""The smallest and the largest number of each field, in its unit; places count from any origin on
this earth."""
_KINDS = {
    "int": int,
    "bool": bool,
    "str": str,
    "float": float,
    "tuple[float, float, float]": list[float],
    "tuple[int, ...]": list[int],
}


def _row(kind: type[SensorVehicle | WorldObject], row: Any) -> dict[str, Any]:
    """The fields of one row, each of its type; lists become tuples.

    Raises:
        ValueError: A field is missing or of another type, or holds a number that cannot be.
    """
    if not isinstance(row, dict):
        raise ValueError(f"{kind.__name__} is an object of JSON")
    result = {}
    for field in fields(kind):
        value = row.get(field.name)
        wanted = _KINDS[str(field.type)]
        triple = str(field.type) == "tuple[float, float, float]"
        if not fits(value, wanted) or (triple and len(value) != 3):  # type: ignore[arg-type]
            raise ValueError(f"{field.name} is no {field.type}")
        if field.name in _BETWEEN:
            low, high = _BETWEEN[field.name]
            for number in value if isinstance(value, list) else [value]:
                if not low <= number <= high:  # type: ignore[operator]
                    raise ValueError(f"{field.name} is {number}, expected {low:g} to {high:g}")
        result[field.name] = tuple(value) if isinstance(value, list) else value
    return result
