"""Advertising pillars and posters."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import (
    ALUMINIUM,
    RAW_CONCRETE,
    UPRIGHT_WOOD,
    painted,
)
from avsec_gym.world.models.furniture.plate import board
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box, grid, revolve, tube

_POSTER = (1.2, 1.7)
"""Width and height of the texture ``poster``, metres."""
_DARK = painted(0.05, 0.06, 0.06)


@variants(3)
def advertising_pillar(rng: np.random.Generator) -> Mesh:
    """A round pillar of 3.4 m, pasted over with posters, under a low dome."""
    radius = 4.4 / (2 * np.pi)
    angle = np.linspace(0.0, 2 * np.pi, 25)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    wall = np.stack([np.column_stack([ring, np.full(25, z)]) for z in (3.1, 0.3)])
    uv = np.stack([np.column_stack([angle * radius, np.full(25, v)]) for v in (0.0, 2.8)])
    paper = Material(f"pillar_posters/{rng.integers(3)}", infrared=0.6)
    dome = [(1e-3, 3.4), (0.4, 3.36), (0.78, 3.2), (0.78, 3.1), (radius, 3.1)]
    foot = [(radius, 0.3), (radius + 0.05, 0.28), (radius + 0.05, -0.2)]
    return merge(
        [
            grid(wall, uv, paper, closed=True),
            revolve(dome, _DARK, sides=20),
            revolve(foot, RAW_CONCRETE, sides=20),
        ]
    )


@variants(8)
def poster_stand(rng: np.random.Generator) -> Mesh:
    """A glazed poster, 2.4 m high, on a foot; another poster at the back."""
    return lit_poster(rng).placed(0.0, 0.0, 0.3 + 0.15)


def lit_poster(rng: np.random.Generator) -> Mesh:
    """A poster case of 1.36 m by 2 m that faces both ways, its bottom at the origin, on a foot."""
    front, back = rng.integers(10, size=2)
    width, height = _POSTER
    case = box(0.18, width + 0.16, height + 0.2, _DARK).placed(0, 0, 0.0)
    faces = [
        _sheet(f"poster/{front}").placed(-0.095, 0, 0.1 + 0.5 * height),
        _sheet(f"poster/{back}").placed(-0.095, 0, 0.1 + 0.5 * height).placed(0, 0, 0, np.pi),
    ]
    foot = box(0.14, 0.5, 0.75, ALUMINIUM).placed(0, 0, -0.75)
    return merge([case, *faces, foot])


@variants(6)
def pavement_board(rng: np.random.Generator) -> Mesh:
    """A folding board before a shop, 1.1 m: posters at its front and its back."""
    lean = 0.2
    sheet = _sheet(f"poster/{rng.integers(10)}").scaled(1.0, 0.55, 0.55)
    panel = merge([sheet.placed(-0.012, 0), box(0.02, 0.7, 1.02, ALUMINIUM).placed(0, 0, -0.51)])
    cos, sin = np.cos(lean), np.sin(lean)
    tilted = panel.turned([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]).placed(-0.13, 0, 0.53)
    return merge([tilted, tilted.placed(0, 0, 0, np.pi)])


@variants(5)
def poster_on_pole(rng: np.random.Generator) -> Mesh:
    """Two posters back to back, tied to a thin pole: announcements."""
    sheet = _sheet(f"poster/{rng.integers(10)}").scaled(1.0, 0.5, 0.5)
    pair = merge([sheet.placed(-0.045, 0), sheet.placed(-0.045, 0).placed(0, 0, 0, np.pi)])
    return merge([pole(2.6, 0.035), pair.placed(0, 0, 1.7)])


@variants(6)
def billboard(rng: np.random.Generator) -> Mesh:
    """A big wall of posters, 3.8 m by 2.8 m, on wooden legs."""
    paper = Material(f"wide_poster/{rng.integers(5)}", mirror=0.02, infrared=0.6)
    picture = board(3.6, 2.5, paper, ALUMINIUM)
    frame = box(0.08, 3.75, 2.65, painted(0.3, 0.32, 0.3)).placed(0, 0, 0.8)
    legs = [
        tube([(0.06, y, -0.2), (0.06, y, 3.3)], 0.06, UPRIGHT_WOOD, sides=6) for y in (-1.3, 1.3)
    ]
    return merge([frame, picture.placed(-0.05, 0, 0.8 + 1.325), *legs])


def _sheet(texture: str) -> Mesh:
    """A poster that faces -x, its centre at the origin."""
    paper = Material(texture, mirror=0.03, infrared=0.6)
    return board(*_POSTER, paper, ALUMINIUM)
