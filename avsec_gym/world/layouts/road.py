"""The road of a layout and the rows of objects along it.

Everything is placed in road coordinates: `along` the road from the ego vehicle, `left` of the
line it drives on, and a heading relative to the road.  `LayoutRoad` bends these into the ego frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.layouts.dimensions import CategoryMix, Codes, draw_dimensions


@dataclass(frozen=True)
class LayoutRoad:
    """A road of constant curvature as the ego vehicle at the origin sees it."""

    heading: float
    """Direction of the road at the ego vehicle, radians, counter-clockwise from x."""
    curvature: float
    """Per metre; positive bends to the left."""
    lane_offsets: tuple[float, ...]
    """How far left of the ego vehicle the centres of the lanes lie, metres."""
    lane_width: float = 3.5
    """Metres."""

    def poses(self, along: Floats, left: Floats, heading: Floats) -> Floats:
        """From road coordinates, each of shape (N,), to ego-frame poses, shape (N, 3)."""
        half_turn = 0.5 * self.curvature * along
        chord = along * np.sinc(half_turn / np.pi)
        direction = self.heading + 2.0 * half_turn
        towards = self.heading + half_turn
        x = chord * np.cos(towards) - left * np.sin(direction)
        y = chord * np.sin(towards) + left * np.cos(direction)
        return np.stack([x, y, direction + heading], axis=-1)


class Placed(NamedTuple):
    """Objects in road coordinates, N of them."""

    along: Floats
    left: Floats
    heading: Floats
    codes: Codes
    dimensions: Floats
    moving: NDArray[np.bool_]

    def pick(self, which: slice | NDArray[np.bool_]) -> Placed:
        """Some of the objects."""
        return Placed(*[column[which] for column in self])  # type: ignore[arg-type]


def join(parts: Sequence[Placed]) -> Placed:
    """All objects of some groups in their order."""
    return Placed(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def place_row(
    rng: np.random.Generator,
    mix: CategoryMix,
    *,
    start: float,
    end: float,
    left: float,
    gap: float,
    fullness: float,
    lull: float,
    backwards: float = 0.0,
    angle: float = 0.0,
    jitter: float = 0.15,
    moving: bool = False,
) -> Placed:
    """Objects along the road: one behind the other or, in parking bays, side by side.

    Args:
        rng: The source of chance.
        mix: Categories of the objects in the row.
        start: Least road coordinate of the rear of the first object, metres.
        end: No object's centre lies beyond.
        left: Distance of the row's line from the ego vehicle's line, metres, positive to the left.
        gap: Smallest free space between neighbours, metres; as much again is added on average.
        fullness: Probability that a neighbour follows at once; otherwise a lull comes between.
        lull: Mean length of a lull, metres.
        backwards: Share that faces against the ego vehicle's direction.
        angle: Angle of a parking bay to the road, radians; then the objects stand side by side.
        jitter: Standard deviation of the distance from the row's line, metres.
        moving: The flag of all of them.

    Returns:
        The objects in order; possibly none.
    """
    count = 2 + int(max(end - start, 0.0) / (5.0 if angle == 0.0 else 2.5))
    codes = mix.draw(rng, count)
    dimensions = draw_dimensions(rng, codes)
    extent = dimensions[:, 2] if angle == 0.0 else dimensions[:, 1] / abs(np.sin(angle))
    spaces = gap * (1.0 + rng.standard_exponential(count))
    spaces += lull * rng.standard_exponential(count) * (rng.random(count) > fullness)
    along = start + np.cumsum(spaces + extent) - 0.5 * extent
    heading = np.where(rng.random(count) < backwards, np.pi, 0.0) + angle
    scatter = rng.standard_normal((2, count))
    row = Placed(
        along,
        left + jitter * scatter[0],
        heading + (0.030 if angle == 0.0 else 0.06) * scatter[1],
        codes,
        dimensions,
        np.full(count, moving),
    )
    return row.pick(slice(int(along.searchsorted(end))))


def place_freely(
    rng: np.random.Generator,
    mix: CategoryMix,
    along: Floats,
    left: Floats,
    heading: Floats,
    moving: NDArray[np.bool_],
) -> Placed:
    """Objects at given places, shape (N,) each, with drawn categories and sizes."""
    codes = mix.draw(rng, len(along))
    return Placed(along, left, heading, codes, draw_dimensions(rng, codes), moving)
