"""The pose and the optics of a camera, and its rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s


@dataclass(frozen=True, eq=False)
class PinholeCamera:
    """The pose and the optics of a camera.

    Args:
        to_world: Transform from its frame (x right, y down, z forward) to the world, shape (4, 4).
        focal_length: Focal length, pixels.
        centre: Principal point u, v, pixels.
        size: Width and height of the image, pixels.
    """

    to_world: Floats
    focal_length: float
    centre: tuple[float, float]
    size: tuple[int, int]


def pixel_grid(width: int, height: int, step: int = 1) -> Float32s:
    """Columns and rows of every step-th pixel, row by row, shape (n, 2)."""
    columns, rows = np.arange(0, width, step), np.arange(0, height, step)
    u, v = np.meshgrid(columns, rows)
    return np.stack([u.ravel(), v.ravel()], axis=-1).astype(np.float32)


def camera_rays(camera: PinholeCamera, pixels: Float32s) -> tuple[Float32s, Float32s]:
    """Origins and unit directions of rays through pixels, shape (n, 3) each."""
    origins = np.empty((len(pixels), 3), np.float32)
    origins[:] = camera.to_world[:3, 3].astype(np.float32)
    directions = np.empty((len(pixels), 3), np.float32)
    rotation = np.ascontiguousarray(camera.to_world[:3, :3], np.float32)
    _directions(
        pixels,
        rotation,
        np.float32(camera.focal_length),
        np.float32(camera.centre[0]),
        np.float32(camera.centre[1]),
        directions,
    )
    return origins, directions


@kernel(error_model="numpy")
def _directions(pixels, rotation, focal_length, centre_u, centre_v, directions):
    """Unit vectors through pixels, into `directions`."""
    one = np.float32(1.0)
    for i in range(len(pixels)):
        x = (pixels[i, 0] - centre_u) / focal_length
        y = (pixels[i, 1] - centre_v) / focal_length
        scale = one / np.sqrt(x * x + y * y + one)
        for k in range(3):
            directions[i, k] = (rotation[k, 0] * x + rotation[k, 1] * y + rotation[k, 2]) * scale
