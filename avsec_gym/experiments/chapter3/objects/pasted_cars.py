"""Scans of cars, cut out of some frames, pasted into others where a bogus return would stand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.recordings import RIG, SYSTEM
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import ego_to_camera
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.recordings import RecordedFrame

FEWEST_POINTS = 200
"""Fewest points of the scan of a car."""
FARTHEST = 20.0
"""Metres to a car whose scan is pasted."""


@dataclass(frozen=True, eq=False)
class CarInView:
    """A car's scan where `LidarSpoofing` puts the thesis' bogus return by the same seed.

    The side of the car that is nearest to the LiDAR stands at that distance.

    Args:
        scan: The scan of the car.
        reference: The camera in whose view the car stands.
        rays_lost: Whether rays are lost, see `PastedScan`.
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
        distance, bearing = LidarSpoofing(reference=self.reference).place(frame, seed)
        towards = np.array(self.scan.seen_from) / np.hypot(*self.scan.seen_from)
        nearest = float((self.scan.points[:, :2] @ towards).max())
        paste = PastedScan(self.scan, distance + nearest, bearing, rays_lost=self.rays_lost)
        return paste.attack(frame, seed)


class CarsOfFrames:
    """The nearest car of each frame, see `scans_of_cars`; it is cut out once.

    Args:
        frames: The frames of a recording.
    """

    def __init__(self, frames: Sequence[RecordedFrame]) -> None:
        self._frames = frames
        self._known: dict[int, ObjectScan | None] = {}

    def first_of(self, numbers: Iterable[int]) -> ObjectScan | None:
        """The car of the first frame that has one; None: none has.

        Args:
            numbers: The numbers of frames; after the last one of the recording comes the first
                again.

        Raises:
            DataError: A file is broken.
        """
        found = (self._of(number % len(self._frames)) for number in numbers)
        return next((scan for scan in found if scan is not None), None)

    def _of(self, number: int) -> ObjectScan | None:
        if number not in self._known:
            frame = self._frames[number].frame()
            scans = scans_of_cars(frame, truth_of(frame, SYSTEM.reference))
            self._known[number] = scans[0] if scans else None
        return self._known[number]


def scans_of_cars(frame: SensorFrame, labels: Boxes3D | None) -> list[ObjectScan]:
    """Scans of labelled cars up to `FARTHEST`, with `FEWEST_POINTS` or more, nearest first.

    Raises:
        DataError: The scan is missing or broken.
    """
    if labels is None:
        return []
    _ = frame.points  # If it cannot be read, that is no hidden car.
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
    """Where `PastedScan` put an object, on the road."""
    pose = [[tampered.settings[key] for key in ("x", "y", "heading")]]
    location, rotation_y = ego_to_camera(pose, RIG.camera_height)
    return Boxes3D(location, np.array([scan.dimensions]), rotation_y, np.ones(1), np.array(["Car"]))
