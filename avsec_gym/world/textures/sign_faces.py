"""The faces of German traffic signs, as they stand in the road traffic regulations (StVO)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.drawing import (
    Canvas,
    Colour,
    arrow,
    canvas,
    disc,
    fill,
    finished,
    letters,
    rectangle,
    stroke,
)
from avsec_gym.world.textures.texture import Picture, Texture

WHITE: Colour = (236, 238, 238)
BLACK: Colour = (22, 22, 24)
RED: Colour = (196, 22, 32)
BLUE: Colour = (16, 70, 160)
YELLOW: Colour = (250, 196, 10)
GREEN: Colour = (10, 110, 70)
_RIM: Colour = (150, 154, 156)
"""Bare aluminium round the edge."""


class SignFace(NamedTuple):
    """A sign as it is made."""

    outline: str
    """A name for `outline`."""
    width: float
    """Metres."""
    height: float
    paint: Callable[[Canvas], None]
    """Draws all but the rim and the ground."""
    ground: Colour = WHITE
    edge: Colour = WHITE
    """A narrow line along the outline."""


def outline(name: str, width: float, height: float) -> NDArray[np.float64]:
    """The corners of a sign, counter-clockwise as one reads it, shape (n, 2), from its centre.

    Args:
        name: ``disc``, ``octagon``, ``triangle`` (tip up), ``give_way`` (tip down), ``diamond``
            or ``rectangle``.
        width: Metres.
        height: Metres.
    """
    half = np.array([0.5 * width, 0.5 * height])
    if name in ("disc", "octagon"):
        count = 20 if name == "disc" else 8
        angle = (np.arange(count) + 0.5) * 2.0 * np.pi / count
        reach = 1.0 / np.cos(np.pi / count)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1) * half * reach
    corners = {
        "triangle": [(-1, -1), (1, -1), (0, 1)],
        "give_way": [(0, -1), (1, 1), (-1, 1)],
        "diamond": [(0, -1), (1, 0), (0, 1), (-1, 0)],
        "rectangle": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
    }
    return np.array(corners[name], float) * half


def sign_texture(face: SignFace) -> Texture:
    """The texture of one sign; it shows the sign once, upright."""

    def make(_: int, rng: np.random.Generator) -> Picture:
        density = min(230.0, 480.0 / face.width)
        on = canvas(face.width, face.height, _RIM, density)
        corners = outline(face.outline, face.width, face.height)
        for inset, colour in ((0.012, face.edge), (0.03, face.ground)):
            _inset(on, face, corners, inset, colour)
        face.paint(on)
        return finished(on, rng)

    return Texture((face.width, face.height), 1, make)


def _inset(
    on: Canvas, face: SignFace, corners: NDArray[np.float64], by: float, colour: Colour
) -> None:
    if face.outline == "disc":
        disc(on, (0, 0), 0.5 * face.width - by, colour)
    elif face.outline == "octagon":
        fill(on, corners * (1 - 2 * by / face.width), colour)
    else:
        # A border equally wide on all edges, whatever the shape's angles.
        fill(on, _shrunk(corners, by), colour)


def _shrunk(corners: NDArray[np.float64], by: float) -> NDArray[np.float64]:
    before = corners - np.roll(corners, 1, axis=0)
    after = np.roll(before, -1, axis=0)
    first, second = (
        np.stack([-side[:, 1], side[:, 0]], 1) / np.linalg.norm(side, axis=1, keepdims=True)
        for side in (before, after)
    )
    middle = first + second
    return corners + by * 2.0 * middle / (middle**2).sum(axis=1, keepdims=True)


def _ring(on: Canvas, colour: Colour = RED, inside: Colour = WHITE) -> None:
    disc(on, (0, 0), 0.285, colour)
    disc(on, (0, 0), 0.215, inside)


def _speed(limit: str, on: Canvas) -> None:
    _ring(on)
    letters(on, limit, (0, 0), 0.24, BLACK, widest=0.37, weight=0.17)


def _zone_30(on: Canvas) -> None:
    disc(on, (0, 0.09), 0.26, RED)
    disc(on, (0, 0.09), 0.19, WHITE)
    letters(on, "30", (0, 0.09), 0.19, BLACK, weight=0.17)
    letters(on, "ZONE", (0, -0.28), 0.14, BLACK, widest=0.56)


def _no_entry(on: Canvas) -> None:
    rectangle(on, (-0.235, -0.055), (0.235, 0.055), WHITE)


def _keep_right(on: Canvas) -> None:
    arrow(on, (-0.16, 0.16), (0.17, -0.17), 0.075, WHITE)


def _straight_or_right(on: Canvas) -> None:
    arrow(on, (-0.06, -0.2), (-0.06, 0.22), 0.06, WHITE)
    stroke(on, [(-0.06, -0.06), (0.04, -0.06)], 0.06, WHITE)
    arrow(on, (0.02, -0.06), (0.22, -0.06), 0.06, WHITE)


def _stop(on: Canvas) -> None:
    letters(on, "STOP", (0, 0), 0.29, WHITE, widest=0.74, weight=0.18)


def _give_way(on: Canvas) -> None:
    fill(on, _shrunk(outline("give_way", 0.9, 0.78), 0.1), WHITE)


def _priority_road(on: Canvas) -> None:
    fill(on, outline("diamond", 0.56, 0.56), BLACK)
    fill(on, outline("diamond", 0.53, 0.53), YELLOW)


def _no_stopping(crossed: bool, on: Canvas) -> None:
    _ring(on, inside=BLUE)
    stroke(on, [(-0.17, 0.17), (0.17, -0.17)], 0.07, RED)
    if crossed:
        stroke(on, [(-0.17, -0.17), (0.17, 0.17)], 0.07, RED)


def _no_turning_back(on: Canvas) -> None:
    _ring(on)
    angle = np.linspace(0.0, np.pi, 12)
    bend = np.stack([0.07 * np.cos(angle), 0.05 + 0.07 * np.sin(angle)], axis=1)
    stroke(on, [(0.07, -0.16), *bend, (-0.07, 0.02)], 0.045, BLACK)
    fill(on, [(-0.14, 0.0), (-0.07, -0.12), (0.0, 0.0)], BLACK)
    stroke(on, [(-0.17, 0.17), (0.17, -0.17)], 0.05, RED)


def _no_overtaking(on: Canvas) -> None:
    _ring(on)
    for x, colour in ((-0.1, RED), (0.1, BLACK)):
        rectangle(on, (x - 0.08, -0.06), (x + 0.08, 0.015), colour)
        rectangle(on, (x - 0.055, 0.0), (x + 0.055, 0.075), colour)
        rectangle(on, (x - 0.075, -0.09), (x - 0.045, -0.05), colour)
        rectangle(on, (x + 0.045, -0.09), (x + 0.075, -0.05), colour)
        rectangle(on, (x - 0.038, 0.02), (x + 0.038, 0.058), WHITE)


def _parking(on: Canvas) -> None:
    letters(on, "P", (0, 0), 0.4, WHITE, weight=0.18)


def _one_way(on: Canvas) -> None:
    arrow(on, (-0.35, 0), (0.36, 0), 0.14, WHITE)
    letters(on, "Einbahnstrasse", (-0.04, 0), 0.075, BLUE, widest=0.46)


def _person(on: Canvas, x: float, size: float, colour: Colour) -> None:
    for bar in ([(0, 0.1), (0, 0.34)], [(0, 0.12), (-0.09, -0.2)], [(0, 0.12), (0.09, -0.2)]):
        stroke(on, np.array(bar) * size + [x, 0], 0.085 * size, colour)
    stroke(
        on, np.array([(-0.13, 0.12), (0, 0.31), (0.13, 0.12)]) * size + [x, 0], 0.06 * size, colour
    )
    disc(on, (x, 0.44 * size), 0.07 * size, colour)


def _footpath(on: Canvas) -> None:
    _person(on, -0.05, 0.45, WHITE)
    _person(on, 0.1, 0.3, WHITE)


def _crossing(on: Canvas) -> None:
    fill(on, [(-0.24, -0.22), (0.24, -0.22), (0, 0.25)], WHITE)
    for x in (-0.14, -0.05, 0.04, 0.13):
        rectangle(on, (x, -0.2), (x + 0.045, -0.13), BLACK)
    _person(on, 0.0, 0.3, BLACK)


def _bus_stop(on: Canvas) -> None:
    disc(on, (0, 0), 0.175, YELLOW)
    letters(on, "H", (0, 0), 0.19, GREEN, weight=0.2)


def _warning(symbol: str, on: Canvas) -> None:
    fill(on, _shrunk(outline("triangle", 0.9, 0.78), 0.1), WHITE)
    if symbol == "children":
        _person(on, -0.06, 0.3, BLACK)
        _person(on, 0.08, 0.24, BLACK)
    elif symbol == "bend":
        stroke(on, [(-0.06, -0.2), (-0.06, -0.06), (0.05, 0.02), (0.05, 0.12)], 0.045, BLACK)
        fill(on, [(0.0, 0.08), (0.1, 0.08), (0.05, 0.17)], BLACK)
    else:
        fill(on, [(-0.035, -0.2), (0.035, -0.2), (0.035, 0.08), (0, 0.16), (-0.035, 0.08)], BLACK)
        rectangle(on, (-0.13, -0.1), (0.13, -0.06), BLACK)


def _bend_arrows(on: Canvas) -> None:
    for x in (-0.75, -0.25, 0.25, 0.75):
        fill(
            on,
            [
                (x - 0.17, 0.25),
                (x + 0.05, 0.25),
                (x + 0.2, 0),
                (x + 0.05, -0.25),
                (x - 0.17, -0.25),
                (x - 0.02, 0),
            ],
            RED,
        )


def _dead_end(on: Canvas) -> None:
    rectangle(on, (-0.045, -0.24), (0.045, 0.12), WHITE)
    rectangle(on, (-0.19, 0.1), (0.19, 0.21), RED)


def _play_street(on: Canvas) -> None:
    fill(on, [(0.08, -0.12), (0.4, -0.12), (0.4, 0.12), (0.24, 0.24), (0.08, 0.12)], WHITE)
    rectangle(on, (0.2, -0.12), (0.28, 0.04), BLUE)
    _person(on, -0.3, 0.5, WHITE)
    _person(on, -0.1, 0.32, WHITE)
    rectangle(on, (0.02, -0.24), (0.36, -0.17), WHITE)
    disc(on, (0.1, -0.25), 0.03, WHITE)
    disc(on, (0.28, -0.25), 0.03, WHITE)


def _street_name(name: str, on: Canvas) -> None:
    letters(on, name, (0, 0.005), 0.085, WHITE, widest=0.66, weight=0.15)


def _town(name: str, district: str, on: Canvas) -> None:
    letters(on, name, (0, 0.08), 0.15, BLACK, widest=0.85, weight=0.15)
    letters(on, district, (0, -0.18), 0.075, BLACK, widest=0.85, weight=0.14)


def _direction(name: str, distance: str, on: Canvas) -> None:
    letters(on, name, (-0.1, 0), 0.15, BLACK, widest=0.85, weight=0.15)
    letters(on, distance, (0.42, 0), 0.12, BLACK, widest=0.16)
    fill(
        on,
        [(0.52, 0.12), (0.58, 0.12), (0.7, 0.0), (0.58, -0.12), (0.52, -0.12), (0.62, 0.0)],
        BLACK,
    )


def _residents(on: Canvas) -> None:
    letters(on, "Anlieger", (0, 0.07), 0.08, BLACK, widest=0.5)
    letters(on, "frei", (0, -0.07), 0.08, BLACK)


def _gantry(places: tuple[tuple[str, ...], tuple[str, ...]], on: Canvas) -> None:
    for x, names in zip((-1.6, 1.6), places, strict=True):
        for row, name in enumerate(names):
            letters(on, name, (x, 0.85 - 0.5 * row), 0.32, WHITE, widest=2.6, weight=0.14)
        for side in (-0.7, 0.7):
            arrow(on, (x + side, -0.55), (x + side, -1.15), 0.11, WHITE)
    rectangle(on, (-0.02, -1.25), (0.02, 1.25), WHITE)


def _exit(on: Canvas) -> None:
    letters(on, "Ausfahrt", (-0.12, 0), 0.26, WHITE, widest=1.5)
    arrow(on, (0.68, -0.18), (0.98, 0.14), 0.08, WHITE)


def _round(paint: Callable[[Canvas], None], ground: Colour = WHITE) -> SignFace:
    return SignFace("disc", 0.6, 0.6, paint, ground)


def _square(paint: Callable[[Canvas], None], ground: Colour = BLUE, side: float = 0.6) -> SignFace:
    return SignFace("rectangle", side, side, paint, ground)


STREET_NAMES = ("Hauptstr.", "Lindenweg", "Goethestr.", "Rheinstr.", "Schulstr.", "Gartenweg")

SIGN_FACES: dict[str, SignFace] = {
    **{
        f"speed_{limit}": _round(partial(_speed, limit))
        for limit in ("30", "50", "70", "100", "120")
    },
    "zone_30": _square(_zone_30, WHITE, 0.84),
    "no_entry": _round(_no_entry, RED),
    "keep_right": _round(_keep_right, BLUE),
    "straight_or_right": _round(_straight_or_right, BLUE),
    "stop": SignFace("octagon", 0.9, 0.9, _stop, RED),
    "give_way": SignFace("give_way", 0.9, 0.78, _give_way, RED),
    "priority_road": SignFace("diamond", 0.84, 0.84, _priority_road),
    "no_stopping": _round(partial(_no_stopping, True)),
    "no_parking": _round(partial(_no_stopping, False)),
    "no_turning_back": _round(_no_turning_back),
    "no_overtaking": _round(_no_overtaking),
    "no_vehicles": _round(_ring),
    "footpath": _round(_footpath, BLUE),
    "parking": _square(_parking),
    "crossing": _square(_crossing),
    "dead_end": _square(_dead_end),
    "play_street": SignFace("rectangle", 0.9, 0.6, _play_street, BLUE),
    "one_way": SignFace("rectangle", 0.8, 0.3, _one_way, BLUE),
    "bus_stop": SignFace("disc", 0.45, 0.45, _bus_stop, GREEN, YELLOW),
    "children": SignFace("triangle", 0.9, 0.78, partial(_warning, "children"), RED),
    "bend": SignFace("triangle", 0.9, 0.78, partial(_warning, "bend"), RED),
    "priority": SignFace("triangle", 0.9, 0.78, partial(_warning, "priority"), RED),
    "bend_arrows": SignFace("rectangle", 2.0, 0.5, _bend_arrows),
    "residents": SignFace("rectangle", 0.6, 0.33, _residents, WHITE, BLACK),
    **{
        f"street_name_{index}": SignFace("rectangle", 0.8, 0.16, partial(_street_name, name), BLUE)
        for index, name in enumerate(STREET_NAMES)
    },
    **{
        f"town_{index}": SignFace("rectangle", 1.0, 0.65, partial(_town, *names), YELLOW, BLACK)
        for index, names in enumerate(
            (
                ("Durlach", "Stadt Karlsruhe"),
                ("Ettlingen", "Landkreis Karlsruhe"),
                ("Rastatt", "Baden"),
            )
        )
    },
    **{
        f"direction_{index}": SignFace(
            "rectangle", 1.5, 0.35, partial(_direction, *names), YELLOW, BLACK
        )
        for index, names in enumerate((("Ettlingen", "7"), ("Bruchsal", "21"), ("Pforzheim", "26")))
    },
    **{
        f"gantry_{index}": SignFace("rectangle", 6.4, 2.6, partial(_gantry, names), BLUE)
        for index, names in enumerate(
            (
                (("Stuttgart", "Pforzheim"), ("Basel", "Ettlingen")),
                (("Frankfurt", "Heidelberg"), ("Karlsruhe", "Durlach")),
                (("Heilbronn", "Bretten"), ("Mannheim", "Bruchsal")),
            )
        )
    },
    "exit": SignFace("rectangle", 2.2, 0.6, _exit, BLUE),
}
"""By name; the texture of one is called ``sign_<name>``."""
