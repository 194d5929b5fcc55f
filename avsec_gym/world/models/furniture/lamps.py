"""Street lamps; those with an arm reach to the left (+y), over a road at their left."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import (
    CAST_IRON,
    GALVANISED,
    OPAL_GLASS,
    painted,
)
from avsec_gym.world.models.furniture.poles import DEPTH, pole
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import ellipsoid, hard_edges, revolve, tube

_DARK = painted(0.045, 0.055, 0.05)
_LENS = Material(tint=(0.7, 0.72, 0.7), mirror=0.08, infrared=0.4)


@variants(6)
def lamp_mast(rng: np.random.Generator) -> Mesh:
    """A mast of 6 to 9 m with a curved arm and a flat head over the road."""
    paint = _DARK if rng.random() < 0.35 else GALVANISED
    height, reach = float(rng.uniform(6.0, 9.0)), float(rng.uniform(1.0, 2.2))
    bend = 0.7
    turn = np.linspace(0.0, 0.5 * np.pi, 5)
    curve = np.stack([0 * turn, bend - bend * np.cos(turn), bend * np.sin(turn) - bend], axis=1)
    tip = np.array([0.0, reach, height + 0.12 * (reach - bend)])
    arm = np.vstack([np.add(curve, (0.0, 0.0, height)), tip])
    return merge(
        [
            pole(1.1, 0.085, paint),
            pole(height - bend, 0.065, paint, top_radius=0.045),
            tube(arm, np.linspace(0.045, 0.03, len(arm)), paint, sides=6),
            *_head(tip, paint),
        ]
    )


@variants(4)
def lamp_post_top(rng: np.random.Generator) -> Mesh:
    """A lamp of residential streets: 4 to 5 m, a drum of light under a flat hood."""
    height = float(rng.uniform(4.0, 5.0))
    paint = _DARK if rng.random() < 0.5 else GALVANISED
    glass = [(0.13, 0.3), (0.17, 0.15), (0.09, 0.0), (0.05, -0.06)]
    hood = [(1e-3, 0.42), (0.12, 0.4), (0.3, 0.31), (0.29, 0.28), (0.12, 0.3)]
    return merge(
        [
            pole(1.0, 0.065, paint),
            pole(height, 0.05, paint, top_radius=0.04),
            revolve(glass, OPAL_GLASS, sides=12).placed(0, 0, height),
            revolve(hood, paint, sides=14).placed(0, 0, height),
        ]
    )


@variants(4)
def lamp_globe(rng: np.random.Generator) -> Mesh:
    """A white globe, half a metre across, on a pole of 3.5 to 4.2 m: parks, campus."""
    height, radius = float(rng.uniform(3.5, 4.2)), 0.26
    polar = np.linspace(0.02, np.pi - 0.2, 9)
    profile = np.stack([radius * np.sin(polar), radius * np.cos(polar)], axis=1)
    collar = [(0.09, 0.06), (0.09, 0.0), (0.05, -0.1)]
    paint = _DARK if rng.random() < 0.5 else GALVANISED
    return merge(
        [
            pole(height, 0.05, paint, top_radius=0.04),
            revolve(collar, paint, sides=10).placed(0, 0, height),
            revolve(profile, OPAL_GLASS, sides=18).placed(0, 0, height + radius),
        ]
    )


@variants(3)
def lamp_lantern(rng: np.random.Generator) -> Mesh:
    """An old town's lantern: six panes under a roof, on a cast-iron post, 3.6 to 4.2 m."""
    height = float(rng.uniform(2.9, 3.4))
    foot = [(0.05, 0.95), (0.09, 0.9), (0.07, 0.75), (0.11, 0.2), (0.16, 0.12), (0.17, -DEPTH)]
    crown = [(0.03, 0.16), (0.1, 0.1), (0.04, 0.04), (0.045, -0.05)]
    panes = [(0.2, 0.62), (0.11, 0.14)]
    roof = [(1e-3, 0.92), (0.03, 0.86), (0.05, 0.8), (0.12, 0.76), (0.23, 0.63), (0.2, 0.6)]
    lattice = [
        tube(
            [(r * np.cos(a), r * np.sin(a), height + z) for r, z in ((0.12, 0.13), (0.205, 0.63))],
            0.012,
            CAST_IRON,
            sides=4,
            capped=False,
        )
        for a in np.arange(6) * np.pi / 3
    ]
    return merge(
        [
            revolve(foot, CAST_IRON, sides=10),
            pole(height, 0.045, CAST_IRON),
            revolve(crown, CAST_IRON, sides=8).placed(0, 0, height - 0.02),
            hard_edges(revolve(panes, OPAL_GLASS, sides=6)).placed(0, 0, height),
            hard_edges(revolve(roof, CAST_IRON, sides=6), 0.8).placed(0, 0, height),
            *lattice,
        ]
    )


def _head(tip: np.ndarray, paint: Material) -> list[Mesh]:
    """A flat lamp head along y that ends 0.6 m beyond the tip, its glass below."""
    side = 1.0 if tip[1] >= 0 else -1.0
    centre = np.add(tip, (0.0, 0.25 * side, 0.03))
    shell = ellipsoid(centre, (0.14, 0.38, 0.08), paint, rings=6)
    glass = ellipsoid(np.add(centre, (0, 0.06 * side, -0.04)), (0.11, 0.25, 0.07), _LENS, rings=4)
    return [shell, glass]
