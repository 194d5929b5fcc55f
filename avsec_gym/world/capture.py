"""A posed scene, rendered with all sensors of a vehicle: images, scan, labels, depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from avsec_gym.frame import Image
from avsec_gym.geometry import Floats
from avsec_gym.rig import KITTI_FOCAL_LENGTH, SensorRig
from avsec_gym.world.labels import FrameLabels, label_frame
from avsec_gym.world.mesh import Float32s
from avsec_gym.world.motion import moving_bodies, sensor_motion
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.camera import PinholeCamera
from avsec_gym.world.rendering.image_sensor import draw_sensors
from avsec_gym.world.rendering.lidar import Lidar, Scan
from avsec_gym.world.rendering.lidar_body import free_of_body
from avsec_gym.world.rendering.relief import draw_relief
from avsec_gym.world.rendering.renderer import Geometry, Renderer
from avsec_gym.world.rendering.silhouettes import silhouettes

__all__ = [
    "Capture",
    "Float32s",
    "FrameLabels",
    "Geometry",
    "Lidar",
    "PinholeCamera",
    "Renderer",
    "Scan",
    "Sweep",
    "pinhole",
    "render",
    "renderer_of",
    "scan_of",
]

_CAMERA_SEED, _LIDAR_SEED, _DEVICE_SEED = 11, 12, 13


class Sweep(StrEnum):
    """What a scan does with the tenth of a second that the LiDAR needs for a turn.

    In all three the scan's pose is that at the trigger of the cameras, when the head faces ahead.
    """

    INSTANT = "instant"
    """All pulses leave at that time."""
    ROLLING = "rolling"
    """Each pulse leaves at its own time, from where the vehicle is then, and meets moving objects
    where they are then; points lie in the velodyne frame of their own pulse, as in KITTI's raw
    and object data: no motion is compensated."""
    COMPENSATED = "compensated"
    """The same, with the vehicle's own motion compensated, as in KITTI's odometry data: points lie
    in the velodyne frame of the trigger; moving objects stay smeared."""


@dataclass(frozen=True, eq=False)
class Capture:
    """What one vehicle's sensors measure at one instant, and the truth beside it.

    Args:
        images: Images by camera number.
        scan: The LiDAR's scan; None without a LiDAR.
        labels: Labels of what the reference camera sees.
        geometry: Depth, object ids and surfaces in the reference camera.
        disparity: Disparity of the reference camera against the camera `partner`, pixels, NaN for
            the sky and without a partner, shape (H, W).
        partner: The camera to the right of the reference camera that the disparity belongs to.
    """

    images: dict[int, Image]
    scan: Scan | None
    labels: FrameLabels
    geometry: Geometry
    disparity: Float32s
    partner: int | None


def render(
    posed: PosedScene,
    *,
    ego: int = 0,
    cameras: Sequence[int] = (2, 3),
    lidar: Lidar | None = Lidar(),
    sweep: Sweep = Sweep.INSTANT,
    renderer: Renderer | None = None,
) -> Capture:
    """Render a scene with the sensors of one ego vehicle.

    Args:
        posed: The scene.
        ego: Number of the ego vehicle among those of the instant.
        cameras: Numbers of the cameras to render.
        lidar: The LiDAR to scan with; None for no scan. Without a seed, it is a device of the
            vehicle's own, the same over a drive.
        sweep: How the scan treats motion during a turn.
        renderer: Result of `renderer_of` for this scene and vehicle, if it exists already.
    """
    instant, rig = posed.instant, posed.rig
    pose = posed.vehicle_to_world[ego]
    own = instant.egos[ego]
    renderer = renderer or renderer_of(posed, ego)
    reference, partner = rig.stereo_pair
    # Seeded without the frame's number: a vehicle's cameras keep gain and focus over a drive.
    made = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*posed.seed[:2], own))))
    sensors = dict(zip(rig.cameras, draw_sensors(made, len(rig.cameras)), strict=True))
    # A rig of fewer pixels has the images of the full one, resampled.
    share = rig.calibration.focal_length(reference) / KITTI_FOCAL_LENGTH
    if share < 1.0:
        sensors = {camera: sensor.resampled(share) for camera, sensor in sensors.items()}
    # Render the cameras; the reference camera's geometry is the truth, rendered or not.
    images: dict[int, Image] = {}
    geometry = None
    for camera in cameras:
        view = renderer.view(pinhole(rig, camera, pose))
        if camera == reference:
            geometry = view.geometry
        images[camera] = sensors[camera].expose(
            view.light + view.dazzle, _generator(posed, own, _CAMERA_SEED, camera)
        )
    looking = pinhole(rig, reference, pose)
    if geometry is None:
        geometry = renderer.geometry(looking)
    # Label what that camera sees: occlusion is the share of an actor's own silhouette.
    alone = silhouettes(renderer.scene, looking, len(instant.actors))
    labels = label_frame(instant.actors, rig, pose, geometry, alone, own)
    # Scan, with the vehicle's own body in the LiDAR's way.
    scan = None
    if lidar is not None:
        scan = scan_of(posed, ego, lidar, sweep, renderer)
    # Disparity follows from depth: d = f B / Z.
    baseline = 0.0 if partner is None else rig.calibration.baseline(reference, partner)
    disparity = np.where(
        np.isfinite(geometry.depth) & (baseline > 0),
        rig.calibration.focal_length(reference) * baseline / geometry.depth,
        np.nan,
    )
    return Capture(images, scan, labels, geometry, disparity.astype(np.float32), partner)


def scan_of(posed: PosedScene, ego: int, lidar: Lidar, sweep: Sweep, renderer: Renderer) -> Scan:
    """The scan of one of the ego vehicles alone; see `render`."""
    own = posed.instant.egos[ego]
    if lidar.seed is None:
        device = np.random.SeedSequence((*posed.seed[:2], own, _DEVICE_SEED))
        lidar = replace(lidar, seed=int(device.generate_state(1)[0]))
    # Where the velodyne is when each column fires, and what moves meanwhile.
    to_world = posed.vehicle_to_world[ego] @ posed.rig.velodyne_pose
    rolling = sweep is not Sweep.INSTANT
    motion = sensor_motion(posed.instant, ego)
    if rolling and not motion.stands:
        moved = posed.vehicle_to_world[ego] @ motion.transforms(lidar.firing_times)
        to_world = moved @ posed.rig.velodyne_pose
    return lidar.scan(
        renderer,
        to_world,
        _generator(posed, own, _LIDAR_SEED),
        free_of_body(lidar),
        bodies=moving_bodies(posed.instant, ego) if rolling else (),
        relief=draw_relief(posed.site.seed),
        compensated=sweep is Sweep.COMPENSATED,
    )


def renderer_of(posed: PosedScene, ego: int = 0) -> Renderer:
    """The renderer of the scene around one of an instant's ego vehicles."""
    instant = posed.instant
    return posed.built.renderer(instant.actors, instant.egos[ego], instant.egos)


def pinhole(rig: SensorRig, camera: int, vehicle_to_world: Floats) -> PinholeCamera:
    """A rig's camera in the world."""
    projection = rig.calibration.projection(camera)
    return PinholeCamera(
        vehicle_to_world @ rig.camera_pose(camera),
        float(projection[0, 0]),
        (float(projection[0, 2]), float(projection[1, 2])),
        rig.size,
    )


def _generator(posed: PosedScene, *numbers: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence((*posed.seed, *numbers))))
