"""What LiDARs measure on a plain with two cars, and with a ghost: for `connected_sockets.py`."""

import numpy as np

from avsec_gym.validation.connected.sweep import TIP
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.capture import Lidar
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.shapes import box, polygon
from avsec_gym.world.site import Surface

CARS, GHOST = ((14, 3, 0.1), (24, -7, 0.4)), (15, -4, -0.2)
PLACES = ((0, 0, 0), (30, 2, np.pi), (14, -14, np.pi / 2), (22, 12, -2.0))
"""x, y and heading of the vehicles that look, as those of the cars and of the ghost."""


def scan_of(vehicle: int) -> VehicleScan:
    """The scan of one of the vehicles; that of vehicle 1 shows the ghost as well."""
    x, y, heading = PLACES[vehicle]
    cos, sin = np.cos(heading), np.sin(heading)
    pose = np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 1.73], [0, 0, 0, 1]])
    cars = [*CARS, GHOST] if vehicle == 1 else CARS
    plain = polygon([(-99, -99, 0), (99, -99, 0), (99, 99, 0), (-99, 99, 0)])
    meshes = [plain, *(box(4.2, 1.8, 1.5).placed(a, b, 0, yaw) for a, b, yaw in cars)]
    rays = Lidar().directions
    origin = np.tile(np.float32(pose[:3, 3] + [0, 0, TIP]), (len(rays), 1))
    scene = RayScene([Thing(mesh, Surface.ROAD) for mesh in meshes])
    far = scene.hits(origin, np.ascontiguousarray(rays @ pose[:3, :3].T, np.float32)).distance
    points = (rays * far[:, None] + [0, 0, TIP])[far < 80]
    return VehicleScan(np.c_[points, np.full(len(points), 0.3)].astype(np.float32), pose)


def is_ghost(centres: np.ndarray) -> np.ndarray:
    """Whether regions are at the ghost, shape (R,); of their centres, shape (R, 3), metres."""
    return np.hypot(*(centres[:, :2] - GHOST[:2]).T) < 1.5
