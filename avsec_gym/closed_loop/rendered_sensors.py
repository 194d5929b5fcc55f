"""What the car's sensors deliver in a procedural drive, rendered from where the car really is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from avsec_gym.closed_loop.relative_poses import Pose
from avsec_gym.closed_loop.tracks import STEP
from avsec_gym.connected_scans import ConnectedScans, ScanPose, SharedScan
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.rig import resized_rig
from avsec_gym.world.capture import Lidar, Sweep, render, renderer_of, scan_of
from avsec_gym.world.drives import DriveScenes, vehicle_poses
from avsec_gym.world.export import measured_pose, pose_errors
from avsec_gym.world.posed_scenes import PosedScene

_FEW_PIXELS = 64


@dataclass(frozen=True, eq=False)
class RenderedSensors:
    """Renders a drive's place with everything where it is now.

    The stereo rig's reference camera stands at the car's centre, as in the thesis' conversion of
    labels, so that a box in the camera frame lies where the planner takes it to be.

    Args:
        scenes: The drive, with the rig that the car carries.
        cameras: Numbers of the cameras to render.
        lidar: The LiDAR to scan with; None: no scan.
        width: Width of the images, pixels, no larger than the rig's; None: the rig's.
        position_noise: Standard deviation of the positions that connected vehicles measure, along x
            and along y, metres.  The drive's other sensor vehicles, if it has any, are connected
            with the car: each scans from where it is, when it is asked to.
        heading_noise: Standard deviation of the headings that they measure, degrees.
    """

    scenes: DriveScenes
    cameras: tuple[int, ...] = (2, 3)
    lidar: Lidar | None = Lidar()  # noqa: RUF009 - frozen.
    width: int | None = None
    position_noise: float = 0.2
    heading_noise: float = 0.2

    def __call__(self, time: float, pose: Pose, others: dict[int, Pose]) -> SensorFrame:
        """The frame at a time.

        Args:
            time: Seconds since the start of the drive; noise and gaits are those of its frame.
            pose: x, y, heading of the car's centre in the world frame.
            others: Where the other actors are, by their ids; one that is not named stays where the
                drive has it.
        """
        number = min(round(time / STEP), len(self.scenes) - 1)
        posed = self.scenes[number]
        actors, ego = posed.instant.actors, posed.instant.egos[0]
        camera = posed.rig.camera_pose(posed.rig.stereo_pair[0])
        # Camera frames look along their z axis: the offset is that of their origin.
        back = float(camera[0, 3])
        own = (pose[0] - back * np.cos(pose[2]), pose[1] - back * np.sin(pose[2]), pose[2])
        poses: Floats = np.array(
            [
                others.get(id, tuple(known))
                for id, known in zip(actors.id.tolist(), actors.pose.tolist(), strict=True)
            ]
        )
        poses[ego] = own
        vehicles = vehicle_poses(posed.site.ground, poses[list(posed.instant.egos)])
        instant = replace(posed.instant, actors=replace(actors, pose=poses))
        # Labels are drawn with every frame: without images, few pixels do for them.
        width = _FEW_PIXELS if not self.cameras else self.width
        rig = posed.rig
        if width is not None and width < rig.size[0]:
            rig = resized_rig(rig, width)
        there = replace(posed, instant=instant, vehicle_to_world=vehicles, rig=rig)
        capture = render(there, cameras=self.cameras, lidar=self.lidar)
        scan = None if capture.scan is None else capture.scan.points
        calibration = rig.calibration if self.cameras else posed.rig.calibration
        neighbours = None
        if self.lidar is not None and len(posed.instant.egos) > 1:
            neighbours = partial(self._shared, there, number, self.lidar)
        return SensorFrame(
            f"{number:010d}", calibration, capture.images, scan, neighbours=neighbours
        )

    def _shared(self, posed: PosedScene, number: int, lidar: Lidar) -> ConnectedScans:
        """What the other sensor vehicles scan at a frame of the drive, all rays at once."""
        seed, drive, _ = self.scenes.world.seed
        places = []
        for vehicle, to_world in enumerate(posed.vehicle_to_world):
            error = pose_errors(seed, drive, vehicle, number + 1)[number]
            pose = to_world @ posed.rig.velodyne_pose
            noise = (self.position_noise, self.heading_noise)
            places.append(ScanPose(measured_pose(pose, error, *noise)))
        others = [
            SharedScan(
                scan_of(posed, vehicle, lidar, Sweep.INSTANT, renderer_of(posed, vehicle)).points,
                places[vehicle],
            )
            for vehicle in range(1, len(places))
        ]
        return ConnectedScans(places[0], tuple(others))
