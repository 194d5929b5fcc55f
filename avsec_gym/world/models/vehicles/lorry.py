"""Lorries: a cab, a chassis on wheels, and box, tarpaulin, tank or platform, by length."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import blob, block
from avsec_gym.world.models.vehicles.cargo import cargo_box, platform, tank
from avsec_gym.world.models.vehicles.coach import BodyBand, coach
from avsec_gym.world.models.vehicles.paint import (
    BLACK_GLOSS,
    CHROME,
    MIRROR_GLASS,
    PLASTIC,
    STEEL,
    UNDERSIDE,
    Finish,
    draw_finish,
    glass,
)
from avsec_gym.world.models.vehicles.plate import number_plate
from avsec_gym.world.models.vehicles.wheel import wheel

TAIL_LAMP = Material("tail_lamp/0", mirror=0.08, infrared=0.6)


def lorry(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """Parts of a lorry.

    Args:
        rng: The source of chance.
        height: Height, metres.
        width: Width, metres, mirrors included.
        length: Length, metres: up to 8 two axles, up to 13 three, beyond it a tractor with a
            trailer.
    """
    finish = draw_finish(rng, "plain", commercial=True)
    half, front, rear = 0.5 * width - 0.04, 0.5 * length, -0.5 * length
    radius = float(np.clip(0.155 * height, 0.36, 0.50))
    cab_length = float(np.clip(0.27 * length, 1.55, 2.25))
    deck = radius * 2.05
    cargo_rear, cargo_front = rear + 0.08, front - cab_length - (0.5 if length > 13 else 0.12)
    low = height < 2.6 or rng.random() < 0.12
    cab_height = height if low else min(height - 0.15, max(0.80 * height, deck + 1.35))
    parts = _cab(finish, cab_height, half - 0.05, front - cab_length, front, radius)
    parts += _load(rng, finish, low, cargo_rear, cargo_front, half, deck, height)
    axles = _axles(length, front, rear)
    parts += _chassis(finish, axles, rear, cargo_front, half, deck, radius)
    tyre = wheel(7, 0.56).scaled(radius, 1.15 * radius, radius)
    for axle in axles:
        placed = tyre.placed(axle, half - 0.03, radius)
        parts += [placed, placed.mirrored()]
    return parts


def _axles(length: float, front: float, rear: float) -> list[float]:
    first = front - min(1.35, 0.2 * length)
    if length > 13.0:
        return [rear + 2.0, rear + 3.3, rear + 4.6, first - 3.6, first]
    if length > 8.6:
        return [rear + 1.7, rear + 3.0, first]
    return [rear + 0.24 * length, first]


def _cab(
    finish: Finish, top: float, half: float, rear: float, front: float, radius: float
) -> list[Mesh]:
    axle = front - min(1.35, 0.62 * (front - rear))
    step, sill = 0.9 * radius, 0.42 * top
    belt, head = 0.56 * top, min(0.84 * top, 0.56 * top + 1.0)
    window = (axle - 0.15 * (front - rear), front - 0.22, glass("side_glass/1"))
    grille = Material("grille/0", tint=(0.5, 0.5, 0.5), infrared=0.2)
    bands = [
        BodyBand(step, finish.bumper, lean=0.0),
        BodyBand(sill, finish.paint, front=finish.paint, lean=0.01),
        BodyBand(belt, finish.paint, lean=0.03),
        BodyBand(
            head,
            finish.paint,
            front=glass("windscreen/1"),
            openings=(window,),
            lean=0.16,
            inset=0.05,
        ),
        BodyBand(top, finish.paint, lean=0.34 if top > 1.3 * belt else 0.2, inset=0.09),
    ]
    parts, _ = coach(
        rear, front, half, 0.5 * radius, bands, axles=[axle], wheel=radius, rounding=(0.1, 0.3)
    )
    x = front + 0.005
    lamp = Material("headlamp/0", mirror=0.12, infrared=0.6)
    size = 0.2
    for side in (-1.0, 1.0):
        y = side * (half - 0.42)
        parts.append(facing(x - 0.005, y, 0.5 * step + 0.3 * radius, 0.38, size, lamp, 1.0))
        mirror_y = side * (half + 0.01)
        parts.append(block(0.10, 0.18, 0.5, PLASTIC).placed(front - 0.12, mirror_y, belt + 0.1))
        parts.append(
            block(0.01, 0.14, 0.42, MIRROR_GLASS).placed(front - 0.176, mirror_y, belt + 0.14)
        )
    parts.append(
        facing(
            x - 0.005, 0.0, 0.5 * (sill + step) + 0.05, 1.1 * half, 0.8 * (sill - step), grille, 1.0
        )
    )
    parts.append(number_plate(finish.plate, x + 0.01, 0.8 * step, front=True))
    parts.append(blob(0.03, 0.16, 0.16, CHROME).placed(x - 0.01, 0.0, sill + 0.05))
    return parts


def facing(
    x: float, y: float, z: float, width: float, height: float, material: Material, way: float
) -> Mesh:
    """A thin plate that faces forward (way 1) or backward (-1), its texture once over it."""
    part = block(0.02, width, height, material)
    normal = part.normals[:, 0] * way > 0.5
    uv = np.zeros_like(part.uv)
    uv[normal, 0] = 0.5 + way * part.vertices[normal, 1] / width * 0.98
    uv[normal, 1] = 0.99 - 0.98 * part.vertices[normal, 2] / height
    moved = part.placed(x, y, z - 0.5 * height)
    return Mesh(moved.vertices, moved.normals, uv, moved.faces, moved.material, moved.materials)


def _load(
    rng: np.random.Generator,
    finish: Finish,
    low: bool,
    rear: float,
    front: float,
    half: float,
    deck: float,
    height: float,
) -> list[Mesh]:
    kind = rng.random()
    if low:
        return platform(
            rear, front, half, deck, min(height, deck + rng.uniform(0.4, 0.7)), finish.paint
        )
    if kind < 0.15 and front - rear > 4.0:
        return tank(rear, front, half, deck, height)
    return cargo_box(rng, rear, front, half, deck, height)


def _chassis(
    finish: Finish,
    axles: list[float],
    rear: float,
    front: float,
    half: float,
    deck: float,
    radius: float,
) -> list[Mesh]:
    length = front - rear
    middle = 0.5 * (front + rear)
    parts = [block(length + 0.6, 0.9, 0.3, UNDERSIDE).placed(middle + 0.3, 0.0, deck - 0.3)]
    parts.append(block(0.10, 1.8 * half, 0.12, STEEL).placed(rear + 0.06, 0.0, radius))
    lamp = Material("tail_lamp/0", mirror=0.08, infrared=0.6)
    for side in (-1.0, 1.0):
        parts.append(facing(rear + 0.02, side * (half - 0.3), deck - 0.16, 0.42, 0.13, lamp, -1.0))
    parts.append(number_plate(finish.plate, rear + 0.005, deck - 0.16, front=False))
    # Side guards between the axles, tanks, and mudguards over the wheels.
    for first, second in pairwise(axles):
        gap = second - first - 2.0 * radius - 0.3
        if gap > 0.6:
            centre = 0.5 * (first + second)
            for z in (0.45, 0.75):
                rail = block(gap, 0.04, 0.12, STEEL).placed(centre, half - 0.08, z * deck)
                parts += [rail, rail.mirrored()]
            parts.append(
                block(0.5 * gap, 0.5, 0.45 * deck, BLACK_GLOSS).placed(
                    centre, half - 0.45, 0.42 * deck
                )
            )
    for axle in axles:
        parts.append(block(0.16, 1.8 * half, 0.16, UNDERSIDE).placed(axle, 0.0, radius - 0.08))
    return parts
