"""Stones laid in bonds: what slabs, setts, clinker and kerbs have in common."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.textures.noise import fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture


class Laying(NamedTuple):
    """How stones are laid.

    Args:
        length: Length of a stone along a picture's rows, metres.
        width: Width of a stone across them, metres.
        stagger: Shift of every other row, in stones.
        diagonal: Square stones at 45 degrees; `length` and `width` are their diagonals.
    """

    length: float
    width: float
    stagger: float = 0.0
    diagonal: bool = False


LAYINGS = {
    "slabs/0": Laying(0.3, 0.3, 0.5),
    "slabs/1": Laying(0.48, 0.48, diagonal=True),
    "slabs/2": Laying(0.6, 0.3, 0.5),
    "slabs/3": Laying(0.6, 0.6),
    **{f"setts/{variant}": Laying(4.0 / 40, 4.0 / 42, 0.5) for variant in range(3)},
    **{f"clinker/{variant}": Laying(0.2, 0.1, 0.5) for variant in range(2)},
}
"""Layings of the textures of that name."""


class Bond(NamedTuple):
    """Which stone each pixel of a square picture belongs to."""

    stone: NDArray[np.int64]
    """Number of the stone, shape (side, side)."""
    edge: NDArray[np.float32]
    """Distance to the stone's edge, pixels, shape (side, side)."""


def bond(
    rng: np.random.Generator, side: int, metres: float, laying: Laying, jitter: float = 0.0
) -> Bond:
    """Laid stones that fit a square picture.

    Args:
        rng: The source of chance.
        side: Side of the picture, pixels.
        metres: Side of the picture, metres.
        laying: Size and pattern of the stones.
        jitter: Jitter of the joints' places, in stones.
    """
    if laying.diagonal:
        return _diagonal_bond(side, round(metres / laying.length))
    rows, columns = round(metres / laying.width), round(metres / laying.length)
    size = side / np.array([rows, columns])
    tops = (np.arange(rows) + jitter * rng.uniform(-0.5, 0.5, rows)) * size[0]
    row, above, below = _slots(np.broadcast_to(tops, (1, rows)), side)
    starts = np.arange(columns) + (np.arange(rows) % 2 * laying.stagger)[:, None]
    starts = starts + jitter * rng.uniform(-1.0, 1.0, starts.shape)
    column, before, behind = _slots(starts * size[1], side)
    lines = row[0]
    edge_y = np.minimum(above[0], below[0])[:, None]
    edge_x = np.minimum(before, behind)[lines]
    stone = lines[:, None] * columns + column[lines]
    return Bond(stone, np.minimum(edge_x, edge_y).astype(np.float32))


def stones(
    rng: np.random.Generator,
    layout: Bond,
    colour: ArrayLike,
    *,
    joint_colour: ArrayLike,
    joint: float,
    spread: float,
    grain: float,
    round_: float = 0.0,
) -> Picture:
    """A picture of laid stones, rather alike: the picture repeats, and would be recognised.

    `avsec_gym.world.road.paving` shades them differently from place to place.

    Args:
        rng: The source of chance.
        layout: Number of the stone at each pixel.
        colour: Colour of the stones, 0..255 each.
        joint_colour: Colour of the joints between them.
        joint: Half the joints' width, pixels.
        spread: Deviation of the stones' brightness.
        grain: Deviation of the pixels of a stone.
        round_: Width over which the edges darken, pixels.
    """
    side = len(layout.edge)
    count = int(layout.stone.max()) + 1
    shade = spread * rng.standard_normal(count).astype(np.float32)
    warmth = 0.25 * spread * rng.standard_normal((count, 1)).astype(np.float32)
    hue = warmth * np.array([1.0, 0.1, -1.0], np.float32)
    fine = white_noise(rng, side, side, 0.5)
    cloud = fractal_noise(rng, side, side, cells=5, persistence=0.7)
    level = 1.0 + shade[layout.stone] + grain * fine + 0.015 * cloud
    if round_:
        level -= 0.22 * np.clip(1.0 - (layout.edge - joint) / round_, 0.0, 1.0)
    face = np.asarray(colour, np.float32) * (level[..., None] + hue[layout.stone])
    gap = (
        np.asarray(joint_colour, np.float32)
        * (1.0 + 0.2 * white_noise(rng, side, side, 1.0))[..., None]
    )
    cover = np.clip(layout.edge - joint + 0.5, 0.0, 1.0)[..., None]
    return picture(gap + (face - gap) * cover)


def _diagonal_bond(side: int, count: int) -> Bond:
    """Square stones at 45 degrees, `count` along each diagonal direction."""
    pixel = np.arange(side) + 0.5
    size = side / count
    first, second = pixel[None] + pixel[:, None], pixel[None] - pixel[:, None]
    stone = (first // size % count).astype(int) * count + (second // size % count).astype(int)
    inside = np.stack([first % size, second % size])
    edge = np.minimum(inside, size - inside).min(axis=0) / np.sqrt(2.0)
    return Bond(stone, edge.astype(np.float32))


def _slots(
    starts: NDArray[np.float64], side: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """For pixels 0..side of each line: the slot, and distances to its start and end.

    Args:
        starts: First pixels of the slots, ascending, shape (lines, n); the last slot runs on round
            the edge to the first.
        side: Length of a line, pixels.
    """
    count = starts.shape[1]
    pixel = np.arange(side) + 0.5
    edges = np.concatenate([starts - side, starts, starts[:, :1] + side], axis=1)
    at = np.stack([np.searchsorted(line, pixel, side="right") - 1 for line in edges])
    lines = np.arange(len(starts))[:, None]
    return at % count, pixel - edges[lines, at], edges[lines, np.minimum(at + 1, 2 * count)] - pixel
