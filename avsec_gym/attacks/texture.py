"""Texture replacement: the side area of a road is given the road's texture (thesis, 5.5.1).

A change of the scene rather than an attack: attacked anew, it shows whether ghosts appear beside
the road because the texture there is more complex.  Stereo stays true: a point of the side area
gets the look of a point of the road, as either camera sees it, and keeps its own disparity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from itertools import product
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT, Seed
from avsec_gym.attacks.side_area import Mask, Roadside
from avsec_gym.attacks.texture_complexity import luminance
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame

_Array = NDArray[Any]

_CELL = 1.5
"""Metres across the road between the middles of two copies."""
_CELL_DEPTH = 0.2
"""The same along the road, as a share of the distance."""
_TABLE = 64
"""Cells after which draws repeat, in either direction."""
_DRAWS = 4
"""Places that a cell may copy from; the next one counts where one does not show the source."""
_FEWEST_PIXELS = 24
"""Fewest pixels of a row that must show the source..."""
_FEWEST_ROWS = 16
"""...in so many rows."""
_COARSEST = 15.0
"""Pixels a metre that a row of the source must have: 48 m away in KITTI's images."""
_BORDER = 0.3
"""Metres beside the road's edge where the road is dirty or overgrown: not copied, covered."""
_OUTLIER = 2.5
"""Robust standard deviations, and..."""
_LEAST_OUTLIER = 15.0
"""...grey levels that paint or an object's shadow differs from the rest of its row."""


class Replacement(StrEnum):
    """What is laid over what."""

    ROAD_ON_SIDE = "road_on_side"
    """The thesis' experiment."""
    GREY_ON_SIDE = "grey_on_side"
    """Control: the road's mean colour, no texture at all."""
    SIDE_ON_SIDE = "side_on_side"
    """Control: the side area's own texture, shuffled as the road's is, which shows what the
    shuffling does by itself."""
    SIDE_ON_ROAD = "side_on_road"
    """The reverse: if texture makes ghosts, they come onto the road."""


def replace_texture(
    frame: SensorFrame,
    roadside: Roadside,
    seed: Seed = 0,
    replacement: Replacement | str = Replacement.ROAD_ON_SIDE,
) -> SensorFrame:
    """The same frame of a scene whose side area (or road) has another texture, uint8.

    The new texture is made of the frame's own pixels: each place gets a mixture of places of the
    source in the same row of the image, that is at the same distance if it lies on the ground, so
    that grain, light and blur are those of the source there.  Cells of 1.5 m on the road's plane
    draw from where they copy, and fade into each other with their variance preserved (Heitz and
    Neyret, 2018), so that neither seams nor repetition show.  Rows where the source is not seen,
    such as those above the horizon, mirror the others.  Paint and shadows on the road, which are
    not its texture, are not copied.

    Args:
        frame: Frame with left and right image; others stay.
        roadside: Pixels of road and side area.  Replacements that copy the side area want one
            without buildings and plants, whose edges would come out as texture.
        seed: The same seed gives the same pixels.
        replacement: Kind of replacement: source and target area.

    Raises:
        ConfigurationError: No such replacement, or masks of another size than the images.
        DataError: Too little of the road or the source is seen, or an image is missing.
    """
    if replacement not in list(Replacement):
        raise ConfigurationError(
            f"no replacement is called {replacement!r}; there are {', '.join(Replacement)}"
        )
    size = frame.stereo(LEFT, RIGHT).left.shape[:2]
    if size != roadside.left.side.shape:
        raise ConfigurationError(f"masks of shape {roadside.left.side.shape} for images of {size}")
    from_road = replacement in (Replacement.ROAD_ON_SIDE, Replacement.GREY_ON_SIDE)
    source = _source(frame, roadside, from_road)
    grey = frame.image(LEFT)[source.usable].mean(axis=0)
    draws = np.random.default_rng(seed).random((_DRAWS, 2, _TABLE, _TABLE))
    for camera, view in ((LEFT, roadside.left), (RIGHT, roadside.right)):
        beside = _windowed(view.side, _BORDER * source.pixels_per_metre, cv2.dilate) & view.road
        covered = view.road if replacement == Replacement.SIDE_ON_ROAD else view.side | beside
        row, column = np.nonzero(covered)
        image = frame.image(camera)
        # All is laid out as the left camera sees it; the right one sees it shifted.
        parallax = source.disparity * np.float32(camera == RIGHT)
        place = column + view.disparity[row, column] * (camera == RIGHT)
        changed = image.copy()
        texture = (
            grey
            if replacement == Replacement.GREY_ON_SIDE
            else _texture(image.astype(np.float32), row, place, source, parallax, draws)
        )
        changed[row, column] = np.rint(np.clip(texture, 0, 255))
        frame = frame.with_image(camera, changed)
    return frame


@dataclass(frozen=True, eq=False)
class _Source:
    """Where the texture comes from in the left image of shape (H, W).

    Args:
        usable: Whether each pixel is seen by both cameras, and ordinary, shape (H, W).
        disparity: Disparities, pixels, shape (H, W).
        rows: The uppermost and the lowest row of the source.
        first: First column of the source in each row, shape (H,).
        last: Last column, shape (H,).
        pixels_per_metre: Scale across the road's plane, shape (H,): falls linearly to the horizon.
        middle: Column that looks straight ahead.
    """

    usable: Mask
    disparity: NDArray[np.float32]
    rows: tuple[int, int]
    first: _Array
    last: _Array
    pixels_per_metre: _Array
    middle: float


def _source(frame: SensorFrame, roadside: Roadside, from_road: bool) -> _Source:
    left, right = roadside.left, roadside.right
    mask, mask_right = (view.road if from_road else view.side for view in (left, right))
    rows, columns = np.indices(mask.shape)
    there = np.maximum(np.rint(columns - left.disparity).astype(int), 0)
    same = np.abs(right.disparity[rows, there] - left.disparity) < 1.0
    usable = mask & (left.disparity > 0) & (there > 0) & mask_right[rows, there] & same

    scale = _pixels_per_metre(frame, left.road, left.disparity)
    usable &= _ordinary(luminance(frame.image(LEFT)), usable)
    usable = _windowed(usable, 2 * _BORDER * scale, cv2.erode)
    known = np.flatnonzero((usable.sum(axis=1) >= _FEWEST_PIXELS) & (scale >= _COARSEST))
    if len(known) < _FEWEST_ROWS:
        raise DataError(
            f"Frame {frame.id}: only {len(known)} rows of the image show the "
            f"{'road' if from_road else 'side area'} in both views.",
            path=frame.origin,
            remedy="Its texture cannot be taken from here; leave the frame out.",
        )
    middle = float(frame.calibration.projection(LEFT)[0, 2])
    # In metres the edges of a straight road are the same in all rows, so that smoothing is safe.
    edges = [np.quantile(np.flatnonzero(usable[row]), (0.03, 0.97)) for row in known]
    metres = (np.array(edges) - middle) / scale[known, None]
    every, width = np.arange(len(mask)), mask.shape[1]
    first, last = (
        middle + scale * _smooth(np.interp(every, known, metres[:, end]), 15) for end in (0, 1)
    )
    first = np.clip(np.ceil(first), 0, width - 2)
    last = np.clip(np.floor(last), first + 1, width - 1)
    extent = int(known[0]), int(known[-1])
    return _Source(usable, left.disparity, extent, first, last, scale, middle)


def _texture(
    image: NDArray[np.float32],
    row: _Array,
    place: _Array,
    source: _Source,
    parallax: NDArray[np.float32],
    draws: _Array,
) -> _Array:
    """The source's texture for N pixels, shape (N, 3).

    Args:
        image: Image of either camera.
        row: Row of each pixel, shape (N,).
        place: Column at which the left camera sees what each pixel shows, shape (N,).
        source: Area from which the texture is copied.
        parallax: Columns by which this camera sees the left image's pixels further left, (H, W).
        draws: Numbers in [0, 1): the place along a row from which each cell copies.
    """
    top, bottom = source.rows
    mirrored = (row - top) // (bottom - top) % 2
    row = _mirrored(row, top, bottom)
    scale, first, last = (
        each[row] for each in (source.pixels_per_metre, source.first, source.last)
    )
    across = (place - source.middle) / (_CELL * scale)
    along = np.log(scale) / _CELL_DEPTH
    mean, light = (each[row] for each in _row_means(image, source, parallax))
    total, power = np.zeros((len(row), 3)), np.zeros(len(row))
    for next_across, next_along in product((0, 1), (0, 1)):
        cell, step = np.floor(across) + next_across, np.floor(along) + next_along
        weight = (1 - np.abs(across - cell)) * (1 - np.abs(along - step))
        anchor = source.middle + cell * _CELL * scale
        of_cell = mirrored, cell.astype(int) % _TABLE, step.astype(int) % _TABLE
        copied, usable = place, np.zeros(len(row), bool)
        for draw in draws:
            start = first + draw[of_cell] * (last - first)
            other = _mirrored(place - anchor + start, first, last)
            copied = np.where(usable, copied, other)
            usable |= source.usable[row, np.rint(other).astype(int)]
        weight *= usable
        colour = _sampled(image, copied - _sampled(parallax, copied, row), row)
        total += weight[:, None] * (colour - mean)
        power += weight**2
    return np.asarray(light + total / np.sqrt(np.maximum(power, 1e-9))[:, None])


def _pixels_per_metre(frame: SensorFrame, road: Mask, disparity: NDArray[np.float32]) -> _Array:
    """Across the road's plane in each row, shape (H,); only sizes follow from it."""
    rows, columns = np.nonzero(road & (disparity > 0))
    if len(np.unique(rows)) < _FEWEST_ROWS:
        raise DataError(
            f"Frame {frame.id}: hardly any road is seen.",
            path=frame.origin,
            remedy="Sizes on the ground cannot be measured here; leave the frame out.",
        )
    slope, offset = np.polyfit(rows, disparity[rows, columns].astype(float), 1)
    plane = slope * np.arange(len(road)) + offset
    return np.maximum(plane / frame.calibration.baseline(LEFT, RIGHT), 1.0)


def _ordinary(bright: _Array, mask: Mask) -> Mask:
    """Where a row of the source looks as most of it does: no paint, no shadow of an object."""
    smooth = np.where(mask, cv2.blur(bright, (5, 3)), np.nan)
    result = np.zeros(mask.shape, bool)
    for row in np.flatnonzero(mask.any(axis=1)):
        away = np.abs(smooth[row] - np.nanmedian(smooth[row]))
        limit = max(_OUTLIER * 1.4826 * float(np.nanmedian(away)), _LEAST_OUTLIER)
        result[row] = away < limit
    return result


def _windowed(mask: Mask, widths: _Array, operation: Callable[..., _Array]) -> Mask:
    """A mask of which each row is eroded or dilated by half a width of its own."""
    windows = [np.ones((1, int(width) // 2 * 2 + 1), np.uint8) for width in widths]
    rows = mask.astype(np.uint8)[:, None]
    return np.array(
        [operation(row, window)[0] > 0 for row, window in zip(rows, windows, strict=True)]
    )


def _row_means(
    image: NDArray[np.float32], source: _Source, parallax: NDArray[np.float32]
) -> tuple[_Array, _Array]:
    """Mean colour of the source in each row, and how it goes on without edges, (H, 3) each."""
    rows, columns = np.nonzero(source.usable)
    colours = _sampled(image, columns - parallax[rows, columns], rows)
    every = np.arange(len(image))
    count = np.bincount(rows, minlength=len(image))
    known = np.flatnonzero(count >= _FEWEST_PIXELS)
    sums = [np.bincount(rows, channel, minlength=len(image))[known] for channel in colours.T]
    means = [np.interp(every, known, each / count[known]) for each in sums]
    narrow, wide = (np.stack([_smooth(each, size) for each in means], -1) for size in (5, 31))
    return narrow, wide


def _smooth(values: _Array, size: int) -> _Array:
    """A running mean over an odd number of rows."""
    padded = np.pad(values, size // 2, mode="edge")
    return np.convolve(padded, np.full(size, 1 / size), mode="valid")


def _mirrored(values: _Array, first: _Array | int, last: _Array | int) -> _Array:
    """Values brought between first and last by reflection at both."""
    length = np.asarray(last) - first
    offset = (values - first) % (2 * length)
    return np.asarray(first + np.minimum(offset, 2 * length - offset))


def _sampled(image: NDArray[np.float32], u: _Array, v: _Array) -> NDArray[np.float32]:
    """An image (H, W) or (H, W, 3) between its pixels, bicubic, at N places."""
    # OpenCV takes no more than 32767 places in a row.
    width = 1024
    padding = -len(u) % width
    u, v = (np.pad(each.astype(np.float32), (0, padding)).reshape(-1, width) for each in (u, v))
    result = cv2.remap(image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    flat = result.reshape(-1, *image.shape[2:])
    return np.asarray(flat[: len(flat) - padding], np.float32)
