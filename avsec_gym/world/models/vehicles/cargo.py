"""What lorries and trailers carry: boxes and tarpaulins with lettering, tanks, platforms."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import block
from avsec_gym.world.models.vehicles.paint import STEEL, UNDERSIDE
from avsec_gym.world.shapes import polygon, tube

SIDES = 8
"""Number of textures of cargo sides."""

_SIDE_SIZE = (8.0, 2.5)
_DOOR_SIZE = (2.5, 2.5)


def cargo_box(
    rng: np.random.Generator, rear: float, front: float, half: float, bottom: float, top: float
) -> list[Mesh]:
    """A box body or tarpaulin with lettering that reads correctly on both sides."""
    side = Material(f"cargo_side/{int(rng.integers(SIDES))}", infrared=0.5)
    doors = Material("cargo_doors", infrared=0.5)
    white = Material(tint=(0.62, 0.62, 0.61), infrared=0.55)
    left, right = (front, half), (rear, -half)
    back, ahead = (rear, half), (front, -half)
    roof = [(rear, -half, top), (front, -half, top), (front, half, top), (rear, half, top)]
    floor = [(x, y, bottom) for x, y, _ in reversed(roof)]
    return [
        _wall(left, back, bottom, top, side, _SIDE_SIZE),
        _wall(right, ahead, bottom, top, side, _SIDE_SIZE),
        _wall(back, right, bottom, top, doors, _DOOR_SIZE),
        _wall(ahead, left, bottom, top, white, (1.0, 1.0)),
        polygon(roof, white),
        polygon(floor, UNDERSIDE),
    ]


def _wall(
    first: tuple[float, float],
    second: tuple[float, float],
    bottom: float,
    top: float,
    material: Material,
    size: tuple[float, float],
) -> Mesh:
    """An upright wall, first to second from left to right, that shows its texture once."""
    corners = [(*first, bottom), (*second, bottom), (*second, top), (*first, top)]
    # A little inside the picture, whose edges would run on at the other side.
    uv = np.array([(0.005, 0.995), (0.995, 0.995), (0.995, 0.005), (0.005, 0.005)])
    return polygon(corners, material, uv * size)


def tank(rear: float, front: float, half: float, bottom: float, top: float) -> list[Mesh]:
    """A polished tank with domed ends on a frame."""
    radius = 0.5 * (top - bottom) - 0.06
    x = np.array([rear, rear + 0.05, rear + 0.25, front - 0.25, front - 0.05, front])
    path = np.column_stack([x, np.zeros(6), np.full(6, bottom + radius + 0.02)])
    metal = Material(tint=(0.5, 0.51, 0.52), mirror=0.35, infrared=0.6)
    radii = radius * np.array([0.5, 0.8, 1.0, 1.0, 0.8, 0.5])
    body = tube(path, radii, metal, sides=20).scaled(1.0, (half - 0.02) / radius, 1.0)
    walk = block(0.8 * (front - rear), 0.5, 0.10, STEEL).placed(
        0.5 * (rear + front), 0.0, top - 0.1
    )
    frame = block(front - rear, 1.4 * half, 0.14, UNDERSIDE).placed(
        0.5 * (rear + front), 0.0, bottom - 0.02
    )
    return [body, walk, frame]


def platform(
    rear: float, front: float, half: float, bottom: float, top: float, paint: Material
) -> list[Mesh]:
    """A flat bed with low sides."""
    length, middle = front - rear, 0.5 * (front + rear)
    tall = top - bottom
    wood = Material(tint=(0.16, 0.13, 0.10), infrared=0.4)
    long_side = block(length, 0.05, tall, STEEL).placed(middle, half - 0.025, bottom)
    short_side = block(0.05, 2.0 * half - 0.1, tall, STEEL)
    return [
        block(length - 0.1, 2.0 * half - 0.12, 0.06, wood).placed(middle, 0.0, bottom + 0.015),
        long_side,
        long_side.mirrored(),
        short_side.placed(rear + 0.025, 0.0, bottom),
        block(0.06, 2.0 * half - 0.1, 1.4 * tall, paint).placed(front - 0.03, 0.0, bottom),
    ]
