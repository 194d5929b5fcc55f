"""What rays meet: colour, bend, and how the sun stands to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.foliage import leaf_at, leaf_cell
from avsec_gym.world.rendering.ray_scene import NO_OVERLAY
from avsec_gym.world.rendering.scene_arrays import SceneArrays
from avsec_gym.world.rendering.texturing import filtered_colour, overlay_colour, texel_colour

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_STEEPEST = np.float32(0.04)
_BREAK_UP = np.float32(0.11)
_MOST_MIRRORED = np.float32(0.75)
"""The most that is mirrored, at grazing angles, where dust and ripples spoil the mirror."""
_COS, _SIN = np.float32(0.745 * np.cos(0.7)), np.float32(0.745 * np.sin(0.7))
"""Scale and turn of the second layer of grains."""
_BOTH = np.float32(np.sqrt(0.5))
_GRAINS_SEEN = np.float32(0.06)
"""Metres in a pixel beyond which grains are a plain colour anyway."""
_TURN = np.float32(0.55)
"""How far leaves turn from the spray that they belong to."""


class Surfaces(NamedTuple):
    """What n rays met."""

    albedo: Float32s
    """Share of light returned, shape (n, 3)."""
    point: Float32s
    """A little in front of the surface, shape (n, 3)."""
    normal: Float32s
    """Normal for shading, shape (n, 3)."""
    sunlight: Float32s
    """Share of the sun's light that arrives if nothing is in the way, shape (n,)."""
    mirror: Float32s
    """Share of light mirrored, shape (n,)."""
    glow: Float32s
    """Own light, shape (n,)."""
    clear: Float32s
    """Share of the light from behind that passes, shape (n,)."""
    flakes: Float32s
    """Share of the own light that flakes of metal send towards one side, shape (n,)."""


def surfaces(
    scene: SceneArrays,
    hits: tuple[Int32s, Float32s, Float32s, Float32s],
    origins: Float32s,
    directions: Float32s,
    sun: Float32s,
    pixel_angle: float,
) -> Surfaces:
    """Colour and geometry at the hits of n rays; rows of rays without a hit are meaningless.

    Args:
        scene: The scene.
        hits: Hits as `RayScene.hits` returns them.
        origins: Origins of the rays, metres, shape (n, 3).
        directions: Unit vectors along the rays, shape (n, 3).
        sun: Direction towards the sun.
        pixel_angle: Angle between neighbouring rays, radians.
    """
    count = len(origins)
    result = Surfaces(
        np.empty((count, 3), np.float32),
        np.empty((count, 3), np.float32),
        np.empty((count, 3), np.float32),
        *(np.zeros(count, np.float32) for _ in range(5)),
    )
    _surfaces(scene, hits, origins, directions, sun, np.float32(pixel_angle), result)
    return result


@kernel(error_model="numpy")
def _surfaces(scene, hits, origins, directions, sun, pixel_angle, result):
    """Fill `result`; see `surfaces`.

    Invariants: row i is written from hit i alone; all arithmetic is in float32, since a single
    float64 would change the pixels; names ending in x, y, z are vectors in the world (e and f the
    face's edges, g its geometric normal, n the shading normal, d the ray, l and s the long and the
    short axis of the pixel's footprint, p the point).
    """
    faces, distances, us, vs = hits[0], hits[1], hits[2], hits[3]
    overlaid = len(scene.overlay_uv) > 0
    for i in range(len(faces)):
        face = faces[i]
        if face < 0:
            continue
        a, b, c = scene.faces[face, 0], scene.faces[face, 1], scene.faces[face, 2]
        second, third = us[i], vs[i]
        first = _ONE - second - third
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        distance = distances[i]
        # Edges, and the geometric normal turned to the viewer.
        ex, ey, ez, fx, fy, fz = _edges(scene.vertices, a, b, c)
        gx, gy, gz = _face_normal(ex, ey, ez, fx, fy, fz)
        nx, ny, nz = _shading_normal(scene.normals, a, b, c, first, second, third)
        # The geometric normal faces the viewer, the shading normal too unless light shines through.
        material = scene.material[face]
        translucent = scene.materials.translucent[material]
        facing = gx * dx + gy * dy + gz * dz
        if facing > _ZERO:
            gx, gy, gz = -gx, -gy, -gz
            if translucent == _ZERO:
                nx, ny, nz = -nx, -ny, -nz
        cosine = max(abs(facing), _STEEPEST)
        # The pixel's footprint on the surface: short across, long along the view.
        lx, ly, lz = _long_axis(gx, gy, gz, dx, dy, dz, ex, ey, ez)
        sx, sy, sz = gy * lz - gz * ly, gz * lx - gx * lz, gx * ly - gy * lx
        foot = distance * pixel_angle
        long2, long3, short2, short3 = _barycentric_steps(
            ex, ey, ez, fx, fy, fz, lx, ly, lz, sx, sy, sz
        )
        stretch = foot / cosine
        # The texture's mean under the footprint.
        u_ab, v_ab = scene.uv[b, 0] - scene.uv[a, 0], scene.uv[b, 1] - scene.uv[a, 1]
        u_ac, v_ac = scene.uv[c, 0] - scene.uv[a, 0], scene.uv[c, 1] - scene.uv[a, 1]
        texture = scene.materials.texture[material]
        place_u = scene.uv[a, 0] + second * u_ab + third * u_ac
        place_v = scene.uv[a, 1] + second * v_ab + third * v_ac
        short_u = (short2 * u_ab + short3 * u_ac) * foot
        short_v = (short2 * v_ab + short3 * v_ac) * foot
        long_u = (long2 * u_ab + long3 * u_ac) * stretch
        long_v = (long2 * v_ab + long3 * v_ac) * stretch
        colour = filtered_colour(
            scene.textures, texture, place_u, place_v, short_u, short_v, long_u, long_v
        )
        if scene.materials.grainy[material] and foot < _GRAINS_SEEN:
            colour = _with_second_grains(
                scene.textures, texture, colour,
                place_u, place_v, short_u, short_v, long_u, long_v,
            )  # fmt: skip
        red = colour[0] * scene.materials.tint[material, 0]
        green = colour[1] * scene.materials.tint[material, 1]
        blue = colour[2] * scene.materials.tint[material, 2]
        px = origins[i, 0] + distance * dx
        py = origins[i, 1] + distance * dy
        pz = origins[i, 2] + distance * dz
        if scene.materials.leaves[material]:
            leaf = leaf_at(place_u, place_v, leaf_cell(distance, pixel_angle))
            # Leaves differ in tone and turn this way and that.
            tone = np.float32(0.6) + np.float32(leaf & 0xFF) * np.float32(1.1 / 255.0)
            red, green, blue = red * tone, green * tone, blue * tone
            nx, ny, nz = _turned(nx, ny, nz, leaf)
        # Scenery, but no actor, varies softly in brightness from place to place.
        elif scene.object_id[face] < 0:
            break_up = _ONE + _BREAK_UP * _variation(scene.lattice, px, py, pz)
            red, green, blue = red * break_up, green * break_up, blue * break_up
        # Paint and wear over it.
        if overlaid and scene.overlay_uv[a, 0] > NO_OVERLAY:
            red, green, blue = _painted(
                scene.overlay, scene.overlay_uv, a, b, c, second, third,
                short2, short3, foot, long2, long3, stretch, red, green, blue,
            )  # fmt: skip
        result.albedo[i, 0], result.albedo[i, 1], result.albedo[i, 2] = red, green, blue
        result.normal[i, 0], result.normal[i, 1], result.normal[i, 2] = nx, ny, nz
        # The sun, and the point a little off the surface, where further rays begin.
        sunward = nx * sun[0] + ny * sun[1] + nz * sun[2]
        sun_side = gx * sun[0] + gy * sun[1] + gz * sun[2]
        lift = np.float32(2e-3) + np.float32(1e-4) * distance
        result.sunlight[i] = _sunlight(sunward, sun_side, translucent)
        if translucent > _ZERO and sun_side <= _ZERO:
            # The ray to the sun leaves on the sun's side of the leaf.
            lift = -lift
        result.point[i, 0] = px + gx * lift
        result.point[i, 1] = py + gy * lift
        result.point[i, 2] = pz + gz * lift
        mirror = scene.materials.mirror[material]
        if mirror > _ZERO:
            result.mirror[i] = _mirrored(mirror, nx * dx + ny * dy + nz * dz)
        result.glow[i] = scene.materials.glow[material]
        result.clear[i] = scene.materials.clear[material]
        result.flakes[i] = scene.materials.flakes[material]


@kernel(inline="always", error_model="numpy")
def _edges(vertices, a, b, c):
    """Of a face, from its first corner to the two others."""
    return (
        vertices[b, 0] - vertices[a, 0],
        vertices[b, 1] - vertices[a, 1],
        vertices[b, 2] - vertices[a, 2],
        vertices[c, 0] - vertices[a, 0],
        vertices[c, 1] - vertices[a, 1],
        vertices[c, 2] - vertices[a, 2],
    )


@kernel(inline="always", error_model="numpy")
def _face_normal(ex, ey, ez, fx, fy, fz):
    """By the edges of a face; a unit vector."""
    gx, gy, gz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    area2 = gx * gx + gy * gy + gz * gz
    scale = _ONE / np.sqrt(max(area2, np.float32(1e-20)))
    return gx * scale, gy * scale, gz * scale


@kernel(inline="always", error_model="numpy")
def _mirrored(mirror, cosine):
    """Share of light mirrored: more towards grazing angles (Schlick's approximation)."""
    grazing = _ONE - min(abs(cosine), _ONE)
    return mirror + (_MOST_MIRRORED - mirror) * grazing**5


@kernel(inline="always", error_model="numpy")
def _long_axis(gx, gy, gz, dx, dy, dz, ex, ey, ez):
    """Along the view in the plane of a face, a unit vector."""
    along = gx * dx + gy * dy + gz * dz
    lx, ly, lz = dx - along * gx, dy - along * gy, dz - along * gz
    scale = np.sqrt(lx * lx + ly * ly + lz * lz)
    if scale < np.float32(1e-4):
        # Looking straight at it: any direction in the plane will do.
        scale = np.sqrt(ex * ex + ey * ey + ez * ez) + np.float32(1e-12)
        lx, ly, lz = ex, ey, ez
    scale = _ONE / scale
    return lx * scale, ly * scale, lz * scale


@kernel(inline="always", error_model="numpy")
def _sunlight(sunward, sun_side, translucent):
    """Share of the sun's light that arrives, by the cosines of both normals with its direction."""
    if translucent > _ZERO:
        return sunward if sunward > _ZERO else -translucent * sunward
    return max(sunward, _ZERO) if sun_side > _ZERO else _ZERO


@kernel(inline="always", error_model="numpy")
def _shading_normal(normals, a, b, c, first, second, third):
    """From the normals of a face's corners, by the barycentric coordinates; a unit vector."""
    nx = first * normals[a, 0] + second * normals[b, 0] + third * normals[c, 0]
    ny = first * normals[a, 1] + second * normals[b, 1] + third * normals[c, 1]
    nz = first * normals[a, 2] + second * normals[b, 2] + third * normals[c, 2]
    scale = _ONE / np.sqrt(max(nx * nx + ny * ny + nz * nz, np.float32(1e-12)))
    return nx * scale, ny * scale, nz * scale


@kernel(inline="always", error_model="numpy")
def _barycentric_steps(ex, ey, ez, fx, fy, fz, lx, ly, lz, sx, sy, sz):
    """What a metre along the long and the short axis adds to the second and third coordinate."""
    ee, ef, ff = (
        ex * ex + ey * ey + ez * ez,
        ex * fx + ey * fy + ez * fz,
        fx * fx + fy * fy + fz * fz,
    )
    inverse = _ONE / max(ee * ff - ef * ef, np.float32(1e-20))
    le, lf = lx * ex + ly * ey + lz * ez, lx * fx + ly * fy + lz * fz
    se, sf = sx * ex + sy * ey + sz * ez, sx * fx + sy * fy + sz * fz
    long2, long3 = (le * ff - lf * ef) * inverse, (lf * ee - le * ef) * inverse
    return long2, long3, (se * ff - sf * ef) * inverse, (sf * ee - se * ef) * inverse


@kernel(inline="always", error_model="numpy")
def _with_second_grains(
    textures, texture, colour, place_u, place_v, short_u, short_v, long_u, long_v
):
    """The same grains turned and a little larger; two add up to as much contrast as one."""
    again = filtered_colour(
        textures,
        texture,
        _COS * place_u - _SIN * place_v,
        _SIN * place_u + _COS * place_v,
        _COS * short_u - _SIN * short_v,
        _SIN * short_u + _COS * short_v,
        _COS * long_u - _SIN * long_v,
        _SIN * long_u + _COS * long_v,
    )
    last = textures.levels[texture] - 1
    mean = texel_colour(textures, texture, last, np.float32(0.5), np.float32(0.5))
    return (
        mean[0] + _BOTH * (colour[0] + again[0] - np.float32(2.0) * mean[0]),
        mean[1] + _BOTH * (colour[1] + again[1] - np.float32(2.0) * mean[1]),
        mean[2] + _BOTH * (colour[2] + again[2] - np.float32(2.0) * mean[2]),
    )


@kernel(inline="always", error_model="numpy")
def _turned(nx, ny, nz, leaf):
    """The normal of one leaf, a unit vector."""
    nx += _TURN * (np.float32((leaf >> 8) & 0xFF) * np.float32(2.0 / 255.0) - _ONE)
    ny += _TURN * (np.float32((leaf >> 16) & 0xFF) * np.float32(2.0 / 255.0) - _ONE)
    nz += _TURN * (np.float32((leaf >> 24) & 0xFF) * np.float32(2.0 / 255.0) - _ONE)
    scale = _ONE / np.sqrt(max(nx * nx + ny * ny + nz * nz, np.float32(1e-12)))
    return nx * scale, ny * scale, nz * scale


@kernel(inline="always", error_model="numpy")
def _painted(
    overlay, uv, a, b, c, second, third,
    short2, short3, foot, long2, long3, stretch, red, green, blue,
):  # fmt: skip
    """A colour under paint and wear, whose own is already multiplied by its alpha."""
    u_ab, v_ab = uv[b, 0] - uv[a, 0], uv[b, 1] - uv[a, 1]
    u_ac, v_ac = uv[c, 0] - uv[a, 0], uv[c, 1] - uv[a, 1]
    paint = overlay_colour(
        overlay,
        uv[a, 0] + second * u_ab + third * u_ac,
        uv[a, 1] + second * v_ab + third * v_ac,
        (short2 * u_ab + short3 * u_ac) * foot,
        (short2 * v_ab + short3 * v_ac) * foot,
        (long2 * u_ab + long3 * u_ac) * stretch,
        (long2 * v_ab + long3 * v_ac) * stretch,
    )
    rest = _ONE - paint[3]
    return red * rest + paint[0], green * rest + paint[1], blue * rest + paint[2]


@kernel(inline="always", error_model="numpy")
def _variation(lattice, x, y, z):
    """Soft noise of two sizes at a place in the world."""
    coarse, fine = np.float32(0.057), np.float32(0.31)
    return _smooth(lattice, x * fine, y * fine, z * fine) + _smooth(
        lattice, x * coarse, y * coarse, z * np.float32(0.09)
    )


@kernel(inline="always", error_model="numpy")
def _smooth(lattice, x, y, z):
    """Smooth noise in [-1, 1] with cells of 1."""
    cx, cy, cz = np.int32(np.floor(x)), np.int32(np.floor(y)), np.int32(np.floor(z))
    fx, fy, fz = x - np.float32(cx), y - np.float32(cy), z - np.float32(cz)
    fx = fx * fx * (np.float32(3.0) - np.float32(2.0) * fx)
    fy = fy * fy * (np.float32(3.0) - np.float32(2.0) * fy)
    fz = fz * fz * (np.float32(3.0) - np.float32(2.0) * fz)
    total = _ZERO
    for i in range(2):
        for j in range(2):
            for k in range(2):
                weight = (
                    (fx if i else _ONE - fx) * (fy if j else _ONE - fy) * (fz if k else _ONE - fz)
                )
                total += weight * lattice[(cx + i) & 63, (cy + j) & 63, (cz + k) & 15]
    return total
