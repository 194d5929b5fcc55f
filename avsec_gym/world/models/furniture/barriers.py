"""Barriers along a road: guard rails, noise barriers."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import CONCRETE, GALVANISED
from avsec_gym.world.models.furniture.poles import DEPTH
from avsec_gym.world.models.furniture.sweep import along, copies, lengths, swept
from avsec_gym.world.shapes import box

_BEAM = [(0.02, -0.155), (0.08, -0.11), (0.08, -0.06), (0.01, -0.02)]
"""Lower half of a W-beam's face, to the traffic and up from its middle, metres."""
_BEAM_HEIGHT = 0.6
_RAMP = 8.0
"""How long a guard rail's end takes to sink into the ground, metres."""


def guard_rail(path: ArrayLike, *, spacing: float = 4.0, sunk_ends: bool = True) -> Mesh:
    """A W-beam on posts; traffic passes on the path's left.

    Args:
        path: Feet of the posts on the ground, shape (n, 3), metres.
        spacing: Distance between posts, metres.
        sunk_ends: The beam sinks into the ground at both ends, as it does at a gap.
    """
    places = along(path, spacing)
    run = lengths(places[:, :3])
    height = np.full(len(places), _BEAM_HEIGHT)
    if sunk_ends:
        to_end = np.minimum(run, run[-1] - run) / min(_RAMP, 0.4 * run[-1])
        height = np.interp(to_end, [0.0, 1.0], [-0.1, _BEAM_HEIGHT])
    beam = places[:, :3] + np.outer(height, [0.0, 0.0, 1.0])
    face = [*_BEAM, *[(y, -z) for y, z in reversed(_BEAM)]]
    section = np.add([(0.0, 0.15), (0.0, -0.15), *face], (0.1, 0.0))
    # Where the beam sinks, so do its posts.
    places[:, 2] += height - _BEAM_HEIGHT
    standing = height > 0.25
    return merge([swept(beam, section, GALVANISED), copies(_rail_post(), places[standing])])


def noise_barrier(
    path: ArrayLike,
    *,
    height: float = 3.0,
    panel: int = 0,
    tint: tuple[float, float, float] = (0.3, 0.42, 0.33),
) -> Mesh:
    """Panels between steel posts every 4 m, on a concrete plinth.

    Args:
        path: Points on the ground, shape (n, 3), metres.
        height: Height of the barrier, metres.
        panel: Kind of panels: 0 for ribbed aluminium, 1 for ribbed wood-concrete.
        tint: Colour of the panels, linear light.
    """
    places = along(path, 4.0)
    material = Material(f"ribbed/{panel}", tint, infrared=0.4)
    post = box(0.18, 0.18, height + 0.05 + DEPTH, GALVANISED).placed(0, 0, -DEPTH)
    return merge(
        [
            swept(places[:, :3], _rectangle(0.12, -DEPTH, 0.4), CONCRETE),
            swept(places[:, :3], _rectangle(0.1, 0.4, height), material),
            copies(post, places),
        ]
    )


def _rectangle(width: float, low: float, high: float) -> NDArray[np.float64]:
    half = 0.5 * width
    return np.array([(half, low), (half, high), (-half, high), (-half, low)])


@functools.cache
def _rail_post() -> Mesh:
    """A post behind the beam and the block between them."""
    block = box(0.1, 0.1, 0.2, GALVANISED).placed(0.0, 0.05, _BEAM_HEIGHT - 0.1)
    return merge([box(0.1, 0.06, 0.74 + DEPTH, GALVANISED).placed(0.0, 0.0, -DEPTH), block])
