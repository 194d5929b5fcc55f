"""The light of a laser pulse that a surface returns."""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel
from avsec_gym.world.rendering.texturing import texel_colour

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


@kernel()
def laser_reflectance(scene, faces, distances, origins, directions, reflectance, cosine):
    """Infrared reflectance and cosine of incidence at hits, into the last two arguments.

    Args:
        scene: `SceneArrays`.
        faces: Faces that were hit, -1 for none, shape (n,).
        distances: Distances of the hits, metres, shape (n,).
        origins: Origins of the pulses, metres, shape (n, 3).
        directions: Unit vectors along the pulses, shape (n, 3).
        reflectance: Result in [0, 1], written in place, shape (n,).
        cosine: Result in [0, 1], written in place, shape (n,).
    """
    for i in range(len(faces)):
        face = faces[i]
        if face < 0:
            continue
        a, b, c = scene.faces[face, 0], scene.faces[face, 1], scene.faces[face, 2]
        # The cosine of incidence, from the face's geometric normal.
        ex = scene.vertices[b, 0] - scene.vertices[a, 0]
        ey = scene.vertices[b, 1] - scene.vertices[a, 1]
        ez = scene.vertices[b, 2] - scene.vertices[a, 2]
        fx = scene.vertices[c, 0] - scene.vertices[a, 0]
        fy = scene.vertices[c, 1] - scene.vertices[a, 1]
        fz = scene.vertices[c, 2] - scene.vertices[a, 2]
        gx, gy, gz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
        area = np.sqrt(gx * gx + gy * gy + gz * gz) + np.float32(1e-12)
        facing = gx * directions[i, 0] + gy * directions[i, 1] + gz * directions[i, 2]
        cosine[i] = abs(facing) / area
        material = scene.material[face]
        # Materials with an infrared reflectance of their own need no texture.
        infrared = scene.materials.infrared[material]
        if infrared >= _ZERO:
            reflectance[i] = infrared
            continue
        # Barycentric coordinates of the point, for its colour.
        px = origins[i, 0] + distances[i] * directions[i, 0] - scene.vertices[a, 0]
        py = origins[i, 1] + distances[i] * directions[i, 1] - scene.vertices[a, 1]
        pz = origins[i, 2] + distances[i] * directions[i, 2] - scene.vertices[a, 2]
        ee = ex * ex + ey * ey + ez * ez
        ef = ex * fx + ey * fy + ez * fz
        ff = fx * fx + fy * fy + fz * fz
        pe, pf = px * ex + py * ey + pz * ez, px * fx + py * fy + pz * fz
        inverse = _ONE / max(ee * ff - ef * ef, np.float32(1e-20))
        second, third = (pe * ff - pf * ef) * inverse, (pf * ee - pe * ef) * inverse
        first = _ONE - second - third
        texture = scene.materials.texture[material]
        level = min(np.int32(3), scene.textures.levels[texture] - 1)
        colour = texel_colour(
            scene.textures,
            texture,
            level,
            (first * scene.uv[a, 0] + second * scene.uv[b, 0] + third * scene.uv[c, 0])
            / scene.textures.size[texture, 0],
            (first * scene.uv[a, 1] + second * scene.uv[b, 1] + third * scene.uv[c, 1])
            / scene.textures.size[texture, 1],
        )
        tint = scene.materials.tint
        reflectance[i] = (
            colour[0] * tint[material, 0]
            + colour[1] * tint[material, 1]
            + colour[2] * tint[material, 2]
        ) / np.float32(3.0)
