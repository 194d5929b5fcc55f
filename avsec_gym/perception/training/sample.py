"""`StereoSample`: a pair of images reduced to a network's size, with all that is true of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.perception.stereo_batch import StereoBatch

Pixels = NDArray[np.uint8]
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
        targets: What a detector makes of the objects alone, if that is prepared, too.
    """

    stereo: StereoBatch
    truth: tuple[Boxes3D, ...]
    disparity: Tensor
    targets: Any = None

    def to(self, device: torch.device | str) -> StereoSampleBatch:
        """The batch on another device."""
        return replace(self, stereo=self.stereo.to(device), disparity=self.disparity.to(device))


@dataclass(frozen=True, eq=False)
class PackedBatch:
    """A batch on its way between processes: arrays, images in whole grey levels.

    Args:
        left: The left images, uint8, shape (B, H, W, 3).
        right: The right images.
        left_projections: P of the left cameras, shape (B, 3, 4).
        right_projections: P of the right cameras.
        disparities: The disparities, see `StereoSampleBatch`.
        truth: The objects of each.
        targets: The targets, see `StereoSampleBatch`.
    """

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    left_projections: Floats
    right_projections: Floats
    disparities: Map
    truth: tuple[Boxes3D, ...]
    targets: Any = None

    def to(self, device: torch.device | str) -> StereoSampleBatch:
        """Unpacked on a device."""

        def images(arrays: NDArray[np.uint8]) -> Tensor:
            return torch.from_numpy(arrays).to(device).permute(0, 3, 1, 2).float().contiguous()

        height, width = self.left.shape[1:3]
        stereo = StereoBatch(
            images(self.left),
            images(self.right),
            torch.from_numpy(self.left_projections).to(device),
            torch.from_numpy(self.right_projections).to(device),
            (height, width),
        )
        disparity = torch.from_numpy(self.disparities).to(device)
        return StereoSampleBatch(stereo, self.truth, disparity, self.targets)


def packed_batch(samples: Sequence[StereoSample], targets: Any = None) -> PackedBatch:
    """Samples of one size, whose grey levels are whole."""
    return PackedBatch(
        np.stack([sample.left for sample in samples]).astype(np.uint8, copy=False),
        np.stack([sample.right for sample in samples]).astype(np.uint8, copy=False),
        np.stack([sample.left_projection for sample in samples]),
        np.stack([sample.right_projection for sample in samples]),
        np.stack([sample.left_disparity for sample in samples]),
        tuple(sample.truth for sample in samples),
        targets,
    )


def sample_batch(samples: Sequence[StereoSample]) -> StereoSampleBatch:
    """Samples of one size as a batch."""
    return packed_batch(samples).to("cpu")
