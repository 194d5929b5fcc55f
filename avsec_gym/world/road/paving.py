"""Shades by which laid stones differ from place to place, so that no repetition is seen."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.world.road.canvas import Mask, RoadCanvas, offset
from avsec_gym.world.road.junction import Mouth
from avsec_gym.world.road.materials import ground_materials, strip_material
from avsec_gym.world.road.surface import PAINTED
from avsec_gym.world.site import Site
from avsec_gym.world.textures.paving import LAYINGS

_DIRTIEST = {"slabs": 0.34, "setts": 0.6, "clinker": 0.5}
"""How opaque the dirt on the darkest stones is."""
_DIRT = (70.0, 66.0, 60.0)
_TABLE = 512


def paint_paving(
    canvas: RoadCanvas, site: Site, openings: Sequence[Mouth], rng: np.random.Generator
) -> None:
    """A shade for each stone of the main road's slabs, setts and clinkers."""
    materials = ground_materials(site)
    for strip in site.section.strips:
        texture = strip_material(materials, strip).texture
        if strip.surface not in PAINTED or texture not in LAYINGS:
            continue
        rows = canvas.pixels(0.0, [strip.left, strip.right])[:, 1].astype(int)
        first, last = np.clip(rows, 0, canvas.picture.shape[0]).tolist()
        corner = (canvas.start, strip.left - canvas.top + first / canvas.scale)
        size = (last - first, canvas.picture.shape[1])
        mask = _shades(LAYINGS[texture], corner, size, 1.0 / canvas.scale, _table(), offset(rng))
        for mouth in openings:
            begin, right, end, left = mouth.paved.bounds
            if right < strip.left and left > strip.right:
                columns = canvas.pixels([begin, end], 0.0)[:, 0].astype(int)
                mask[:, max(columns[0], 0) : max(columns[1], 0)] = 0
        canvas.lay(mask, 0, first, _DIRT, _DIRTIEST[texture.partition("/")[0]])


@kernel()
def _shades(laying, corner, size, step, table, shift):  # type: ignore[no-untyped-def]
    """How dark the stone is that each pixel belongs to.

    Invariant: the shade depends on the stone's row and column alone, so that its pixels agree.

    Args:
        laying: `avsec_gym.world.textures.paving.Laying`.
        corner: Position along and across the stones of the picture's upper left corner, metres.
        size: Height and width of the picture.
        step: Size of a pixel, metres.
        table: Random numbers, shape (n, n).
        shift: Entry of the table to begin with.
    """
    mask = np.empty(size, np.uint8)
    for i in range(size[0]):
        y = (corner[1] + (i + 0.5) * step) / laying.width
        for j in range(size[1]):
            x = (corner[0] + (j + 0.5) * step) / laying.length
            if laying.diagonal:
                row, column = np.floor(x - y), np.floor(x + y)
            else:
                row = np.floor(y)
                column = np.floor(x - (row % 2.0) * laying.stagger)
            mask[i, j] = table[
                (int(row) + shift[0]) % len(table), (int(column) + shift[1]) % len(table)
            ]
    return mask


@functools.cache
def _table() -> Mask:
    """A random number for each stone; many are clean, few are dark."""
    rng = np.random.default_rng(75)
    shades: NDArray[np.float32] = rng.random((_TABLE, _TABLE), np.float32) ** 1.3
    return np.asarray(255.0 * shades).astype(np.uint8)
