"""What stands on German traffic signs, as the road traffic regulations (StVO) show it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.drawing import (
    Canvas,
    Colour,
    arrow,
    disc,
    fill,
    letters,
    rectangle,
    stroke,
)

WHITE: Colour = (216, 219, 219)
BLACK: Colour = (22, 22, 24)
RED: Colour = (168, 14, 24)
BLUE: Colour = (8, 48, 120)
YELLOW: Colour = (222, 152, 6)
GREEN: Colour = (6, 84, 52)


def outline(name: str, width: float, height: float) -> NDArray[np.float64]:
    """The corners of a sign, counter-clockwise as one reads it, shape (n, 2), from its centre.

    Args:
        name: ``disc``, ``octagon``, ``triangle`` (tip up), ``give_way`` (tip down), ``diamond``
            or ``rectangle``.
        width: Width, metres.
        height: Height, metres.
    """
    half = np.array([0.5 * width, 0.5 * height])
    if name in ("disc", "octagon"):
        count = 24 if name == "disc" else 8
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


def shrunk(corners: NDArray[np.float64], by: float) -> NDArray[np.float64]:
    """A convex outline, its border `by` metres wide on all sides cut off."""
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


def speed_limit(limit: str, on: Canvas) -> None:
    """A number in a red ring."""
    _ring(on)
    letters(on, limit, (0, 0), 0.24, BLACK, widest=0.37, weight=0.17)


def zone_30(on: Canvas) -> None:
    """The beginning of a zone: a small sign within a white one."""
    disc(on, (0, 0.09), 0.26, RED)
    disc(on, (0, 0.09), 0.19, WHITE)
    letters(on, "30", (0, 0.09), 0.19, BLACK, weight=0.17)
    letters(on, "ZONE", (0, -0.28), 0.14, BLACK, widest=0.56)


def no_vehicles(on: Canvas) -> None:
    """A red ring."""
    _ring(on)


def no_entry(on: Canvas) -> None:
    """A white bar."""
    rectangle(on, (-0.235, -0.055), (0.235, 0.055), WHITE)


def keep_right(on: Canvas) -> None:
    """An arrow down to the right."""
    arrow(on, (-0.16, 0.16), (0.17, -0.17), 0.075, WHITE)


def straight_or_right(on: Canvas) -> None:
    """Two arrows from one stem."""
    arrow(on, (-0.06, -0.2), (-0.06, 0.22), 0.06, WHITE)
    stroke(on, [(-0.06, -0.06), (0.04, -0.06)], 0.06, WHITE)
    arrow(on, (0.02, -0.06), (0.22, -0.06), 0.06, WHITE)


def stop(on: Canvas) -> None:
    """The word."""
    letters(on, "STOP", (0, 0), 0.29, WHITE, widest=0.74, weight=0.18)


def give_way(on: Canvas) -> None:
    """A white triangle within the red one."""
    fill(on, shrunk(outline("give_way", 0.9, 0.78), 0.1), WHITE)


def priority_road(on: Canvas) -> None:
    """A yellow diamond."""
    fill(on, outline("diamond", 0.56, 0.56), BLACK)
    fill(on, outline("diamond", 0.53, 0.53), YELLOW)


def no_stopping(crossed: bool, on: Canvas) -> None:
    """A red stroke on blue, or two crossed ones."""
    _ring(on, inside=BLUE)
    stroke(on, [(-0.17, 0.17), (0.17, -0.17)], 0.07, RED)
    if crossed:
        stroke(on, [(-0.17, -0.17), (0.17, 0.17)], 0.07, RED)


def no_turning_back(on: Canvas) -> None:
    """A bent arrow, struck through."""
    _ring(on)
    angle = np.linspace(0.0, np.pi, 12)
    bend = np.stack([0.07 * np.cos(angle), 0.05 + 0.07 * np.sin(angle)], axis=1)
    stroke(on, [(0.07, -0.16), *bend, (-0.07, 0.02)], 0.045, BLACK)
    fill(on, [(-0.14, 0.0), (-0.07, -0.12), (0.0, 0.0)], BLACK)
    stroke(on, [(-0.17, 0.17), (0.17, -0.17)], 0.05, RED)


def no_overtaking(on: Canvas) -> None:
    """A red car beside a black one."""
    _ring(on)
    for x, colour in ((-0.1, RED), (0.1, BLACK)):
        rectangle(on, (x - 0.08, -0.06), (x + 0.08, 0.015), colour)
        rectangle(on, (x - 0.055, 0.0), (x + 0.055, 0.075), colour)
        rectangle(on, (x - 0.075, -0.09), (x - 0.045, -0.05), colour)
        rectangle(on, (x + 0.045, -0.09), (x + 0.075, -0.05), colour)
        rectangle(on, (x - 0.038, 0.02), (x + 0.038, 0.058), WHITE)


def parking(on: Canvas) -> None:
    """The letter."""
    letters(on, "P", (0, 0), 0.4, WHITE, weight=0.18)


def one_way(on: Canvas) -> None:
    """An arrow with the word in it."""
    fill(
        on,
        [
            (-0.35, -0.07),
            (0.18, -0.07),
            (0.18, -0.12),
            (0.36, 0),
            (0.18, 0.12),
            (0.18, 0.07),
            (-0.35, 0.07),
        ],
        WHITE,
    )
    letters(on, "Einbahnstraße", (-0.05, 0), 0.08, BLACK, widest=0.52)


def _person(on: Canvas, x: float, size: float, colour: Colour, y: float = 0.0) -> None:
    for bar in ([(0, 0.1), (0, 0.34)], [(0, 0.12), (-0.09, -0.2)], [(0, 0.12), (0.09, -0.2)]):
        stroke(on, np.array(bar) * size + [x, y], 0.085 * size, colour)
    stroke(
        on, np.array([(-0.13, 0.12), (0, 0.31), (0.13, 0.12)]) * size + [x, y], 0.06 * size, colour
    )
    disc(on, (x, y + 0.44 * size), 0.07 * size, colour)


def footpath(on: Canvas) -> None:
    """A grown-up and a child."""
    _person(on, -0.05, 0.45, WHITE)
    _person(on, 0.1, 0.3, WHITE)


def pedestrian_crossing(on: Canvas) -> None:
    """A walker on stripes."""
    fill(on, [(-0.24, -0.22), (0.24, -0.22), (0, 0.25)], WHITE)
    for x in (-0.14, -0.05, 0.04, 0.13):
        rectangle(on, (x, -0.2), (x + 0.045, -0.13), BLACK)
    _person(on, 0.0, 0.36, BLACK, -0.06)


def bus_stop(on: Canvas) -> None:
    """The letter on yellow."""
    disc(on, (0, 0), 0.175, YELLOW)
    letters(on, "H", (0, 0), 0.19, GREEN, weight=0.2)


def warning(symbol: str, on: Canvas) -> None:
    """A red triangle round a black symbol: ``children``, ``bend`` or ``priority``."""
    fill(on, shrunk(outline("triangle", 0.9, 0.78), 0.1), WHITE)
    if symbol == "children":
        _person(on, -0.06, 0.36, BLACK, -0.13)
        _person(on, 0.09, 0.3, BLACK, -0.15)
    elif symbol == "bend":
        stroke(on, [(-0.06, -0.2), (-0.06, -0.06), (0.05, 0.02), (0.05, 0.12)], 0.045, BLACK)
        fill(on, [(0.0, 0.08), (0.1, 0.08), (0.05, 0.17)], BLACK)
    else:
        fill(on, [(-0.035, -0.2), (0.035, -0.2), (0.035, 0.08), (0, 0.16), (-0.035, 0.08)], BLACK)
        rectangle(on, (-0.13, -0.1), (0.13, -0.06), BLACK)


def bend_arrows(on: Canvas) -> None:
    """Four red angles that point to the right."""
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


def dead_end(on: Canvas) -> None:
    """A street with a red end."""
    rectangle(on, (-0.045, -0.24), (0.045, 0.12), WHITE)
    rectangle(on, (-0.19, 0.1), (0.19, 0.21), RED)


def play_street(on: Canvas) -> None:
    """People, a house and a car."""
    fill(on, [(0.1, -0.02), (0.38, -0.02), (0.38, 0.14), (0.24, 0.25), (0.1, 0.14)], WHITE)
    rectangle(on, (0.2, -0.02), (0.28, 0.1), BLUE)
    _person(on, -0.3, 0.5, WHITE)
    _person(on, -0.12, 0.34, WHITE)
    rectangle(on, (-0.02, -0.22), (0.32, -0.15), WHITE)
    rectangle(on, (0.06, -0.16), (0.24, -0.09), WHITE)
    for x in (0.05, 0.25):
        disc(on, (x, -0.23), 0.035, WHITE)


def street_name(name: str, on: Canvas) -> None:
    """White letters."""
    letters(on, name, (0, 0.005), 0.085, WHITE, widest=0.66, weight=0.15)


def town_entrance(name: str, district: str, on: Canvas) -> None:
    """The name of a town and what it belongs to."""
    letters(on, name, (0, 0.08), 0.15, BLACK, widest=0.85, weight=0.15)
    letters(on, district, (0, -0.18), 0.075, BLACK, widest=0.85, weight=0.14)


def direction_board(name: str, distance: str, on: Canvas) -> None:
    """A place, how far it is, and an arrow to the right."""
    letters(on, name, (-0.1, 0), 0.15, BLACK, widest=0.85, weight=0.15)
    letters(on, distance, (0.42, 0), 0.12, BLACK, widest=0.16)
    fill(
        on,
        [(0.52, 0.12), (0.58, 0.12), (0.7, 0.0), (0.58, -0.12), (0.52, -0.12), (0.62, 0.0)],
        BLACK,
    )


def residents(on: Canvas) -> None:
    """The words below another sign."""
    letters(on, "Anlieger", (0, 0.07), 0.08, BLACK, widest=0.5)
    letters(on, "frei", (0, -0.07), 0.08, BLACK)


def gantry_board(places: tuple[tuple[str, ...], tuple[str, ...]], on: Canvas) -> None:
    """Places above the lanes of a motorway, for the left and the right half."""
    for x, names in zip((-1.6, 1.6), places, strict=True):
        for row, name in enumerate(names):
            letters(on, name, (x, 0.86 - 0.56 * row), 0.38, WHITE, widest=2.7, weight=0.16)
        for side in (-0.75, 0.75):
            arrow(on, (x + side, -0.35), (x + side, -1.15), 0.15, WHITE)
    rectangle(on, (-0.03, -1.25), (0.03, 1.25), WHITE)


def motorway_exit(on: Canvas) -> None:
    """The word and an arrow."""
    letters(on, "Ausfahrt", (-0.12, 0), 0.26, WHITE, widest=1.5)
    arrow(on, (0.68, -0.18), (0.98, 0.14), 0.08, WHITE)
