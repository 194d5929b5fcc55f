"""How much of the image each object would fill if nothing stood in front of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.world.rendering.camera import PinholeCamera
from avsec_gym.world.rendering.ray_scene import RayScene

_NEAR = 0.1


class Silhouettes(NamedTuple):
    """N objects, each as a camera would see it alone."""

    area: NDArray[np.int64]
    """Pixels inside the image, shape (N,)."""
    extent: Floats
    """Left, top, right, bottom in pixels, also beyond the image's borders, shape (N, 4); NaN
    for objects behind the camera."""


def silhouettes(scene: RayScene, camera: PinholeCamera, count: int) -> Silhouettes:
    """Draw each object alone.

    Args:
        scene: The scene; its objects have the ids 0 to `count` - 1.
        camera: The view.
        count: Number of objects N.
    """
    faces = scene.faces[scene.object_id >= 0]
    owner = scene.object_id[scene.object_id >= 0]
    used, index = np.unique(faces, return_inverse=True)
    to_camera = np.linalg.inv(camera.to_world)
    places = scene.vertices[used] @ to_camera[:3, :3].T + to_camera[:3, 3]
    triangles, owner = _before_camera(places[index.reshape(-1, 3)], owner)
    pixels = camera.focal_length * triangles[..., :2] / triangles[..., 2:] + np.array(camera.centre)
    area = np.zeros(count, np.int64)
    extent = np.full((count, 4), np.nan)
    _draw(pixels, owner, camera.size[0], camera.size[1], area, extent)
    return Silhouettes(area, extent)


def _before_camera(triangles: Floats, owner: NDArray[np.int32]) -> tuple[Floats, NDArray[np.int32]]:
    """What of triangles lies beyond the near plane, sorted by owner."""
    behind = triangles[..., 2] < _NEAR
    count = behind.sum(axis=1)
    parts, owners = [triangles[count == 0]], [owner[count == 0]]
    for which in (1, 2):
        cut = count == which
        odd = np.argmax(behind[cut] == (which == 1), axis=1)
        turned = (odd[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(triangles[cut], turned[..., None], axis=1), 1, 0)
        ab, ac = _on_near_plane(a, b), _on_near_plane(a, c)
        pieces = [(ab, b, c), (ab, c, ac)] if which == 1 else [(a, ab, ac)]
        parts += [np.stack(piece, axis=1) for piece in pieces]
        owners += [owner[cut]] * len(pieces)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(parts)[order], owner[order]


def _on_near_plane(one: Floats, two: Floats) -> Floats:
    share = (_NEAR - one[:, 2:]) / (two[:, 2:] - one[:, 2:])
    return one + share * (two - one)


@kernel(error_model="numpy")
def _draw(triangles, owner, width, height, area, extent):
    """Add up areas and extents of triangles in pixels, into the last two arguments.

    Invariant: triangles are sorted by owner, so that `last`, the owner that covered a pixel last,
    keeps a pixel from counting twice for one owner.
    """
    last = np.full((height, width), -1, np.int32)
    for i in range(len(triangles)):
        x0, y0 = triangles[i, 0]
        x1, y1 = triangles[i, 1]
        x2, y2 = triangles[i, 2]
        who = owner[i]
        # The extent also counts what lies outside of the image.
        low_x, high_x = min(x0, x1, x2), max(x0, x1, x2)
        low_y, high_y = min(y0, y1, y2), max(y0, y1, y2)
        if np.isnan(extent[who, 0]):
            extent[who, 0], extent[who, 1] = low_x, low_y
            extent[who, 2], extent[who, 3] = high_x, high_y
        else:
            extent[who, 0] = min(extent[who, 0], low_x)
            extent[who, 1] = min(extent[who, 1], low_y)
            extent[who, 2] = max(extent[who, 2], high_x)
            extent[who, 3] = max(extent[who, 3], high_y)
        # Cover the pixels inside; the sign makes both windings alike.
        turn = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if turn == 0.0:
            continue
        sign = 1.0 if turn > 0 else -1.0
        first_row, last_row = max(int(np.ceil(low_y)), 0), min(int(np.floor(high_y)), height - 1)
        first, final = max(int(np.ceil(low_x)), 0), min(int(np.floor(high_x)), width - 1)
        for row in range(first_row, last_row + 1):
            for column in range(first, final + 1):
                if last[row, column] == who:
                    continue
                a = ((x1 - x0) * (row - y0) - (column - x0) * (y1 - y0)) * sign
                b = ((x2 - x1) * (row - y1) - (column - x1) * (y2 - y1)) * sign
                c = ((x0 - x2) * (row - y2) - (column - x2) * (y0 - y2)) * sign
                if a >= 0 and b >= 0 and c >= 0:
                    last[row, column] = who
                    area[who] += 1
