"""`StereoBatch`: pairs of images as the networks take them, differentiable down to the pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.frame import Calibration, SensorFrame


@dataclass(frozen=True, eq=False)
class StereoBatch:
    """B rectified pairs of one size.

    Args:
        left: Red, green, blue in grey levels 0..255 (not normalised), float, shape (B, 3, H, W).
        right: The same shape.
        left_projection: P of the left camera for these pixels, float64, shape (B, 3, 4).
        right_projection: P of the right camera, shape (B, 3, 4).
        size: Height and width of the camera's own image, pixels, before any scaling.
    """

    left: Tensor
    right: Tensor
    left_projection: Tensor
    right_projection: Tensor
    size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.left)

    @property
    def focal_length(self) -> Tensor:
        """Horizontal focal length in pixels of these images, shape (B,)."""
        return self.left_projection[:, 0, 0]

    @property
    def baseline(self) -> Tensor:
        """Metres, shape (B,): disparity = focal length x baseline / depth."""
        difference = self.left_projection[:, 0, 3] - self.right_projection[:, 0, 3]
        return difference / self.focal_length

    def resized(self, height: int, width: int) -> StereoBatch:
        """Bilinear (with anti-aliasing where it shrinks), the projections scaled with it.

        A pixel's centre is a whole number in KITTI's P, so the centre moves by half a pixel:
        ``u' = (u + 1/2) * s - 1/2``.
        """
        if self.left.shape[-2:] == (height, width):
            return self
        scale_v, scale_u = height / self.left.shape[-2], width / self.left.shape[-1]
        change = torch.tensor(
            [
                [scale_u, 0.0, (scale_u - 1) / 2],
                [0.0, scale_v, (scale_v - 1) / 2],
                [0.0, 0.0, 1.0],
            ],
            dtype=self.left_projection.dtype,
            device=self.left_projection.device,
        )
        return replace(
            self,
            left=_resized(self.left, height, width),
            right=_resized(self.right, height, width),
            left_projection=change @ self.left_projection,
            right_projection=change @ self.right_projection,
        )

    def to(self, device: torch.device | str) -> StereoBatch:
        """The batch on another device."""
        return replace(
            self,
            left=self.left.to(device),
            right=self.right.to(device),
            left_projection=self.left_projection.to(device),
            right_projection=self.right_projection.to(device),
        )


def batch_of_frames(frames: Sequence[SensorFrame], left: int = 2, right: int = 3) -> StereoBatch:
    """Frames of one image size as a batch.

    Raises:
        DataError: An image is missing or broken, or a pair's two sizes differ.
        ConfigurationError: A camera is not calibrated.
    """
    pairs = [frame.stereo(left, right) for frame in frames]
    calibrations = [frame.calibration for frame in frames]
    return batch_of_images(
        torch.stack([_tensor(pair.left) for pair in pairs]),
        torch.stack([_tensor(pair.right) for pair in pairs]),
        calibrations,
        left,
        right,
    )


def batch_of_images(
    left_images: Tensor,
    right_images: Tensor,
    calibrations: Sequence[Calibration],
    left: int = 2,
    right: int = 3,
) -> StereoBatch:
    """Images (B, 3, H, W) that may carry a gradient, as a batch; see `StereoBatch`."""

    def projection(camera: int) -> Tensor:
        matrices = np.stack([calibration.projection(camera) for calibration in calibrations])
        return torch.from_numpy(matrices).to(left_images.device)

    height, width = left_images.shape[-2:]
    return StereoBatch(
        left_images, right_images, projection(left), projection(right), (height, width)
    )


def _tensor(image: np.ndarray) -> Tensor:
    return torch.from_numpy(image).permute(2, 0, 1).float()


def _resized(images: Tensor, height: int, width: int) -> Tensor:
    return functional.interpolate(
        images, size=(height, width), mode="bilinear", align_corners=False, antialias=True
    )
