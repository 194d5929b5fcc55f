"""Windows and doors: reveals, frames, panes, shutters, sills and surrounds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings.panels import Floats, Panels, boxes, quads, upright

PANES = 8
"""Variants of the texture ``window_pane``."""


_REVEAL = np.array(
    [
        [(0, 4, 2), (0, 5, 2), (0, 5, 3), (0, 4, 3)],
        [(1, 5, 2), (1, 4, 2), (1, 4, 3), (1, 5, 3)],
        [(0, 4, 2), (1, 4, 2), (1, 5, 2), (0, 5, 2)],
        [(0, 5, 3), (1, 5, 3), (1, 4, 3), (0, 4, 3)],
    ]
)
"""Corners of an opening's left, right, lower and upper side: x, y, z among left, right, low, high,
near, far."""


@dataclass(frozen=True)
class WindowStyle:
    """How all windows of a facade look.

    Args:
        frame: Material of the bars.
        reveal: Material of the sides of the opening.
        recess: Distance from the facade's plane to the frame, metres.
        frame_width: Width of the bars, metres.
        sashes: Panes side by side.
        transom: Height of a cross bar as a share of the opening's; 0 for none.
        sill: The slab below the window; None for none.
        surround: Raised border of the opening; None for none.
        surround_width: Width of the border, metres.
        lintel: The surround has a small cornice above.
        shutter: Roller shutters; None for none.
        shutters_down: Share of the windows whose shutters are at least partly down.
        folding: Wooden shutters that stand open left and right of the window; None for none.
    """

    frame: Material
    reveal: Material
    recess: float = 0.13
    frame_width: float = 0.07
    sashes: int = 2
    transom: float = 0.0
    sill: Material | None = None
    surround: Material | None = None
    surround_width: float = 0.12
    lintel: bool = False
    shutter: Material | None = None
    shutters_down: float = 0.3
    folding: Material | None = None

    def plain(self) -> WindowStyle:
        """Without all that only the street's side has."""
        return replace(
            self, sashes=1, transom=0.0, sill=None, surround=None, lintel=False, folding=None
        )


def pane_material(variant: int) -> Material:
    """Window glass before a room: the LiDAR finds its frame and the curtain, faintly."""
    return Material(f"window_pane/{variant}", mirror=0.08, infrared=0.06)


def windows(openings: Floats, style: WindowStyle, rng: np.random.Generator) -> list[Panels]:
    """Fills openings, shape (n, 4): left, right, lower, upper end, in a wall that faces -y."""
    if not len(openings):
        return []
    out = 0.05 if style.surround is not None else 0.0
    x0, x1, z0, z1 = openings.T
    parts = [
        reveals(openings, -out, style.recess, style.reveal),
        upright(style.frame, *openings.T, y=style.recess),
        *_panes(openings, style, rng),
    ]
    if style.shutter is not None:
        parts.append(_shutters(openings, style, style.shutter, rng))
    if style.surround is not None:
        parts += _surrounds(openings, style, style.surround, out)
    if style.sill is not None:
        hidden = ("left", "right")
        parts.append(_raised(style.sill, x0 - 0.06, x1 + 0.06, z0 - 0.06, z0, 0.09 + out, hidden))
    if style.folding is not None:
        wide, near = 0.5 * (x1 - x0), style.surround_width * (style.surround is not None)
        for inner, outer in ((x0 - near - wide, x0 - near), (x1 + near, x1 + near + wide)):
            parts.append(_raised(style.folding, inner, outer, z0, z1, 0.06))
    return parts


def doors(
    openings: Floats,
    leaf: Material,
    surround: Material,
    reveal: Material,
    *,
    recess: float = 0.25,
    border: float = 0.1,
) -> list[Panels]:
    """Recessed leaves that show one whole texture each, with a raised border round them.

    Args:
        openings: Left, right, lower and upper end of each, shape (n, 4), metres.
        leaf: Material of the door.
        surround: Material of the border, open below.
        reveal: Material of the sides of the opening.
        recess: Distance from the facade's plane to the leaf, metres.
        border: Width of the border, metres; it must be free of other openings.
    """
    x0, x1, z0, z1 = openings.T
    parts = [
        reveals(openings, -0.06, recess, reveal),
        upright(leaf, x0, x1, z0, z1, y=recess, once=True),
    ]
    if border:
        parts += [
            _raised(surround, x0 - border, x0, z0, z1, 0.06),
            _raised(surround, x1, x1 + border, z0, z1, 0.06),
            _raised(surround, x0 - border, x1 + border, z1, z1 + border, 0.06),
        ]
    return parts


def bars(
    material: Material, opening: Floats, columns: int, rows: int, width: float, y: float
) -> Panels:
    """A frame with bars that divide one opening (shape (4,)) into columns and rows of panes."""
    x0, x1, z0, z1 = opening
    across, half = np.linspace(x0, x1, columns + 1), 0.5 * width
    up = np.linspace(z0, z1, rows + 1)
    left = np.concatenate([np.clip(across - half, x0, x1 - width), np.full(rows + 1, x0)])
    right = np.concatenate([left[: columns + 1] + width, np.full(rows + 1, x1)])
    low = np.concatenate([np.full(columns + 1, z0), np.clip(up - half, z0, z1 - width)])
    high = np.concatenate([np.full(columns + 1, z1), low[columns + 1 :] + width])
    # Posts stand a little before the cross bars: no two faces in one place.
    depth = np.concatenate([np.full(columns + 1, y - 0.01), np.full(rows + 1, y)])
    return upright(material, left, right, low, high, y=depth)


def reveals(openings: Floats, front: float, back: float, material: Material) -> Panels:
    """Left, right, upper and lower sides of the openings."""
    x0, x1, z0, z1 = openings.T
    ends = np.array(np.broadcast_arrays(x0, x1, z0, z1, front, back))
    return quads(material, ends[_REVEAL].transpose(3, 0, 1, 2).reshape(-1, 4, 3))


def _panes(openings: Floats, style: WindowStyle, rng: np.random.Generator) -> list[Panels]:
    """The glass between the bars; all panes of a window show parts of one picture.

    Neighbours in one house like the same curtains: a few variants, unevenly spread.
    """
    house = rng.choice(PANES, 4, replace=False)
    variant = rng.choice(house, len(openings), p=[0.4, 0.3, 0.2, 0.1])
    x0, x1, z0, z1 = openings.T[..., None]
    bar = style.frame_width
    pitch = (x1 - x0 - bar) / style.sashes
    left = x0 + bar + pitch * np.arange(style.sashes)
    right = left + pitch - bar
    low, high = np.broadcast_to(z0 + bar, left.shape), np.broadcast_to(z1 - bar, left.shape)
    if style.transom:
        cross = np.broadcast_to(z0 + style.transom * (z1 - z0), left.shape)
        low, high = np.hstack([low, cross + 0.5 * bar]), np.hstack([cross - 0.5 * bar, high])
        left, right = np.hstack([left, left]), np.hstack([right, right])
    u = (np.stack([left, right, right, left], axis=-1) - x0[..., None]) / (x1 - x0)[..., None]
    v = (z1[..., None] - np.stack([low, low, high, high], axis=-1)) / (z1 - z0)[..., None]
    uv = np.stack([u, v], axis=-1)
    parts = []
    for number in np.unique(variant):
        here = variant == number
        ends = (end[here].ravel() for end in (left, right, low, high))
        glass = upright(pane_material(int(number)), *ends, y=style.recess - 0.02)
        parts.append(replace(glass, uv=uv[here].reshape(-1, 4, 2)))
    return parts


def _shutters(
    openings: Floats, style: WindowStyle, material: Material, rng: np.random.Generator
) -> Panels:
    """Roller shutters, some closed, many a hand's breadth down."""
    count = len(openings)
    down = rng.random(count) < style.shutters_down
    share = np.where(rng.random(count) < 0.35, 1.0, rng.uniform(0.12, 0.6, count))
    x0, x1, z0, z1 = openings[down].T
    low = z1 - share[down] * (z1 - z0)
    return upright(material, x0, x1, low, z1, y=style.recess - 0.05)


def _surrounds(
    openings: Floats, style: WindowStyle, material: Material, out: float
) -> list[Panels]:
    x0, x1, z0, z1 = openings.T
    width = style.surround_width
    inner, ends = ("bottom", "top"), ("left", "right")
    parts = [
        _raised(material, x0 - width, x0, z0, z1, out, ("right", *inner)),
        _raised(material, x1, x1 + width, z0, z1, out, ("left", *inner)),
        _raised(material, x0 - width, x1 + width, z1, z1 + width, out, ("bottom", *ends)),
    ]
    if style.sill is None:
        parts.append(_raised(material, x0 - width, x1 + width, z0 - width, z0, 2 * out, ends))
    if style.lintel:
        high = z1 + 2.6 * width
        left, right = x0 - 1.5 * width, x1 + 1.5 * width
        parts.append(_raised(material, left, right, high - 0.12, high, 0.18, ends))
    return parts


def _raised(
    material: Material,
    x0: Floats,
    x1: Floats,
    z0: Floats,
    z1: Floats,
    out: float,
    hidden: tuple[str, ...] = (),
) -> Panels:
    low = np.array(np.broadcast_arrays(x0, -out, z0)).T
    high = np.array(np.broadcast_arrays(x1, 0.0, z1)).T
    return boxes(material, low, high, without=("back", *hidden))
