"""Scans of cars, cut out of some moments, pasted into others where a bogus return would stand."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.object_scan import ObjectScan, cut_out
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.attacks.pasted_scan import PastedScan
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.objects.moment_truth import truth_of
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import ego_to_camera
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.moments import Moment

FEWEST_POINTS = 200
"""Of the scan of a car."""
FARTHEST = 20.0
"""Metres to a car whose scan is pasted."""


@dataclass(frozen=True, eq=False)
class CarInView:
    """A car's scan at the distance and bearing that `LidarSpoofing` draws by the same seed.

    Args:
        scan: Of the car.
        reference: The camera in whose view it is.
        rays_lost: See `PastedScan`.
    """

    name: ClassVar[str] = "car_in_view"
    scan: ObjectScan
    reference: int
    rays_lost: bool = True

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The LiDAR."""
        return frozenset({LIDAR})

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """See `OpticalAttack.attack`."""
        drawn = LidarSpoofing(reference=self.reference).attack(frame, seed).settings
        distance, bearing = drawn["distance"], drawn["bearing"]
        paste = PastedScan(self.scan, distance, bearing, rays_lost=self.rays_lost)
        return paste.attack(frame, seed)


def scan_of_a_car(moments: Sequence[Moment], number: int) -> ObjectScan:
    """The nearest car of a moment, or of the next one that has one up to `FARTHEST`.

    Raises:
        DataError: No moment has a labelled car with `FEWEST_POINTS` or more.
    """
    for place in range(len(moments)):
        frame = moments[(number + place) % len(moments)].frame()
        scans = scans_of_cars(frame, truth_of(frame, SYSTEM.reference))
        if scans:
            return scans[0]
    raise DataError(
        f"No moment shows the LiDAR a labelled car within {FARTHEST:g} m whose scan could be"
        " pasted.",
        remedy="Name labelled drives by --options fit=FOLDER.",
    )


def scans_of_cars(frame: SensorFrame, labels: Boxes3D | None) -> list[ObjectScan]:
    """Of a frame's labelled cars up to `FARTHEST`, with `FEWEST_POINTS` or more, nearest first."""
    if labels is None:
        return []
    cars = labels[labels.category == "Car"]
    distance = np.hypot(cars.location[:, 0], cars.location[:, 2])
    scans = []
    for car in np.argsort(distance):
        # One that is hidden no beam meets.
        if distance[car] <= FARTHEST:
            with suppress(DataError):
                scans.append(cut_out(frame, cars[[car]]))
    return [scan for scan in scans if len(scan.points) >= FEWEST_POINTS]


def pasted_box(scan: ObjectScan, tampered: TamperedFrame) -> Boxes3D:
    """Where `PastedScan` put an object."""
    pose = [[tampered.settings[one] for one in ("x", "y", "heading")]]
    location, rotation_y = ego_to_camera(pose, 0.0)
    return Boxes3D(location, np.array([scan.dimensions]), rotation_y, np.ones(1), np.array(["Car"]))
