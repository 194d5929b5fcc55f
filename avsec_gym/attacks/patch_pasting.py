"""Pasting a round patch into both views, as a poster that really stands there would be seen.

Both views show the same disc, shifted by a disparity with parts of pixels (bilinear); a poster that
faces a rectified pair looks the same to both cameras.  Differentiable down to the patch's pixels.
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
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames


def paste(
    batch: StereoBatch, patch: Tensor, places: Sequence[PatchPlace], *, may_stick_out: bool = False
) -> StereoBatch:
    """(I_l, I_r) -> A(I_l, I_r, patch, loc_l, loc_r, rotation), thesis, section 5.2.

    Args:
        batch: B pairs; nothing is changed outside of the discs.
        patch: Grey levels on the square around the disc, shape (3, S, S).
        places: One for each pair, in pixels of the batch.
        may_stick_out: Whether a part may lie outside of an image.

    Raises:
        ConfigurationError: Not one place for each pair, or a patch sticks out unasked.
    """
    height, width = batch.left.shape[-2:]
    if len(places) != len(batch):
        raise ConfigurationError(f"{len(batch)} pairs take as many patches, got {len(places)}")
    for place in places:
        if not may_stick_out and not place.is_inside(height, width):
            raise ConfigurationError(
                f"the patch does not fit into both images of {width} x {height} pixels: {place}"
            )
    textures = [_fitted(patch, place) for place in places]
    views = [
        torch.stack(
            [
                _pasted(image, texture, place, place.u - shift * place.disparity)
                for image, texture, place in zip(images, textures, places, strict=True)
            ]
        )
        for shift, images in enumerate((batch.left, batch.right))
    ]
    return replace(batch, left=views[0], right=views[1])


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


def _pasted(image: Tensor, texture: Tensor, place: PatchPlace, u: float) -> Tensor:
    """An image (3, H, W) with a texture (1, 3, S, S) around column u."""
    height, width = image.shape[-2:]
    rows, columns = _touched(place.v, place.radius, height), _touched(u, place.radius, width)
    if not len(rows) or not len(columns):
        return image
    y, x = torch.meshgrid(rows - place.v, columns - u, indexing="ij")
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
