"""Fences and railings along a path."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import GALVANISED, painted
from avsec_gym.world.models.furniture.poles import DEPTH
from avsec_gym.world.models.furniture.sweep import along, copies, swept
from avsec_gym.world.shapes import box, polygon

GREEN_COATED = painted(0.03, 0.09, 0.05)
DARK_COATED = painted(0.03, 0.035, 0.035)


def bar_fence(
    path: ArrayLike, *, height: float = 1.2, material: Material = DARK_COATED, pitch: float = 0.13
) -> Mesh:
    """Upright bars between two rails, posts every 2.5 m: garden fence, bridge railing.

    Args:
        path: On the ground, shape (n, 3), metres.
        height: Of the upper rail, metres.
        material: Of all parts.
        pitch: From bar to bar, metres.
    """
    bar = box(0.018, 0.018, height - 0.1, material).placed(0, 0, 0.08)
    post = box(0.05, 0.05, height + 0.02 + DEPTH, material).placed(0, 0, -DEPTH)
    rails = [
        swept(_raised(path, z), _square(half), material)
        for z, half in ((0.1, 0.015), (height - 0.02, 0.022))
    ]
    return merge([*rails, copies(bar, along(path, pitch)), copies(post, along(path, 2.5))])


def chain_link_fence(
    path: ArrayLike, *, height: float = 1.6, material: Material = GREEN_COATED, pitch: float = 0.14
) -> Mesh:
    """A net of diagonal wires between posts, a tension wire above and below.

    Args:
        path: On the ground, shape (n, 3), metres.
        height: Metres.
        material: Of all parts.
        pitch: Of the meshes, metres; wider than real ones, whose wires a camera cannot resolve.
    """
    places = along(path, pitch)
    # A wire leans over as far as the net is high, in strips of 8 mm that face across the path.
    reach = min(0.5 * height, 0.5)
    low, high = 0.05, height
    lean = reach if len(places) > 2 * reach / pitch else 0.0
    wires = []
    for side in (-1.0, 1.0):
        steps = np.linspace(0.0, 1.0, max(2, round(height / reach) + 1))
        offset = lean * np.abs((steps * (len(steps) - 1)) % 2 - 0.0)
        for first, last, start, end in zip(steps[:-1], steps[1:], offset[:-1], offset[1:], strict=True):
            z0, z1 = low + (high - low) * first, low + (high - low) * last
            x0, x1 = side * (start - 0.5 * lean), side * (end - 0.5 * lean)
            strip = [(x0 - 0.005, 0, z0), (x0 + 0.005, 0, z0), (x1 + 0.005, 0, z1), (x1 - 0.005, 0, z1)]
            wires.append(polygon(strip, material))
    inner = places[np.abs(_from_ends(places)) >= 0.5 * lean + 1e-6] if lean else places
    post = box(0.05, 0.05, height + 0.03 + DEPTH, GALVANISED).placed(0, 0, -DEPTH)
    edges = [swept(_raised(path, z), _square(0.006), material) for z in (low, high)]
    return merge([copies(merge(wires), inner), copies(post, along(path, 2.5)), *edges])


def tube_railing(path: ArrayLike, *, height: float = 1.0, material: Material = GALVANISED) -> Mesh:
    """A handrail and a knee rail on posts every 2 m: footpaths, traffic islands."""
    post = box(0.045, 0.045, height + DEPTH, material).placed(0, 0, -DEPTH)
    rails = [swept(_raised(path, z), _square(0.024), material) for z in (0.5 * height, height)]
    return merge([copies(post, along(path, 2.0)), *rails])


def _raised(path: ArrayLike, height: float) -> np.ndarray:
    return np.asarray(path, float) + [0.0, 0.0, height]


def _square(half: float) -> np.ndarray:
    return half * np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)])


def _from_ends(places: np.ndarray) -> np.ndarray:
    """How far along the path each place is from the nearer end, metres."""
    steps = np.linalg.norm(np.diff(places[:, :3], axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    return np.minimum(run, run[-1] - run)
