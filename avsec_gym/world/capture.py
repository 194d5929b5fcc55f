"""One turn of all sensors of a vehicle: images, scan, labels, depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.frame import Image
from avsec_gym.geometry import Floats
from avsec_gym.rig import SensorRig
from avsec_gym.world.labels import FrameLabels, label_frame
from avsec_gym.world.mesh import Float32s
from avsec_gym.world.rendering.camera import PinholeCamera
from avsec_gym.world.rendering.image_sensor import draw_sensors
from avsec_gym.world.rendering.lidar import Lidar, Scan
from avsec_gym.world.rendering.lidar_body import free_of_body
from avsec_gym.world.rendering.renderer import Geometry, Renderer
from avsec_gym.world.rendering.silhouettes import silhouettes
from avsec_gym.world.shots import Shot

_CAMERA_SEED, _LIDAR_SEED = 11, 12


@dataclass(frozen=True, eq=False)
class Capture:
    """What one vehicle's sensors deliver at one moment, and the truth beside it.

    Args:
        images: By camera.
        scan: Of the LiDAR; None without it.
        labels: Of the reference camera.
        geometry: Of the reference camera: depth, object ids, surfaces.
        disparity: Of the reference camera against the camera `partner`, pixels, NaN for the sky
            and without a partner, shape (H, W).
        partner: The camera to the right of the reference camera that the disparity belongs to.
    """

    images: dict[int, Image]
    scan: Scan | None
    labels: FrameLabels
    geometry: Geometry
    disparity: Float32s
    partner: int | None


def take(
    shot: Shot,
    *,
    ego: int = 0,
    cameras: Sequence[int] = (2, 3),
    lidar: Lidar | None = Lidar(),
    renderer: Renderer | None = None,
) -> Capture:
    """Take a shot with the sensors of one ego vehicle.

    Args:
        shot: The scene.
        ego: Which of the moment's ego vehicles.
        cameras: To render.
        lidar: To scan with; None for no scan.
        renderer: What `renderer_of` made of this shot and vehicle, if it stands already.
    """
    moment, rig = shot.moment, shot.rig
    pose = shot.vehicle_to_world[ego]
    own = moment.egos[ego]
    renderer = renderer or renderer_of(shot, ego)
    reference, partner = rig.stereo_pair
    # A vehicle's cameras keep their gain and focus from moment to moment.
    made = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*shot.seed[:2], own))))
    sensors = dict(zip(rig.cameras, draw_sensors(made, len(rig.cameras)), strict=True))
    images: dict[int, Image] = {}
    geometry = None
    for camera in cameras:
        view = renderer.view(pinhole(rig, camera, pose))
        if camera == reference:
            geometry = view.geometry
        images[camera] = sensors[camera].expose(
            view.light, _generator(shot, own, _CAMERA_SEED, camera)
        )
    looking = pinhole(rig, reference, pose)
    if geometry is None:
        geometry = renderer.geometry(looking)
    alone = silhouettes(renderer.scene, looking, len(moment.actors))
    labels = label_frame(moment.actors, rig, pose, geometry, alone, own)
    scan = None
    if lidar is not None:
        free = free_of_body(lidar)
        noise = _generator(shot, own, _LIDAR_SEED)
        scan = lidar.scan(renderer, pose @ rig.velodyne_pose, noise, free)
    baseline = 0.0 if partner is None else rig.calibration.baseline(reference, partner)
    disparity = np.where(
        np.isfinite(geometry.depth) & (baseline > 0),
        rig.calibration.focal_length(reference) * baseline / geometry.depth,
        np.nan,
    )
    return Capture(images, scan, labels, geometry, disparity.astype(np.float32), partner)


def renderer_of(shot: Shot, ego: int = 0) -> Renderer:
    """The scene around one of a moment's ego vehicles, ready to be looked at."""
    moment = shot.moment
    return shot.stage.renderer(moment.actors, moment.egos[ego], moment.egos)


def pinhole(rig: SensorRig, camera: int, vehicle_to_world: Floats) -> PinholeCamera:
    """A rig's camera in the world."""
    projection = rig.calibration.projection(camera)
    return PinholeCamera(
        vehicle_to_world @ rig.camera_pose(camera),
        float(projection[0, 0]),
        (float(projection[0, 2]), float(projection[1, 2])),
        rig.size,
    )


def _generator(shot: Shot, *numbers: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence((*shot.seed, *numbers))))
