"""Kernels that add up light: sun, sky, air, and what is mirrored."""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_SUN_RADIUS = np.float32(0.0047)
"""Radians."""
_GRAIN = np.float32(0.005)
"""Grain of half-shades, metres."""
_BURNT_OUT = np.float32(4.0)
"""Light counts as no brighter when it is averaged: edges of reflections stay smooth."""
_ROUGHNESS = np.float32(0.045**2)
"""Roughness of varnish, chrome and panes: the square of GGX's alpha; waves and dust widen the sun
so much."""
_SKY_SEEN = np.float32(1.35)
"""The sky as cameras see it against the light that it sheds: KITTI's is burnt out mostly."""


@kernel(inline="always", error_model="numpy")
def sky_colour(panorama, x, y, z):
    """Light of the sky in a direction; below the horizon that of the horizon."""
    rows, columns = panorama.shape[0], panorama.shape[1]
    s = (np.arctan2(y, x) / np.float32(2 * np.pi) + np.float32(0.5)) * columns - np.float32(0.5)
    t = max(z, _ZERO) * rows - np.float32(0.5)
    column, row = int(np.floor(s)), int(np.floor(t))
    fs, ft = np.float32(s - column), np.float32(t - row)
    left, right = column % columns, (column + 1) % columns
    low, high = min(max(row, 0), rows - 1), min(max(row + 1, 0), rows - 1)
    a, b = (_ONE - fs) * (_ONE - ft), fs * (_ONE - ft)
    c, d = (_ONE - fs) * ft, fs * ft
    return (
        a * panorama[low, left, 0]
        + b * panorama[low, right, 0]
        + c * panorama[high, left, 0]
        + d * panorama[high, right, 0],
        a * panorama[low, left, 1]
        + b * panorama[low, right, 1]
        + c * panorama[high, left, 1]
        + d * panorama[high, right, 1],
        a * panorama[low, left, 2]
        + b * panorama[low, right, 2]
        + c * panorama[high, left, 2]
        + d * panorama[high, right, 2],
    )


@kernel(error_model="numpy")
def radiance(
    faces, distances, directions, found, ambient, sun, sun_colour, panorama, horizon, haze, out
):
    """Light that comes back along n rays, into `out`, shape (n, 3).

    Invariant: every row of `out` is written, and no row depends on another.

    Args:
        faces: Faces that were hit, -1 where the sky is seen, shape (n,).
        distances: Distances of the hits, metres, shape (n,).
        directions: Unit vectors along the rays, shape (n, 3).
        found: `Surfaces`, `sunlight` already 0 in shadow.
        ambient: Light from the sky and the surroundings on each surface, shape (n, 3).
        sun: Direction towards the sun, shape (3,).
        sun_colour: Light of the sun, shape (3,).
        panorama: Light of the sky.
        horizon: Colour of the air.
        haze: Distance at which the air has removed 63 % of the contrast, metres.
        out: Result, written in place, shape (n, 3).
    """
    for i in range(len(faces)):
        if faces[i] < 0:
            sky = sky_colour(panorama, directions[i, 0], directions[i, 1], directions[i, 2])
            for k in range(3):
                out[i, k] = sky[k] * _SKY_SEEN
            continue
        clear = np.exp(-distances[i] / haze)
        glint, of_sun, of_sky = _ZERO, _ONE, _ONE
        if found.mirror[i] > _ZERO:
            glint, of_sun, of_sky = _gloss(
                directions[i], found.normal[i], sun, found.mirror[i], found.flakes[i]
            )
        solid = _ONE - found.clear[i]
        for k in range(3):
            light = sun_colour[k] * found.sunlight[i] * of_sun + ambient[i, k] * of_sky
            own = found.albedo[i, k] * (light + found.glow[i] * np.float32(3.0)) * solid
            own += glint * found.sunlight[i] * sun_colour[k]
            out[i, k] = own * clear + horizon[k] * (_ONE - clear)


@kernel(inline="always", error_model="numpy")
def _gloss(ray, normal, sun, mirror, flakes):
    """How varnish and flakes of metal under it change a surface's light.

    Returns:
        The sun's own reflection in the varnish, a share of its light (a GGX lobe); factors on
        the paint's light from the sun and from the sky, 1 without flakes.
    """
    along = ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2]
    # Half way between sun and viewer: where it is the normal, the varnish shows the sun.
    hx, hy, hz = sun[0] - ray[0], sun[1] - ray[1], sun[2] - ray[2]
    scale = _ONE / np.sqrt(max(hx * hx + hy * hy + hz * hz, np.float32(1e-6)))
    aligned = (hx * normal[0] + hy * normal[1] + hz * normal[2]) * scale
    spread = aligned * aligned * (_ROUGHNESS - _ONE) + _ONE
    glint = mirror * _ROUGHNESS / (np.float32(4.0) * spread * spread)
    if flakes == _ZERO:
        return glint, _ONE, _ONE
    # Flakes lie nearly flat: they send light about where a mirror would.
    twice = np.float32(2.0) * along
    rx, ry, rz = ray[0] - twice * normal[0], ray[1] - twice * normal[1], ray[2] - twice * normal[2]
    towards = max(rx * sun[0] + ry * sun[1] + rz * sun[2], _ZERO)
    lobe = towards * towards
    lobe *= lobe * towards
    of_sun = _ONE + flakes * (np.float32(2.6) * lobe - np.float32(0.55))
    of_sky = _ONE + flakes * np.float32(0.5) * rz
    return glint, of_sun, of_sky


@kernel(error_model="numpy")
def smooth_over_surfaces(values, known, wanted, distances, normals, width):
    """Values averaged over neighbouring pixels on the same smooth surface, shape (n, m).

    One ray through a pixel's middle holds little of what a bent surface mirrors there, and one
    ray to the sun little of its half-shade.

    Invariant: means are of `values`, never of other means: the result is a copy.

    Args:
        values: Values of all pixels, shape (n, m).
        known: Whether each pixel's values count, shape (n,).
        wanted: Whether each pixel gets a mean, -1 where no neighbour counts; the others keep their
            values, shape (n,).
        distances: Distances of the hits, metres, shape (n,).
        normals: Normals at the hits, shape (n, 3).
        width: Width of the image, pixels.
    """
    out = values.copy()
    for i in range(len(wanted)):
        if not wanted[i]:
            continue
        column, total = i % width, _ZERO
        out[i] = _ZERO
        for down in range(-2, 3):
            for right in range(-2, 3):
                j = i + down * width + right
                if column + right < 0 or column + right >= width or j < 0 or j >= len(known):
                    continue
                if not known[j] or abs(distances[j] - distances[i]) > 0.03 * distances[i]:
                    continue
                alike = (
                    normals[i, 0] * normals[j, 0]
                    + normals[i, 1] * normals[j, 1]
                    + normals[i, 2] * normals[j, 2]
                )
                if alike < 0.9:
                    continue
                weight = np.float32(((3 - abs(down)) * (3 - abs(right))) ** 2)
                for k in range(values.shape[1]):
                    out[i, k] += weight * min(values[j, k], _BURNT_OUT)
                total += weight
        for k in range(values.shape[1]):
            out[i, k] = out[i, k] / total if total > _ZERO else -_ONE
    return out


@kernel(error_model="numpy")
def towards_disc(sun, points):
    """Unit vectors from points towards places on the sun's disc, shape (n, 3).

    Shadows get their half-shade from it: soft where what casts them is far away.

    Invariant: the place on the sun depends on the point alone, in steps of `_GRAIN`, so that a
    half-shade does not flicker from one image to the next.

    Args:
        sun: Direction towards the sun's centre, shape (3,).
        points: Points in the world, metres, shape (n, 3).
    """
    out = np.empty_like(points)
    flat = max(np.sqrt(sun[0] * sun[0] + sun[1] * sun[1]), np.float32(1e-6))
    # Square to the sun: level to its left, and upwards.
    aside_x, aside_y = -sun[1] / flat, sun[0] / flat
    up_x, up_y, up_z = -sun[2] * aside_y, sun[2] * aside_x, flat
    for i in range(len(points)):
        # 32 well-mixed bits for the grain that the point lies in.
        bits = np.uint32(np.int64(np.floor(points[i, 0] / _GRAIN))) * np.uint32(0x9E3779B1)
        bits ^= np.uint32(np.int64(np.floor(points[i, 1] / _GRAIN))) * np.uint32(0x85EBCA77)
        bits ^= np.uint32(np.int64(np.floor(points[i, 2] / _GRAIN))) * np.uint32(0xC2B2AE3D)
        bits ^= bits >> np.uint32(15)
        bits *= np.uint32(0x2C1B3C6D)
        bits ^= bits >> np.uint32(12)
        angle = np.float32(2.0 * np.pi / 65536.0) * np.float32(bits & np.uint32(0xFFFF))
        share = np.float32((bits >> np.uint32(16)) & np.uint32(0xFFFF)) * np.float32(1 / 65536.0)
        # Evenly over the disc: the radius is the root of a share of its area.
        reach = _SUN_RADIUS * np.sqrt(share)
        left, high = reach * np.cos(angle), reach * np.sin(angle)
        scale = _ONE / np.sqrt(_ONE + reach * reach)
        out[i, 0] = (sun[0] + left * aside_x + high * up_x) * scale
        out[i, 1] = (sun[1] + left * aside_y + high * up_y) * scale
        out[i, 2] = (sun[2] + high * up_z) * scale
    return out
