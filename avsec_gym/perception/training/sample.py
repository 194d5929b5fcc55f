"""`StereoSample`: a pair of images reduced to a network's size, with all that is true of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.perception.stereo_batch import StereoBatch

Pixels = NDArray[np.uint8] | NDArray[np.float32]
"""Shape (H, W, 3), red, green, blue in grey levels."""
Map = NDArray[np.float32]
"""Shape (H, W): disparities in pixels of this size, 0 where unknown."""


@dataclass(frozen=True, eq=False)
class StereoSample:
    """A pair as cameras of just this size would have taken it.

    Args:
        left: The left image, shape (H, W, 3).
        right: The same shape.
        left_projection: P of the left camera for these pixels, shape (3, 4).
        right_projection: P of the right camera.
        left_disparity: The disparities of the left image, shape (H, W), 0 where unknown.
        right_disparity: The disparities of the right image.
        truth: The objects; 2D boxes are in these pixels.
    """

    left: Pixels
    right: Pixels
    left_projection: Floats
    right_projection: Floats
    left_disparity: Map
    right_disparity: Map
    truth: Boxes3D

    @property
    def size(self) -> tuple[int, int]:
        """Height and width."""
        return self.left.shape[0], self.left.shape[1]


@dataclass(frozen=True, eq=False)
class StereoSampleBatch:
    """What the losses of a stereo network take.

    Args:
        stereo: B pairs; `size` is that of their own pixels.
        truth: The objects of each.
        disparity: The disparities of the left images, shape (B, H, W), 0 where unknown.
    """

    stereo: StereoBatch
    truth: tuple[Boxes3D, ...]
    disparity: Tensor

    def to(self, device: torch.device | str) -> StereoSampleBatch:
        """On another device."""
        return StereoSampleBatch(self.stereo.to(device), self.truth, self.disparity.to(device))


def sample_batch(samples: Sequence[StereoSample]) -> StereoSampleBatch:
    """Samples of one size as a batch."""

    def images(of: Sequence[Pixels]) -> Tensor:
        return torch.from_numpy(np.stack(of)).permute(0, 3, 1, 2).float().contiguous()

    stereo = StereoBatch(
        images([sample.left for sample in samples]),
        images([sample.right for sample in samples]),
        torch.from_numpy(np.stack([sample.left_projection for sample in samples])),
        torch.from_numpy(np.stack([sample.right_projection for sample in samples])),
        samples[0].size,
    )
    disparity = torch.from_numpy(np.stack([sample.left_disparity for sample in samples]))
    return StereoSampleBatch(stereo, tuple(sample.truth for sample in samples), disparity)
