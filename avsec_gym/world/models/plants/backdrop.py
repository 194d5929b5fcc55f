"""What stands on the horizon: edges of woods with ragged canopies, and hills behind them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.plants.skeleton import unit
from avsec_gym.world.shapes import grid

_MIXED = Material("forest_far/0", infrared=0.6)
_CONIFERS = Material("forest_far/1", infrared=0.6)
_MEADOW = Material("meadow_far", infrared=0.5)
_CROWNS = {
    _MIXED: replace(_MIXED, leaves=True),
    _CONIFERS: replace(_CONIFERS, leaves=True),
}
"""What looks against the sky: one sees between the leaves."""

_BELOW = -2.0
"""Bases lie below the ground, metres."""
_HILL_COLUMNS, _HILL_ROWS = 150, 8
_RIDGE_COLUMNS = 600


def distant_woods(rng: np.random.Generator, radius_from: float, radius_to: float) -> Mesh:
    """Edges of woods all round the origin, in two rows with gaps: single trees, groups, walls.

    Args:
        rng: The source of chance.
        radius_from: Least distance to the origin, metres.
        radius_to: Largest distance to the origin, metres.

    Returns:
        At most 4,000 triangles, seen from the inside.
    """
    span = radius_to - radius_from
    front = _edge_of_wood(
        rng, radius_from + 0.05 * span, radius_from + 0.3 * span, 0.55, columns=500
    )
    back = _edge_of_wood(
        rng, radius_from + 0.6 * span, radius_from + 0.95 * span, 0.85, columns=500
    )
    return merge([front, back])


def _edge_of_wood(
    rng: np.random.Generator,
    nearest: float,
    farthest: float,
    share: float,
    *,
    columns: int,
) -> Mesh:
    """Canopies round the origin whose distance wanders; `share` of the circle is wooded."""
    azimuth = np.linspace(0, 2 * np.pi, 16 * columns, endpoint=False)
    density = _wander(azimuth, rng, 9)
    # The course begins and ends in a clearing.
    first = int(np.argmax(density))
    azimuth = np.concatenate([azimuth[first:], azimuth[:first] + 2 * np.pi])
    density = np.roll(density, -first)
    wooded = density < np.quantile(density, share)
    azimuth = azimuth[wooded][np.linspace(0, wooded.sum() - 1, columns).astype(int)]
    distance = nearest + (farthest - nearest) * (0.5 + 0.25 * _wander(azimuth, rng, 5)).clip(0, 1)
    course = azimuth * 0.5 * (nearest + farthest)
    lone = np.diff(course) > 4 * np.median(np.diff(course))
    ends = np.convolve(np.r_[1.0, lone, 1.0], [0.5, 0.9, 0.9, 0.5], "same")[:columns]
    stand = np.clip(0.95 + 0.18 * _wander(azimuth, rng, 30), 0.5, 1.35)
    top = _canopy(course, rng) * stand * (1 - ends)
    inward = -np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    swell = np.gradient(top, course)
    side = np.stack([-np.sin(azimuth), np.cos(azimuth)], axis=-1)
    lean = unit(inward - 0.8 * np.tanh(swell)[:, None] * side)
    # Height, setback and upward slope of the foot, of the canopy, and of the leaves above it.
    profile = [(np.full(columns, _BELOW), 0.0, 0.2), (0.96 * top, 2.0, 0.8), (1.1 * top, 4.0, 1.1)]
    points = np.stack(
        [np.column_stack([-(distance + back)[:, None] * inward, z]) for z, back, _ in profile]
    )
    normals = np.stack([unit(np.column_stack([lean, 0 * z + up])) for z, _, up in profile])
    uv = np.stack([np.stack([-course, -z], axis=-1) for z, _, _ in profile])
    wood = _MIXED if rng.random() < 0.7 else _CONIFERS
    mesh = grid(points, uv, wood)
    kept = ~np.tile(lone, 4)
    crowns = np.tile(np.repeat([0, 1], columns - 1), 2)
    return replace(
        mesh,
        normals=normals.reshape(-1, 3).astype(np.float32),
        faces=mesh.faces[kept],
        material=crowns[kept].astype(np.int32),
        materials=(wood, _CROWNS[wood]),
    )


def _canopy(course: Floats, rng: np.random.Generator) -> Floats:
    """Height of the canopy along a course: the highest of round and pointed crowns, metres."""
    low, high = float(course.min()), float(course.max())
    count = int((high - low) / 1.8) + 1
    middle = np.sort(rng.uniform(low, high, count))
    half, height = rng.uniform(1.6, 4.5, count), rng.lognormal(np.log(11.5), 0.16, count)
    pointed = rng.random(count) < 0.04
    half[pointed] *= 0.6
    offset = np.abs(course[:, None] - middle) / half
    crown = np.where(pointed, 1.1 - offset, np.sqrt(np.clip(1 - offset**2, 0, None)))
    top = np.max(height * (0.65 + 0.35 * crown) * (offset < 1), axis=1)
    return np.asarray(np.maximum(top, 6.0) + rng.normal(0, 0.6, len(course)))


def hills(rng: np.random.Generator) -> Mesh:
    """Wooded hills with meadows between 380 and 900 m all round the origin, up to 110 m high.

    Returns:
        At most 4,000 triangles, seen from the inside.
    """
    azimuth = np.linspace(0, 2 * np.pi, _HILL_COLUMNS + 1)
    share = np.linspace(0, 1, _HILL_ROWS)
    height = 26 + 24 * _wander(azimuth, rng, 3) + 9 * _wander(azimuth, rng, 11)
    height = np.clip(height, 4, 110)
    start = 400 + 60 * np.clip(_wander(azimuth, rng, 4), -0.3, 2)
    distance = start + share[:, None] * (900 - start)
    bumps = np.stack([_wander(azimuth, rng, 14) for _ in share])
    rise = share[:, None] ** 1.3 * height * (1 + 0.1 * bumps * (1 - share[:, None]))
    z = _BELOW + rise
    points = np.stack([distance * np.cos(azimuth), distance * np.sin(azimuth), z], axis=-1)
    uv = np.stack([np.broadcast_to(650 * azimuth, z.shape), -distance - z], axis=-1)
    slopes = grid(points, uv, _MIXED, closed=True)
    cover = np.stack([_wander(azimuth[:-1], rng, 8) for _ in share[:-1]])
    cover += np.linspace(-0.7, 1.6, len(cover))[:, None]
    kinds = np.select([cover < -1.2, cover > 0.9], [2, 1], 0).ravel()
    slopes = replace(
        slopes,
        material=np.tile(kinds, 2).astype(np.int32),
        materials=(_MIXED, _CONIFERS, _MEADOW),
    )
    return merge([slopes, _ridge(azimuth, z[-1], rng)])


def _ridge(azimuth: Floats, height: Floats, rng: np.random.Generator) -> Mesh:
    """Crowns against the sky along the hills' crests."""
    fine = np.linspace(0, 2 * np.pi, _RIDGE_COLUMNS + 1)
    foot = np.interp(fine, azimuth, height)
    top = foot + 2.0 + np.abs(rng.normal(0, 2.2, len(fine))) + 1.5 * _wander(fine, rng, 60)
    inward = -np.stack([np.cos(fine), np.sin(fine)], axis=-1)
    points = np.stack([np.column_stack([-898 * inward, z]) for z in (foot - 4, top)])
    uv = np.stack([np.stack([-898 * fine, -z], axis=-1) for z in (foot, top)])
    mesh = grid(points, uv, _CONIFERS)
    upwards = unit(np.column_stack([inward, 0 * fine + 0.7]))
    return replace(mesh, normals=np.tile(upwards, (2, 1)).astype(np.float32))


def _wander(azimuth: Floats, rng: np.random.Generator, waves: int) -> Floats:
    """Smooth noise round the circle, standard deviation 1; `waves` is its finest frequency."""
    number = np.arange(1, waves + 1)
    phase = rng.uniform(0, 2 * np.pi, waves)
    size = rng.lognormal(0, 0.5, waves) * number**-0.3
    total = np.sin(azimuth[:, None] * number + phase) @ size
    return np.asarray(total / np.sqrt(0.5 * np.sum(size**2)))
