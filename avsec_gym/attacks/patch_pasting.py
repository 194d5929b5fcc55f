"""Pasting a round patch into both views, as a poster that really stands there would be seen.

The left view shows a disc; the right one what the calibration makes of it, with parts of pixels
(bilinear): the same disc, shifted by its disparity, where the cameras differ by a shift along x
alone.  Differentiable down to the patch's pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.attacks.attack import with_pair
from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.attacks.patch_views import PatchView, left_view, right_view
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames

_RIM = 1.0
"""Pixels of a disc's edge that the right image may cut off: places are drawn as if the cameras
differed by a shift along x alone, and KITTI's own differ by less than this from that."""


def paste(
    batch: StereoBatch, patch: Tensor, places: Sequence[PatchPlace], *, may_stick_out: bool = False
) -> StereoBatch:
    """(I_l, I_r) -> A(I_l, I_r, patch, loc_l, loc_r, rotation), thesis, section 5.2.

    Args:
        batch: Images of B pairs; nothing is changed outside of the discs.
        patch: Grey levels on the square around the disc, shape (3, S, S).
        places: Place for each pair, in pixels of the batch.
        may_stick_out: Whether a part may lie outside of an image.

    Raises:
        ConfigurationError: Not one place for each pair, or a patch sticks out unasked.
    """
    height, width = batch.left.shape[-2:]
    if len(places) != len(batch):
        raise ConfigurationError(f"{len(batch)} pairs take as many patches, got {len(places)}")
    seen_right = _seen_right(batch, places)
    for place, view in zip(places, seen_right, strict=True):
        is_inside = place.is_inside(height, width) and view.is_inside(height, width, _RIM)
        if not may_stick_out and not is_inside:
            raise ConfigurationError(
                f"the patch does not fit into both images of {width} x {height} pixels: {place}"
            )
    textures = [_fitted(patch, place) for place in places]
    left, right = (
        torch.stack(
            [
                _pasted(image, texture, place, view)
                for image, texture, place, view in zip(images, textures, places, views, strict=True)
            ]
        )
        for images, views in (
            (batch.left, [left_view(place) for place in places]),
            (batch.right, seen_right),
        )
    )
    return replace(batch, left=left, right=right)


def paste_on_frame(
    frame: SensorFrame, patch: Tensor, place: PatchPlace, *, may_stick_out: bool = False
) -> SensorFrame:
    """The frame with a patch in cameras 2 and 3; see `paste`."""
    batch = paste(batch_of_frames([frame]), patch, [place], may_stick_out=may_stick_out)
    return with_pair(frame, batch.left[0], batch.right[0])


def disc(distance: Tensor, radius: float) -> Tensor:
    """How much of a pixel is the patch: 0 at the radius and beyond, 1 one pixel further in."""
    return (radius - distance).clamp(0, 1)


def largest_area(radius: float) -> int:
    """Pixels that a disc can touch at most, wherever its centre is between them.

    The unit squares around those pixels lie in a disc that is wider by half a pixel's diagonal.
    """
    return int(np.pi * (radius + np.sqrt(0.5)) ** 2)


def _fitted(patch: Tensor, place: PatchPlace) -> Tensor:
    """Fewer, averaged texels where there are more than pixels: pasted small, none is skipped."""
    pixels = int(np.ceil(2 * place.radius))
    if pixels >= patch.shape[-1]:
        return patch[None]
    return functional.interpolate(
        patch[None], size=(pixels, pixels), mode="bilinear", antialias=True
    )


def _seen_right(batch: StereoBatch, places: Sequence[PatchPlace]) -> list[PatchView]:
    projections = (batch.left_projection, batch.right_projection)
    left, right = (each.detach().cpu().double().numpy() for each in projections)
    return [right_view(place, left[i], right[i]) for i, place in enumerate(places)]


def _pasted(image: Tensor, texture: Tensor, place: PatchPlace, view: PatchView) -> Tensor:
    """An image (3, H, W) with a texture (1, 3, S, S) where a camera sees it."""
    height, width = image.shape[-2:]
    (u, v), (across, down) = view.centre.tolist(), view.reach.tolist()
    rows, columns = _touched(v, down, height), _touched(u, across, width)
    if not len(rows) or not len(columns):
        return image
    y, x = torch.meshgrid(rows - v, columns - u, indexing="ij")
    # Where the left image shows it, and there, where on the patch it is.
    ((xx, xy), (yx, yy)) = view.to_left.tolist()
    x, y = xx * x + xy * y, yx * x + yy * y
    cos, sin = np.cos(place.rotation), np.sin(place.rotation)
    on_patch = torch.stack([cos * x + sin * y, cos * y - sin * x], dim=-1) / place.radius
    seen = functional.grid_sample(
        texture, on_patch[None].to(texture), padding_mode="border", align_corners=False
    )[0].to(image)
    opacity = disc(torch.hypot(x, y), place.radius).to(image)
    top, left = int(rows[0]), int(columns[0])
    window = (..., slice(top, top + len(rows)), slice(left, left + len(columns)))
    result = image.clone()
    result[window] = opacity * seen + (1 - opacity) * image[window]
    return result


def _touched(centre: float, radius: float, side: int) -> Tensor:
    """Numbers of the pixels of a row or column that a disc reaches, float64."""
    first = max(0, int(np.ceil(centre - radius)))
    last = min(side - 1, int(np.floor(centre + radius)))
    return torch.arange(first, max(first, last + 1), dtype=torch.float64)
