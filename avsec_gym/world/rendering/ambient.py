"""Light that does not come straight from the sun: the sky, as far as it is open, and the rest.

Found on a coarse grid of pixels by rays into the half space above each surface, then carried to
every pixel from grid points that lie on the same surface.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s
from avsec_gym.world.rendering.ray_scene import RayScene
from avsec_gym.world.rendering.shading import sky_colour
from avsec_gym.world.rendering.surfaces import Surfaces

RAYS = 8
"""Rays for each point of the grid."""

_FAR = np.float32(1e8)
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


def ambient_light(
    scene: RayScene,
    found: Surfaces,
    hit: NDArray[np.bool_],
    panorama: Float32s,
    sun_colour: Float32s,
    sun_height: float,
) -> Float32s:
    """Light on the surfaces of a grid of rays, shape (n, 3).

    Where a ray into the half space ends on something, it brings back a share of the light that
    this something is likely to have: neither all in the sun nor all in the shade.

    Args:
        scene: The scene.
        found: Surfaces of the grid's rays.
        hit: Whether each of the rays met a surface, shape (n,).
        panorama: Light of the sky.
        sun_colour: Light of the sun, shape (3,).
        sun_height: Sine of the sun's elevation.
    """
    which = np.flatnonzero(hit)
    directions = np.empty((len(which) * RAYS, 3), np.float32)
    origins = np.repeat(found.point[which], RAYS, axis=0)
    _directions(which, found.normal[which], directions)
    blocked = scene.blocked(origins, directions)
    sky = panorama.mean(axis=(0, 1))
    bounced = 0.20 * (0.42 * sun_colour * max(sun_height, 0.2) + 0.55 * sky)
    result = np.zeros((len(hit), 3), np.float32)
    _gather(which, directions, blocked, panorama, bounced.astype(np.float32), result)
    return result


@kernel(error_model="numpy")
def _directions(which, normals, directions):
    """Cosine-weighted, spread evenly (a golden spiral) and turned differently at each point.

    Invariant: rows j * RAYS to (j + 1) * RAYS - 1 belong to point j, as `_gather` reads them, and
    the turn depends on the point's number alone: an image repeats bit for bit.
    """
    golden = np.float32(2.399963)
    for j in range(len(which)):
        nx, ny, nz = normals[j, 0], normals[j, 1], normals[j, 2]
        # A frame around the normal (Duff et al. 2017).
        sign = _ONE if nz >= _ZERO else -_ONE
        a = -_ONE / (sign + nz)
        b = nx * ny * a
        hashed = (which[j] * 2654435761) & 0xFFFFFFFF
        turn = np.float32(hashed * (2.0 * np.pi / 4294967296.0))
        for k in range(RAYS):
            share = np.float32((k + 0.5) / RAYS)
            radius, up = np.sqrt(share), np.sqrt(_ONE - share)
            angle = turn + golden * k
            x, y = radius * np.cos(angle), radius * np.sin(angle)
            row = j * RAYS + k
            directions[row, 0] = x * (_ONE + sign * nx * nx * a) + y * b + nx * up
            directions[row, 1] = x * sign * b + y * (sign + ny * ny * a) + ny * up
            directions[row, 2] = -x * sign * nx - y * ny + nz * up


@kernel(error_model="numpy")
def _gather(which, directions, blocked, panorama, bounced, result):
    """Mean light of each point's rays, into `result`; rows of rays without a hit stay 0."""
    for j in range(len(which)):
        red, green, blue = _ZERO, _ZERO, _ZERO
        for k in range(RAYS):
            row = j * RAYS + k
            if blocked[row] or directions[row, 2] <= _ZERO:
                red += bounced[0]
                green += bounced[1]
                blue += bounced[2]
            else:
                sky = sky_colour(
                    panorama, directions[row, 0], directions[row, 1], directions[row, 2]
                )
                red += sky[0]
                green += sky[1]
                blue += sky[2]
        i = which[j]
        result[i, 0], result[i, 1], result[i, 2] = red / RAYS, green / RAYS, blue / RAYS


@kernel(error_model="numpy")
def smooth_ambient(light, normal, distance, columns, rows, out):
    """Means over neighbours on the same surface: few rays make a rough estimate.

    Invariant: `light` is only read and `out` only written, so that no mean enters another; a
    point is its own neighbour, so that the total is never 0.

    Args:
        light: Light at the grid's points, shape (columns * rows, 3).
        normal: Normals there, shape (columns * rows, 3).
        distance: Distances there, metres, infinite for none, shape (columns * rows,).
        columns: Number of the grid's columns.
        rows: Number of the grid's rows.
        out: Result, written in place, shape (columns * rows, 3).
    """
    for row in range(rows):
        for column in range(columns):
            i = row * columns + column
            if distance[i] > _FAR:
                continue
            red, green, blue, total = _ZERO, _ZERO, _ZERO, _ZERO
            for y in range(max(row - 2, 0), min(row + 3, rows)):
                for x in range(max(column - 2, 0), min(column + 3, columns)):
                    j = y * columns + x
                    if distance[j] > _FAR:
                        continue
                    alike = (
                        normal[i, 0] * normal[j, 0]
                        + normal[i, 1] * normal[j, 1]
                        + normal[i, 2] * normal[j, 2]
                    )
                    near = min(distance[i], distance[j])
                    if alike < np.float32(0.8) or abs(distance[i] - distance[j]) > 0.15 * near:
                        continue
                    red += light[j, 0]
                    green += light[j, 1]
                    blue += light[j, 2]
                    total += _ONE
            out[i, 0], out[i, 1], out[i, 2] = red / total, green / total, blue / total


@kernel(error_model="numpy")
def carry(
    pixels, found, distances, step, columns, rows, grid_light, grid_normal, grid_distance, out
):
    """Ambient light at rays from the four grid points around each.

    Invariant: weights fall with the bend and the distance between ray and grid point, so that light
    does not leak over an edge; rows of rays without a hit stay what they are.

    Args:
        pixels: Column and row of each ray in the image, float, shape (n, 2).
        found: Surfaces of the rays.
        distances: Distances along the rays, metres, infinite for none, shape (n,).
        step: Distance between grid points, pixels.
        columns: Number of the grid's columns.
        rows: Number of the grid's rows.
        grid_light: Light at the grid's points, shape (columns * rows, 3).
        grid_normal: Normals there, shape (columns * rows, 3).
        grid_distance: Distances there, metres, shape (columns * rows,).
        out: Result, written in place, shape (n, 3).
    """
    for i in range(len(pixels)):
        distance = distances[i]
        if distance > _FAR:
            continue
        x, y = pixels[i, 0] / step, pixels[i, 1] / step
        left, top = int(np.floor(x)), int(np.floor(y))
        fx, fy = np.float32(x - left), np.float32(y - top)
        nx, ny, nz = found.normal[i, 0], found.normal[i, 1], found.normal[i, 2]
        red, green, blue, total = _ZERO, _ZERO, _ZERO, _ZERO
        for dy in range(2):
            for dx in range(2):
                column = min(max(left + dx, 0), columns - 1)
                row = min(max(top + dy, 0), rows - 1)
                j = row * columns + column
                there = grid_distance[j]
                if there > _FAR:
                    continue
                weight = ((fx if dx else _ONE - fx) + np.float32(0.03)) * (
                    (fy if dy else _ONE - fy) + np.float32(0.03)
                )
                alike = nx * grid_normal[j, 0] + ny * grid_normal[j, 1] + nz * grid_normal[j, 2]
                alike = max(alike, _ZERO)
                alike *= alike
                alike *= alike
                apart = abs(there - distance) / distance
                weight *= (alike + np.float32(1e-3)) / (np.float32(0.004) + apart)
                red += weight * grid_light[j, 0]
                green += weight * grid_light[j, 1]
                blue += weight * grid_light[j, 2]
                total += weight
        if total > _ZERO:
            out[i, 0], out[i, 1], out[i, 2] = red / total, green / total, blue / total
        else:
            # Thin things between grid points: neither open nor closed.
            out[i, 0], out[i, 1], out[i, 2] = np.float32(0.3), np.float32(0.33), np.float32(0.38)
