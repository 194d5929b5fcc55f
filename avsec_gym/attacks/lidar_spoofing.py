"""A bogus return: a LiDAR is made to see an upright plane that is not there (section 3.2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import (
    camera_number,
    flag,
    keep_checked,
    label,
    number,
    number_or_range,
)
from avsec_gym.attacks.argument_domains import ANGLES, DISTANCES, SHARES, WIDTHS
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.rig import SensorRig
from avsec_gym.sensor_system import LIDAR, Sensor

RING_ELEVATIONS = np.radians(np.r_[np.linspace(2.4, -7.8, 32), np.linspace(-8.35, -23.6, 32)])
"""Elevations of the 64 lasers of a Velodyne HDL-64E, radians, from the highest down."""
_COLUMNS = 2007
RANGE_NOISE = 0.01
"""Standard deviation of ranges, metres."""
_BEARINGS = np.radians(np.linspace(-90.0, 90.0, 1801))


@dataclass(frozen=True)
class LidarSpoofing:
    """Points of a plane patch that stands on the road and faces the LiDAR; defaults: the thesis'.

    The attacker fires into the LiDAR in step with it, so the points lie where the LiDAR's own beams
    meet the patch: those of the Velodyne HDL-64E as KITTI's scans show them, 64 rings, 0.18 degrees
    from pulse to pulse, ranges good to 1 cm.  The road is flat, 1.65 m below the cameras.

    Args:
        width: Width of the patch, metres.
        height: Height of the patch from the road up, metres.
        distance: Distance from the LiDAR to the patch along the ground, metres; two numbers: drawn
            between them.
        bearing: Bearing of its middle from the LiDAR, radians to the left of ahead; None: drawn
            from those at which the reference camera sees the patch in its whole width.  Its foot
            may be below the image, where the road before the car is too.
        reference: Number of the reference camera.
        rays_lost: Whether a beam that meets the patch returns nothing from behind it; in the thesis
            points are added.  What stands nearer keeps its own echo beside the bogus one, which
            the attacker's light brings from elsewhere: a LiDAR that reports both is assumed.
        reflectance: Reflectance of the bogus points; 0.3 is common near KITTI's car.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    width: float = 2.5
    height: float = 1.5
    distance: float | tuple[float, float] = (6.0, 10.0)
    bearing: float | None = None
    reference: int = 2
    rays_lost: bool = False
    reflectance: float = 0.3
    name: str = "lidar_spoofing"

    def __post_init__(self) -> None:
        bearing = self.bearing
        checked = {
            "width": number("width", self.width, *WIDTHS),
            "height": number("height", self.height, *WIDTHS),
            "distance": number_or_range("distance", self.distance, *DISTANCES),
            "bearing": None if bearing is None else number("bearing", bearing, *ANGLES),
            "reference": camera_number("reference", self.reference),
            "rays_lost": flag("rays_lost", self.rays_lost),
            "reflectance": number("reflectance", self.reflectance, *SHARES),
            "name": label("name", self.name),
        }
        keep_checked(self, checked)

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The LiDAR."""
        return frozenset({LIDAR})

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The frame with bogus points after its own.  See `OpticalAttack.attack`.

        Raises:
            ConfigurationError: The reference camera's view is too narrow for the patch.
            DataError: No scan, or no image of the reference camera to draw the bearing in.
        """
        scan = frame.points
        rig = SensorRig(frame.calibration)
        random = np.random.default_rng(seed)
        distance, bearing = self._place(frame, rig, random)
        beams = lidar_beams(random.random())
        reach = self._reach(beams, rig, distance, bearing)
        met = np.isfinite(reach)
        places = (
            beams[met] * (reach[met] + RANGE_NOISE * random.standard_normal(met.sum()))[:, None]
        )
        bogus = np.c_[places, np.full(len(places), self.reflectance)].astype(np.float32)
        lost = self._reach(scan[:, :3], rig, distance, bearing) < 1 if self.rays_lost else None
        kept = scan if lost is None else scan[~lost]
        return TamperedFrame(
            frame.with_points(np.concatenate([kept, bogus])),
            points=np.arange(len(kept) + len(bogus)) >= len(kept),
            lost=lost,
            settings={"distance": distance, "bearing": bearing},
        )

    def place(self, frame: SensorFrame, seed: Seed = 0) -> tuple[float, float]:
        """The distance and the bearing that `attack` draws by this seed; raises as that does."""
        return self._place(frame, SensorRig(frame.calibration), np.random.default_rng(seed))

    def _place(
        self, frame: SensorFrame, rig: SensorRig, random: np.random.Generator
    ) -> tuple[float, float]:
        distance, share = random.uniform(*np.broadcast_to(self.distance, 2)), random.random()
        if self.bearing is not None:
            return float(distance), float(self.bearing)
        first, last = self._bearings_in_view(frame, rig, distance)
        return float(distance), float(first + share * (last - first))

    def _reach(
        self, rays: NDArray[np.floating], rig: SensorRig, distance: float, bearing: float
    ) -> Floats:
        """How many times its own length each ray of the LiDAR goes to meet the patch.

        Args:
            rays: Unit vectors in the velodyne frame, shape (N, 3).
            rig: The sensors of the vehicle, the LiDAR's pose among them.
            distance: Distance of the patch, metres.
            bearing: Bearing of its middle, radians.

        Returns:
            Shape (N,); infinite where a ray misses it.
        """
        pose = rig.velodyne_pose
        ahead, left, up = (rays.astype(float) @ pose[:3, :3].T).T
        cos, sin = np.cos(bearing), np.sin(bearing)
        towards, across = ahead * cos + left * sin, left * cos - ahead * sin
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = distance / towards
            above_road = pose[2, 3] + reach * up
            meets = (towards > 0) & (np.abs(reach * across) <= self.width / 2)
            meets &= (above_road >= 0) & (above_road <= self.height)
        return np.where(meets, reach, np.inf)

    def _bearings_in_view(
        self, frame: SensorFrame, rig: SensorRig, distance: float
    ) -> tuple[float, float]:
        """The rightmost and the leftmost, to a tenth of a degree."""
        columns = frame.image(self.reference).shape[1]
        forward = np.stack([np.cos(_BEARINGS), np.sin(_BEARINGS), 0 * _BEARINGS], axis=-1)
        sideways = np.stack([-forward[:, 1], forward[:, 0], 0 * _BEARINGS], axis=-1)
        foot = rig.velodyne_pose[:3, 3] * [1, 1, 0] + distance * forward
        # The camera looks level: all heights of an edge are seen in one column.
        edges = [foot + side * sideways for side in (-self.width / 2, self.width / 2)]
        in_camera = transform_points(np.linalg.inv(rig.camera_to_vehicle), np.stack(edges))
        pixels, depth = project(frame.calibration.projection(self.reference), in_camera)
        seen = (depth > 0) & (pixels[..., 0] >= 0) & (pixels[..., 0] <= columns - 1)
        whole = _BEARINGS[seen.all(axis=0)]
        if not len(whole):
            raise ConfigurationError(
                f"camera {self.reference} nowhere sees the whole width of {self.width} m at a "
                f"distance of {distance:.1f} m: make it narrower, or give a bearing"
            )
        return float(whole[0]), float(whole[-1])


def lidar_beams(phase: float) -> Floats:
    """Directions of one turn's pulses in the velodyne frame, shape (64 * 2007, 3).

    Args:
        phase: Share of the way from one pulse to the next at which the turn begins.
    """
    azimuth = (np.arange(_COLUMNS) + phase) * (2 * np.pi / _COLUMNS)
    up = RING_ELEVATIONS[:, None]
    rays = np.empty((len(up), _COLUMNS, 3))
    rays[..., 0], rays[..., 1] = np.cos(up) * np.cos(azimuth), np.cos(up) * np.sin(azimuth)
    rays[..., 2] = np.sin(up)
    return rays.reshape(-1, 3)
