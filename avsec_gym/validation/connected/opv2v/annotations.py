"""What is true at an instant of an OPV2V scenario: the vehicles that its yaml files list."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import wrap_angle
from avsec_gym.validation.connected.cropping import CropMargins, cropped
from avsec_gym.validation.connected.opv2v.yaml_nodes import YamlMapping
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.export import ConnectedInstant, SensorVehicle, WorldObject

MOST_OBJECTS = 1000
_FARTHEST = 1e5
_MOST_ANGLE = 720.0
_LARGEST = 30.0
"""Metres from a vehicle's middle to its end."""
_FASTEST = 500.0
"""The highest speed that a file may have, km/h."""
_STANDS = 0.1
"""The speed below which a vehicle stands, m/s."""


def connected_truth(
    drive: int,
    frame: int,
    vehicles: Sequence[int],
    files: Sequence[YamlMapping],
    scans: Sequence[VehicleScan],
) -> ConnectedInstant:
    """The listed vehicles of all files, each once, in our world.

    Each file lists the vehicles that the scan of its own has points on. The sensor vehicles are
    among them as far as others see them. Turn rates are not recorded, and 0.

    Args:
        drive: Number of the scenario.
        frame: Number of the instant in it.
        vehicles: The actors' numbers of the sensor vehicles.
        files: The yaml file of each.
        scans: Each vehicle's scan with its true pose.

    Raises:
        DataError: An entry is missing, or is no vehicle.
    """
    found: dict[int, WorldObject] = {}
    for file in files:
        for name, entry in file.mappings("vehicles", MOST_OBJECTS):
            actor = _actor(file, name)
            if actor not in found:
                found[actor] = _world_object(actor, entry)
    objects = list(found.values())
    points = np.array([_points_on(scan, objects) for scan in scans]).reshape(len(scans), -1)
    return ConnectedInstant(
        drive,
        frame,
        tuple(
            SensorVehicle(actor, 0.0, _speed(file, "ego_speed"), 0.0)
            for actor, file in zip(vehicles, files, strict=True)
        ),
        tuple(
            WorldObject(**{**vars(each), "points": tuple(points[:, index].tolist())})
            for index, each in enumerate(objects)
        ),
    )


def _world_object(actor: int, entry: YamlMapping) -> WorldObject:
    """One entry: ``extent`` is half its size, ``center`` the middle of the box at ``location``."""
    x, y, z = np.add(
        entry.numbers("location", 3, _FARTHEST), entry.numbers("center", 3, _LARGEST)
    ).tolist()
    half = entry.numbers("extent", 3, _LARGEST)
    if min(half) <= 0:
        raise entry.broken("extent", "A vehicle has a positive size.")
    yaw = entry.numbers("angle", 3, _MOST_ANGLE)[1]
    speed = _speed(entry, "speed")
    return WorldObject(
        actor=actor,
        category="Car",
        location=(x, -y, z - half[2]),
        heading=float(wrap_angle(-np.radians(yaw))),
        dimensions=(2 * half[2], 2 * half[1], 2 * half[0]),
        speed=speed,
        turn_rate=0.0,
        moving=abs(speed) > _STANDS,
        points=(),
    )


def _speed(entry: YamlMapping, key: str) -> float:
    """m/s, of km/h; 0 where it is not recorded."""
    return entry.number(key, _FASTEST) / 3.6 if key in entry else 0.0


def _actor(file: YamlMapping, name: str) -> int:
    if not name.removeprefix("-").isdecimal() or len(name) > 10:
        raise file.broken("vehicles", "A vehicle is named by its number.")
    return int(name)


def _points_on(scan: VehicleScan, objects: Sequence[WorldObject]) -> list[int]:
    """The number of points of a scan inside of each object."""
    height, width, length = np.array([each.dimensions for each in objects]).reshape(-1, 3).T
    boxes = Regions(
        np.array([each.location for each in objects]).reshape(-1, 3),
        np.stack([length, width, height], axis=1),
        np.array([each.heading for each in objects]),
    )
    return [len(points) for points in cropped(scan, boxes, CropMargins(0.0, 0.0, 0.0))]
