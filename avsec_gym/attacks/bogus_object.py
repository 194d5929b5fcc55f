"""A bogus object on the LiDAR: a plane or a shell, of as many points as the attacker can place.

The thesis states the size of its bogus return, not how dense its points are, nor how deep they
reach; both decide what is detected and what a detector believes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.argument_checks import (
    camera_number,
    keep_checked,
    label,
    number,
    number_or_range,
    one_of,
    whole_number,
)
from avsec_gym.attacks.argument_domains import ANGLES, DISTANCES, SHARES, WIDTHS
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.lidar_spoofing import RANGE_NOISE, LidarSpoofing, lidar_beams
from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.rig import SensorRig
from avsec_gym.sensor_system import LIDAR, Sensor

PLANE, SHELL = "plane", "shell"
FORMS = (PLANE, SHELL)
_MOST_POINTS = 1_000_000
_RESAMPLED_APART = 0.02
"""Metres; points of a scan that are drawn twice do not coincide."""


@dataclass(frozen=True)
class BogusObject:
    """Bogus points where `LidarSpoofing` has its plane by the same seed, facing the LiDAR.

    A plane is a rectangle.  A shell is the surface of a box behind that rectangle: front, back,
    sides and top.  An attacker who delays pulses is not bound to what a real box would hide.

    Args:
        form: ``plane`` or ``shell``.
        points: Number of points, spread evenly over the surface; 0: one for each of the LiDAR's own
            beams that meets it, which of a shell lies on its near or its far side by chance.
        width: Width, metres.
        height: Height from the road up, metres.
        depth: Depth of a shell, metres.
        distance: Distance from the LiDAR along the ground, metres, as of `LidarSpoofing`.
        bearing: Bearing from the LiDAR, radians, as of `LidarSpoofing`.
        reference: Number of the reference camera, as of `LidarSpoofing`.
        reflectance: Reflectance of the points.
        noise: Standard deviation of ranges, metres.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: No such form, or a number that cannot be.
    """

    form: str = PLANE
    points: int = 0
    width: float = 2.5
    height: float = 1.5
    depth: float = 2.5
    distance: float | tuple[float, float] = (6.0, 10.0)
    bearing: float | None = None
    reference: int = 2
    reflectance: float = 0.3
    noise: float = RANGE_NOISE
    name: str = "bogus_object"

    def __post_init__(self) -> None:
        bearing = self.bearing
        checked = {
            "form": one_of("form", self.form, FORMS),
            "points": whole_number("points", self.points, 0, _MOST_POINTS),
            "width": number("width", self.width, *WIDTHS),
            "height": number("height", self.height, *WIDTHS),
            "depth": number("depth", self.depth, *WIDTHS),
            "distance": number_or_range("distance", self.distance, *DISTANCES),
            "bearing": None if bearing is None else number("bearing", bearing, *ANGLES),
            "reference": camera_number("reference", self.reference),
            "reflectance": number("reflectance", self.reflectance, *SHARES),
            "noise": number("noise", self.noise, *SHARES),
            "name": label("name", self.name),
        }
        keep_checked(self, checked)

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The LiDAR."""
        return frozenset({LIDAR})

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The frame with the object's points after its own.  See `OpticalAttack.attack`.

        Raises:
            ConfigurationError: The reference camera's view is too narrow for the object.
            DataError: No scan, or no image of the reference camera to draw the bearing in.
        """
        distance, bearing = LidarSpoofing(
            self.width,
            self.height,
            self.distance,
            self.bearing,
            self.reference,
        ).place(frame, seed)
        pose = SensorRig(frame.calibration).velodyne_pose
        # Not the stream that the place is drawn from.
        random = np.random.default_rng([*np.atleast_1d(seed), 1])
        surface = (
            self._met(pose, distance, bearing, random)
            if not self.points
            else (self._spread(distance, random))
        )
        # From (towards, across, up) at the LiDAR's foot to the vehicle, and on to the LiDAR.
        cos, sin = np.cos(bearing), np.sin(bearing)
        turned = surface @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        foot = pose[:3, 3] * [1, 1, 0]
        places = transform_points(np.linalg.inv(pose), turned + foot)
        ranges = np.linalg.norm(places, axis=1, keepdims=True)
        places *= 1 + self.noise * random.standard_normal(ranges.shape) / ranges
        bogus = np.c_[places, np.full(len(places), self.reflectance)].astype(np.float32)
        scan = frame.points
        return TamperedFrame(
            frame.with_points(np.concatenate([scan, bogus])),
            points=np.arange(len(scan) + len(bogus)) >= len(scan),
            settings={"distance": distance, "bearing": bearing},
        )

    def _met(
        self, pose: Floats, distance: float, bearing: float, random: np.random.Generator
    ) -> Floats:
        """Where the LiDAR's beams meet the surface, shape (N, 3): towards, across, up."""
        ahead, left, up = (lidar_beams(random.random()) @ pose[:3, :3].T).T
        cos, sin = np.cos(bearing), np.sin(bearing)
        beams = np.stack([ahead * cos + left * sin, left * cos - ahead * sin, up], axis=1)
        depth = self.depth if self.form == SHELL else 0.0
        low = np.array([distance, -self.width / 2, -pose[2, 3]])
        high = np.array([distance + depth, self.width / 2, self.height - pose[2, 3]])
        with np.errstate(divide="ignore", invalid="ignore"):
            faces = np.stack([low, high])[:, None] / beams
        enters, leaves = faces.min(axis=0).max(axis=1), faces.max(axis=0).min(axis=1)
        met = (enters <= leaves) & (enters > 0)
        reach = np.where(random.random(len(beams)) < 0.5, enters, leaves)
        return np.asarray(beams[met] * reach[met, None] + [0.0, 0.0, pose[2, 3]])

    def _spread(self, distance: float, random: np.random.Generator) -> Floats:
        """Evenly drawn places of the surface, shape (N, 3): towards, across, up."""
        w, h, d = self.width, self.height, self.depth
        # Of each face one corner and two edges.
        corner = np.array([distance, -w / 2, 0.0])
        towards, across, up = np.diag([d, w, h])
        faces = [(corner, across, up)]
        if self.form == SHELL:
            faces += [
                (corner + towards, across, up),
                (corner, towards, up),
                (corner + across, towards, up),
                (corner + up, towards, across),
            ]
        corners, first, second = (np.array(part) for part in zip(*faces, strict=True))
        areas = np.linalg.norm(np.cross(first, second), axis=1)
        face = random.choice(len(faces), self.points, p=areas / areas.sum())
        shares = random.random((2, self.points, 1))
        return np.asarray(corners[face] + shares[0] * first[face] + shares[1] * second[face])


def resampled_scan(scan: ObjectScan, points: int, seed: Seed = 0) -> ObjectScan:
    """An object's scan of another density.

    Args:
        scan: What a LiDAR saw of the object.
        points: Number of points, 1 or more; 0: as it is.  Fewer are drawn from its own; of more,
            its own and 2 cm around some of them.
        seed: Seed of the draw.

    Raises:
        ConfigurationError: The number cannot be.
    """
    count = whole_number("points", points, 0, _MOST_POINTS)
    if not count:
        return scan
    random, own = np.random.default_rng(seed), len(scan.points)
    if count <= own:
        return replace(scan, points=scan.points[np.sort(random.choice(own, count, replace=False))])
    more = scan.points[random.integers(own, size=count - own)]
    more[:, :3] += _RESAMPLED_APART * random.standard_normal((len(more), 3)).astype(np.float32)
    return replace(scan, points=np.concatenate([scan.points, more]))
