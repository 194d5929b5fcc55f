"""Small plain solids, made once and stretched."""

from __future__ import annotations

import functools

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.shapes import box, ellipsoid


def block(length: float, width: float, height: float, material: Material) -> Mesh:
    """As `shapes.box`, without a texture's scale."""
    return _unit_box(material).scaled(length, width, height)


def blob(length: float, width: float, height: float, material: Material) -> Mesh:
    """An ellipsoid about the origin, of few faces."""
    return _unit_ball(material).scaled(0.5 * length, 0.5 * width, 0.5 * height)


@functools.lru_cache(maxsize=256)
def _unit_box(material: Material) -> Mesh:
    return box(1.0, 1.0, 1.0, material)


@functools.lru_cache(maxsize=256)
def _unit_ball(material: Material) -> Mesh:
    return ellipsoid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), material, rings=5)
