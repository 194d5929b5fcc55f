"""The scan of a real object, pasted into a cloud where no object is (thesis, section 4.5)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.argument_checks import flag, keep_checked, label, number, number_or_range, shown
from avsec_gym.attacks.argument_domains import ANGLES, DISTANCES
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.object_scan import ObjectScan, object_pose, read_object_scan
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.attacks.tampered_scan import inject_object
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import SensorRig
from avsec_gym.sensor_system import LIDAR, Sensor


def paste_scan(
    frame: SensorFrame,
    scan: ObjectScan,
    pose: tuple[float, float, float],
    *,
    bottom: float = 0.0,
    rays_lost: bool = False,
) -> TamperedFrame:
    """A frame with an object's points after its own.

    The points stay where they are on the object: what was scanned from afar is sparse nearby.

    Args:
        frame: A frame with a scan.
        scan: The scan of the object that is pasted.
        pose: The pose of the object: x ahead of camera 0, y to its left (metres), heading
            (radians), as in `Boxes3D.poses`.
        bottom: Height of the object above the plane 1.65 m below the cameras, metres.
        rays_lost: Whether beams that meet the object's box return nothing from in or behind it.

    Raises:
        ConfigurationError: The LiDAR would be inside of the box, or the pose is not finite.
        DataError: The frame has no scan.
    """
    if not np.isfinite([*pose, bottom]).all():
        raise ConfigurationError(f"an object is pasted at a finite place, got {(*pose, bottom)}")
    to_velodyne = np.linalg.inv(SensorRig(frame.calibration).velodyne_pose) @ object_pose(
        np.asarray(pose, float), bottom
    )
    tampered = inject_object(frame.points, scan, to_velodyne, rays_lost=rays_lost)
    return TamperedFrame(
        frame.with_points(tampered.points),
        points=tampered.bogus,
        lost=tampered.lost if rays_lost else None,
        settings={"x": float(pose[0]), "y": float(pose[1]), "heading": float(pose[2])},
    )


@dataclass(frozen=True, eq=False)
class PastedScan:
    """An object's scan at a random place around the car, on the road.

    Args:
        scan: The scan of the object, or a file that `write_object_scan` wrote.
        distance: Distance from the LiDAR along the ground, metres; two numbers: drawn between them.
        bearing: Bearing of the object from the LiDAR, radians to the left of ahead; None: drawn
            from the whole circle.
        heading: Heading of the object, radians; None: such that the sides that were scanned face
            the LiDAR, as they must to be seen.
        rays_lost: Whether rays that meet the object are lost, see `paste_scan`.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be, or something else than a scan.
        DataError: The file is missing or broken.
    """

    scan: ObjectScan | str | Path
    distance: float | tuple[float, float] = (6.0, 40.0)
    bearing: float | None = None
    heading: float | None = None
    rays_lost: bool = False
    name: str = "pasted_scan"
    _scan: ObjectScan = field(init=False, repr=False)

    def __post_init__(self) -> None:
        scan = read_object_scan(self.scan) if isinstance(self.scan, str | Path) else self.scan
        if not isinstance(scan, ObjectScan):
            raise ConfigurationError(
                "scan takes the scan of an object, or a file that `write_object_scan` wrote, got "
                f"{shown(scan)}"
            )
        object.__setattr__(self, "_scan", scan)
        checked: dict[str, Any] = {
            "distance": number_or_range("distance", self.distance, *DISTANCES),
            "rays_lost": flag("rays_lost", self.rays_lost),
            "name": label("name", self.name),
        }
        for name in ("bearing", "heading"):
            if (angle := getattr(self, name)) is not None:
                checked[name] = number(name, angle, *ANGLES)
        keep_checked(self, checked)

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The LiDAR."""
        return frozenset({LIDAR})

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The frame with the object's points after its own.  See `OpticalAttack.attack`."""
        random = np.random.default_rng(seed)
        distance, drawn = random.uniform(*np.broadcast_to(self.distance, 2)), random.random()
        bearing = 2 * np.pi * (drawn - 0.5) if self.bearing is None else self.bearing
        x, y = SensorRig(frame.calibration).velodyne_pose[:2, 3]
        ahead, left = self._scan.seen_from
        # From the object the LiDAR is seen backwards along the bearing.
        facing = bearing + np.pi - np.arctan2(left, ahead)
        pose = (
            x + distance * np.cos(bearing),
            y + distance * np.sin(bearing),
            facing if self.heading is None else self.heading,
        )
        return paste_scan(frame, self._scan, pose, rays_lost=self.rays_lost)
