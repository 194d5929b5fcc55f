"""Fences along a path."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import GALVANISED
from avsec_gym.world.models.furniture.poles import DEPTH
from avsec_gym.world.models.furniture.sweep import along, copies, swept
from avsec_gym.world.shapes import box, tube


def bar_fence(path: ArrayLike, *, height: float = 1.2, pitch: float = 0.13) -> Mesh:
    """Upright bars of galvanised steel between two rails, posts every 2.5 m: bridge railing.

    Args:
        path: Points on the ground, shape (n, 3), metres.
        height: Height of the upper rail, metres.
        pitch: Distance from bar to bar, metres.
    """
    bar = tube([(0, 0, 0.08), (0, 0, height)], 0.011, GALVANISED, sides=3, capped=False)
    post = box(0.05, 0.05, height + 0.02 + DEPTH, GALVANISED).placed(0, 0, -DEPTH)
    rails = [
        swept(_raised(path, z), _square(half), GALVANISED)
        for z, half in ((0.1, 0.015), (height - 0.02, 0.022))
    ]
    return merge([*rails, copies(bar, along(path, pitch)), copies(post, along(path, 2.5))])


def _raised(path: ArrayLike, height: float) -> np.ndarray:
    return np.add(path, (0.0, 0.0, height))


def _square(half: float) -> np.ndarray:
    return half * np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)])
