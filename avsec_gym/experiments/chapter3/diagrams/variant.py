"""One attack of the diagrams: which of the parameters that the thesis leaves open it has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.bogus_object import PLANE, SHELL, BogusObject, resampled_scan
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.diagrams.scan_rings import rings_of
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import bogus_patch
from avsec_gym.experiments.chapter3.objects.pasted_cars import CarInView, pasted_box
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import KITTI_SIZE
from avsec_gym.sensor_system import LIDAR

CAMERA = "camera"
CLOUD = "cloud"
FORMS: Mapping[str, str] = {
    PLANE: "a plane",
    SHELL: "a shell, 2.5 m deep",
    CLOUD: "a real car’s points",
}
"""Forms of bogus objects, and what they are called."""
GAUSSIAN, FLAT, RED = "gaussian", "flat", "red"
LIGHTS: Mapping[str, str] = {GAUSSIAN: "Gaussian", FLAT: "flat-topped", RED: "red"}
"""Lights, and what they are called."""
SATURATED = 0.6
"""Share of a flat-topped light's radius in which the sensor overflows."""
LASER_RED = (1.0, 0.2, 0.1)


@dataclass(frozen=True)
class Variant:
    """An attack.

    Args:
        sensor: `LIDAR`, or `CAMERA`.
        kind: One of `FORMS`, or of `LIGHTS`.
        amount: Points of a bogus object, 0 for as many as the LiDAR's own beams meet; or the peak
            of a light, grey levels.
        size: Radius of a light in shares of the image's width; 0 of a bogus object.
        scan: Points that are left of the LiDAR's scan, 0 for all.
    """

    sensor: str
    kind: str
    amount: float
    size: float = 0.0
    scan: int = 0

    @property
    def name(self) -> str:
        """What results are filed under."""
        size = f" {self.size:g}" if self.size else ""
        return f"{self.kind} {self.amount:g}{size} of {self.scan}"

    @property
    def of_thesis(self) -> bool:
        """Whether it has what the thesis states: a plane; a Gaussian light of 187 to 375 px."""
        radius = self.size * KITTI_SIZE[0]
        is_light = self.kind == GAUSSIAN and THESIS_RADII[0] - 1 <= radius <= THESIS_RADII[1] + 1
        return self.kind == PLANE or is_light


class Bogus(NamedTuple):
    """A bogus object in a frame."""

    tampered: TamperedFrame
    place: Boxes3D
    """Where it stands, as one box."""


def lit(variant: Variant, frame: SensorFrame, camera: int, seed: Seed) -> SensorFrame:
    """The frame with a light in one camera; of one seed all lights stand at one place.

    Args:
        variant: One of a camera.
        frame: The frame.
        camera: The camera.
        seed: Seed of the place.
    """
    facula = Facula(
        camera,
        variant.size * KITTI_SIZE[0],
        strength=variant.amount,
        colour=LASER_RED if variant.kind == RED else (1.0, 1.0, 1.0),
        saturation=SATURATED if variant.kind == FLAT else 0.0,
    )
    return facula.attack(frame, seed).frame


def with_bogus_object(
    variant: Variant,
    frame: SensorFrame,
    car: ObjectScan | None,
    rings: frozenset[int] | None,
    seed: Seed,
) -> Bogus | None:
    """The frame with a bogus object; of one seed all stand at one place.

    Args:
        variant: One of the LiDAR.
        frame: The frame, its scan thinned as the variant has it.
        car: The scan of a car; without one there is no cloud.
        rings: Rings that the scan has; what the LiDAR's own beams meet lies on these alone.  None:
            all.
        seed: Seed of the place.

    Returns:
        None where no car is known, or nothing of the object is left.
    """
    count, reference = int(variant.amount), SYSTEM.reference
    if variant.kind == CLOUD:
        if car is None:
            return None
        tampered = CarInView(resampled_scan(car, count, seed), reference, False).attack(frame, seed)
    else:
        tampered = BogusObject(variant.kind, count, reference=reference).attack(frame, seed)
    if not count and rings is not None:
        tampered = _on_rings(tampered, rings)
    assert tampered.points is not None
    if not tampered.points.any():
        return None
    if variant.kind == CLOUD:
        assert car is not None
        return Bogus(tampered, pasted_box(car, tampered))
    return Bogus(tampered, bogus_patch(tampered))


def _on_rings(tampered: TamperedFrame, rings: frozenset[int]) -> TamperedFrame:
    """Without the bogus points that lie on other rings."""
    bogus, points = tampered.points, tampered.frame.points
    assert bogus is not None
    kept = ~bogus | np.isin(rings_of(points), sorted(rings))
    return TamperedFrame(
        tampered.frame.with_points(points[kept]), points=bogus[kept], settings=tampered.settings
    )


def is_of_lidar(variant: Variant) -> bool:
    """Whether the LiDAR is attacked."""
    return variant.sensor == LIDAR
