"""Number plates."""

from __future__ import annotations

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.shapes import polygon

PLATES = 144
"""Number of plate textures."""

WIDTH, HEIGHT = 0.52, 0.115
"""Metres."""


def number_plate(
    number: int, x: float, z: float, *, front: bool, y: float = 0.0, share: float = 1.0
) -> Mesh:
    """A plate that reads correctly from outside.

    Args:
        number: Number of the plate; front and rear of one vehicle show the same.
        x: Coordinate x of its middle, metres.
        z: Coordinate z of its middle, metres.
        front: Whether it faces forward.
        y: Coordinate y of its middle, metres.
        share: Size relative to the usual one.
    """
    side = 0.5 * WIDTH * share if front else -0.5 * WIDTH * share
    low, high = z - 0.5 * HEIGHT * share, z + 0.5 * HEIGHT * share
    corners = [(x, y - side, low), (x, y + side, low), (x, y + side, high), (x, y - side, high)]
    uv = [(0.0, HEIGHT), (WIDTH, HEIGHT), (WIDTH, 0.0), (0.0, 0.0)]
    return polygon(corners, Material(f"plate/{number % PLATES}", infrared=1.0), uv)
