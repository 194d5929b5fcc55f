"""Small plain solids, made once and stretched."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.shapes import box, ellipsoid


def block(length: float, width: float, height: float, material: Material) -> Mesh:
    """As `shapes.box`, without a texture's scale."""
    return _unit_box().with_material(material).scaled(length, width, height)


def blob(length: float, width: float, height: float, material: Material) -> Mesh:
    """An ellipsoid about the origin, of few faces."""
    return _unit_ball().with_material(material).scaled(0.5 * length, 0.5 * width, 0.5 * height)


def cushion(length: float, width: float, height: float, material: Material) -> Mesh:
    """A box with very round edges about the origin, of few faces."""
    size = (0.5 * length, 0.5 * width, 0.5 * height)
    return _unit_cushion().with_material(material).scaled(*size)


@functools.cache
def _unit_box() -> Mesh:
    return box(1.0, 1.0, 1.0)


@functools.cache
def _unit_ball() -> Mesh:
    return ellipsoid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), rings=5)


@functools.cache
def _unit_cushion() -> Mesh:
    ball = ellipsoid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), rings=6)
    # A superellipsoid: the ball's points pushed out towards the corners.
    pushed = np.sign(ball.vertices) * np.abs(ball.vertices) ** np.float32(0.5)
    return replace(ball, vertices=pushed)
