"""Buses and trams: long bodies with rows of windows, doors on the right, destination boards."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import block
from avsec_gym.world.models.vehicles.coach import BodyBand, coach
from avsec_gym.world.models.vehicles.lorry import facing
from avsec_gym.world.models.vehicles.paint import (
    BLACK_GLOSS,
    PLASTIC,
    UNDERSIDE,
    glass,
)
from avsec_gym.world.models.vehicles.plate import PLATES, number_plate
from avsec_gym.world.models.vehicles.wheel import wheel
from avsec_gym.world.shapes import tube

Colour = tuple[float, float, float]

_WHITE, _YELLOW, _RED = (0.75, 0.75, 0.73), (0.72, 0.48, 0.02), (0.42, 0.02, 0.02)
_LIVERIES: tuple[tuple[Colour, Colour], ...] = (
    # below and above the windows
    (_YELLOW, _WHITE),
    (_RED, _WHITE),
    (_WHITE, _WHITE),
    (_YELLOW, _RED),
    (_WHITE, _RED),
)


def bus(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """Parts of a town bus or coach."""
    below, above = _livery(rng)
    half, front, rear = 0.5 * width - 0.04, 0.5 * length, -0.5 * length
    radius = float(np.clip(0.155 * height, 0.40, 0.50))
    axles = [rear + 0.26 * length, front - min(2.6, 0.23 * length)]
    parts = _body(below, above, rear, front, half, height, axles, radius, two_ended=False)
    tyre = wheel(7, 0.56).scaled(radius, 0.8 * radius, radius)
    for axle in axles:
        placed = tyre.placed(axle, half - 0.05, radius)
        parts += [placed, placed.mirrored()]
    for side in (-1.0, 1.0):
        mirror = block(0.12, 0.2, 0.4, PLASTIC)
        parts.append(mirror.placed(front - 0.1, side * (half - 0.06), 0.70 * height))
    plate = int(rng.integers(PLATES))
    parts.append(number_plate(plate, front + 0.015, 0.42, front=True))
    parts.append(number_plate(plate, rear - 0.015, 0.55, front=False))
    return parts


def tram(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """Parts of a tram: one to four modules joined by bellows, boxes on the roof."""
    below, above = _livery(rng)
    half = 0.5 * width
    roof = 0.90 * height
    count = max(1, round(length / 9.5))
    module = length / count
    parts: list[Mesh] = []
    for number in range(count):
        rear = -0.5 * length + number * module
        ends = (number == 0, number == count - 1)
        parts += _module(below, above, rear, rear + module, half, roof, ends)
        middle = rear + 0.5 * module
        equipment = Material(tint=(0.30, 0.31, 0.32), infrared=0.4)
        boxes = block(0.45 * module, 1.3 * half, 0.07 * height, equipment)
        parts.append(boxes.placed(middle, 0.0, roof - 0.02))
        for share in (0.22, 0.78):
            x = rear + share * module
            bogie = block(1.7, 1.5 * half, 0.5, UNDERSIDE).placed(x, 0.0, 0.02)
            parts.append(bogie)
        if number + 1 < count:
            bellows = block(0.5, 1.75 * half, roof - 0.5, PLASTIC)
            parts.append(bellows.placed(rear + module, 0.0, 0.38))
    # The pantograph, folded halfway.
    for y in (-0.4, 0.4):
        path = [(0.0, y, roof), (0.9, y, roof + 0.05), (0.1, y, height - 0.02)]
        parts.append(tube(path, 0.025, UNDERSIDE, sides=4))
    parts.append(block(0.3, 1.5, 0.04, UNDERSIDE).placed(0.1, 0.0, height - 0.04))
    return parts


def _livery(rng: np.random.Generator) -> tuple[Material, Material]:
    below, above = _LIVERIES[int(rng.integers(len(_LIVERIES)))]
    return (
        Material(tint=below, mirror=0.05, infrared=0.5),
        Material(tint=above, mirror=0.05, infrared=0.5),
    )


def _module(
    below: Material,
    above: Material,
    rear: float,
    front: float,
    half: float,
    roof: float,
    ends: tuple[bool, bool],
) -> list[Mesh]:
    """One module; an inner end is cut off straight, before the bellows."""
    gap = 0.18
    first, second = (rear if ends[0] else rear + gap), (front if ends[1] else front - gap)
    return _body(below, above, first, second, half, roof, [], 0.4, two_ended=True, ends=ends)


def _body(
    below: Material,
    above: Material,
    rear: float,
    front: float,
    half: float,
    top: float,
    axles: list[float],
    radius: float,
    *,
    two_ended: bool,
    ends: tuple[bool, bool] = (True, True),
) -> list[Mesh]:
    # Windows at even distances; every third place has a door below.
    length = front - rear
    count = max(2, round(length / 1.5))
    edges = np.linspace(rear + 0.35, front - (1.0 if ends[1] else 0.35), count + 1)
    pane, door = glass("side_glass/1"), glass("bus_door")
    windows = tuple((a + 0.05, b - 0.05, pane) for a, b in pairwise(edges))
    doors = tuple(
        (0.5 * (a + b) - 0.6, 0.5 * (a + b) + 0.6, door) for a, b in list(pairwise(edges))[1::3]
    )
    screen, blind = glass("windscreen/1"), BLACK_GLOSS
    rear_screen = screen if two_ended else glass("rear_glass/1")
    front_pane = screen if ends[1] else None
    rear_pane = rear_screen if ends[0] else None
    stripe = Material(tint=(0.05, 0.05, 0.055), mirror=0.05, infrared=0.2)
    # Bands from the skirt to the roof.
    bands = [
        BodyBand(0.22 * top, below, lean=0.0),
        BodyBand(0.40 * top, below, front=below, openings=doors, lean=0.02),
        BodyBand(
            0.76 * top,
            stripe,
            front=front_pane,
            rear=rear_pane,
            openings=windows,
            lean=0.16,
            inset=0.02,
        ),
        BodyBand(
            0.86 * top,
            above,
            front=blind if ends[1] else None,
            rear=blind if ends[0] else None,
            lean=0.22,
            inset=0.05,
        ),
        BodyBand(top, above, lean=0.34, inset=0.12),
    ]
    parts, _ = coach(
        rear,
        front,
        half,
        0.10 * top,
        bands,
        axles=axles,
        wheel=radius,
        rounding=(0.45 if two_ended and ends[0] else 0.15, 0.45 if ends[1] else 0.15),
        squareness=3.6 if two_ended else 4.5,
        rear_lean=1.0 if two_ended and ends[0] else 0.1,
    )
    # Lamps and boards at the ends.
    lamp = Material("headlamp/0", mirror=0.12, infrared=0.6)
    red = Material("tail_lamp/2", mirror=0.1, infrared=0.6)
    board = Material("destination", glow=0.12, infrared=0.1)
    for side in (-1.0, 1.0):
        if ends[1]:
            parts.append(
                facing(front - 0.035, side * 0.66 * half, 0.26 * top, 0.36, 0.2, lamp, 1.0)
            )
        if ends[0]:
            parts.append(facing(rear + 0.035, side * 0.68 * half, 0.28 * top, 0.3, 0.24, red, -1.0))
    if ends[1]:
        parts.append(facing(front - 0.17, 0.0, 0.81 * top, 1.2 * half, 0.07 * top, board, 1.0))
    return parts
