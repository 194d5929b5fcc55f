"""What a data set consists of: frames that can be made one by one, in any order, in any process."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from avsec_gym.errors import ConfigurationError
from avsec_gym.rig import SensorRig, kitti_rig
from avsec_gym.world.capture import Sweep
from avsec_gym.world.rendering.lidar import Lidar


@dataclass(frozen=True, eq=False)
class Sensors:
    """Which sensors of a rig are written.

    Args:
        cameras: Numbers of the cameras; the layout's usual ones if empty.
        lidar: Whether scans are written.
        rig: The sensors of the vehicle that looks.
        sweep: How scans treat motion during a turn; as usual for the layout if None.

    Raises:
        ConfigurationError: The rig has no such camera, or one stands twice.
    """

    cameras: tuple[int, ...] = ()
    lidar: bool = True
    rig: SensorRig = field(default_factory=kitti_rig)
    sweep: Sweep | None = None

    def __post_init__(self) -> None:
        unknown = set(self.cameras) - set(self.rig.cameras)
        if unknown or len(set(self.cameras)) < len(self.cameras):
            raise ConfigurationError(
                f"cameras are some of {', '.join(map(str, self.rig.cameras))}, each once; "
                f"got {', '.join(map(str, self.cameras))}"
            )

    @property
    def scanner(self) -> Lidar | None:
        """The LiDAR, if it is wanted."""
        return Lidar() if self.lidar else None

    def or_usual(self, *usual: int) -> tuple[int, ...]:
        """The cameras asked for; without any, those of the usual ones that the rig has."""
        there = tuple(camera for camera in usual if camera in self.rig.cameras)
        return self.cameras or there or self.rig.cameras

    def to_json(self, cameras: tuple[int, ...], usual: Sweep) -> dict[str, Any]:
        """All that decides what the sensors deliver."""
        calibration = self.rig.calibration
        imu = calibration.tr_imu_to_velo
        return {
            "cameras": list(cameras),
            "lidar": self.lidar,
            "sweep": str(self.sweep or usual),
            "rig": {
                "size": list(self.rig.size),
                "camera_height": self.rig.camera_height,
                "projections": calibration.projections.tolist(),
                "r0_rect": calibration.r0_rect.tolist(),
                "tr_velo_to_cam": calibration.tr_velo_to_cam.tolist(),
                "tr_imu_to_velo": None if imu is None else imu.tolist(),
            },
        }


class Recipe(Protocol):
    """A data set; travels to worker processes."""

    @property
    def settings(self) -> dict[str, Any]:
        """JSON-able: all that decides what a frame looks like, but not how many there are."""

    def __len__(self) -> int:
        """How many frames it has."""

    @property
    def last_files(self) -> str:
        """A glob of the files that `last_file` names, relative to the root."""

    def last_file(self, number: int) -> str:
        """The file of a frame that is written last, relative to the root.

        Once it is there, the frame is complete.
        """

    def make(self, root: Path, number: int) -> list[str]:
        """Write a frame, over what an interrupted run left of it.

        A frame whose sources are broken is left out, with a remark.

        Returns:
            Remarks for people.
        """

    def finish(self, root: Path) -> None:
        """Write what belongs to the data set as a whole, from the frames that are there."""
