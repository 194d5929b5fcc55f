"""Stereo detectors for the Adversarial Robustness Toolbox (ART).

ART knows one image as the input and classes as the output.  Here one image is a stereo pair, six
channels deep (left red, green, blue, then right), and a target is the boxes that are really there.
Every ART attack that climbs a loss gradient can run: `FastGradientMethod`, `BasicIterativeMethod`,
`MomentumIterativeMethod`, `ProjectedGradientDescent`, in any norm; and `SquareAttack`, which only
asks for the loss (its `p_init` must be less than H / W).  `ToolboxAttack` is any of them as one of
ours.  Attacks that ask for a classifier, such
as `AutoProjectedGradientDescent`, cannot; ART's patches would lie at one place in both views.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT, with_pair
from avsec_gym.attacks.loss_gradient import differentiable, loss_gradient, total_loss
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_images
from avsec_gym.storage.folder_lock import folder_lock

_HOME = Path(os.path.expanduser("~"))
try:
    # At its first import ART writes its settings into the home folder, not all at once: another
    # process that imports it meanwhile would read half of them, and fail.
    with folder_lock(_HOME, wait=True, what="ART") if _HOME.is_dir() else nullcontext():
        from art.estimators import BaseEstimator, LossGradientsMixin, NeuralNetworkMixin
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "ART's attacks need the adversarial-robustness-toolbox: "
        "pip install 'avsec-gym[adversarial]'",
        name="art",
    ) from error

PackedPairs = NDArray[np.float32]
"""N stereo pairs, grey levels 0..255, shape (N, 6, H, W)."""


class StereoDetectorEstimator(LossGradientsMixin, NeuralNetworkMixin, BaseEstimator):  # type: ignore[misc]
    """A stereo detector as ART attacks it.

    Args:
        detector: The victim's detector O, one that has `losses`.
        frame: Any frame that shows the rig: its calibration and size are those of all pairs.
        disparity: Disparity of the left image, pixels, 0 where unknown, shape (H, W), where all
            pairs show one frame; DSGN's training loss has a term for it.

    Raises:
        ConfigurationError: The detector has no loss to climb.
        DataError: An image is missing or broken.
    """

    estimator_params = (*BaseEstimator.estimator_params, *NeuralNetworkMixin.estimator_params)

    def __init__(
        self,
        detector: Detector,
        frame: SensorFrame,
        disparity: NDArray[np.float32] | None = None,
    ) -> None:
        super().__init__(
            model=differentiable(detector),
            clip_values=(0.0, 255.0),
            channels_first=True,
            preprocessing=None,
        )
        self.calibration = frame.calibration
        self.size = frame.stereo(LEFT, RIGHT).left.shape[:2]
        self.disparity = None if disparity is None else torch.from_numpy(disparity)[None]

    @property
    def input_shape(self) -> tuple[int, ...]:
        """6, H, W."""
        return (6, *self.size)

    def predict(self, x: PackedPairs, batch_size: int = 1, **_: Any) -> NDArray[np.object_]:
        """What the detector finds in each pair; targets, where an attack is given none."""
        return targets([self.model.detect_batch(self._batch(pair))[0] for pair in x])

    def compute_loss(self, x: PackedPairs, y: Sequence[Boxes3D], **_: Any) -> NDArray[np.float64]:
        """L of each pair, shape (N,)."""
        with torch.no_grad():
            return np.array(
                [
                    float(total_loss(self.model, self._batch(pair), [truth], self.disparity))
                    for pair, truth in zip(x, y, strict=True)
                ]
            )

    def loss_gradient(self, x: PackedPairs, y: Sequence[Boxes3D], **_: Any) -> PackedPairs:
        """The gradient of L at the pixels, each pair for itself, shape (N, 6, H, W)."""
        return np.stack(
            [
                loss_gradient(self.model, self._batch(pair), [truth], self.disparity)
                .reshape(self.input_shape)
                .numpy()
                for pair, truth in zip(x, y, strict=True)
            ]
        )

    def fit(
        self, x: PackedPairs, y: Any, batch_size: int = 1, nb_epochs: int = 1, **_: Any
    ) -> None:
        """Not offered: detectors are trained by ``avsec train``."""
        raise ConfigurationError("ART does not train stereo detectors; `avsec train` does")

    def get_activations(
        self, x: PackedPairs, layer: int | str, batch_size: int = 1, framework: bool = False
    ) -> NDArray[np.float32]:
        """Not offered."""
        raise ConfigurationError("the layers of stereo detectors are not open to ART")

    def _batch(self, pair: NDArray[np.float32]) -> StereoBatch:
        if pair.shape != self.input_shape:
            raise ConfigurationError(
                f"a packed pair of this rig has shape {self.input_shape}, got {pair.shape}"
            )
        left, right = torch.from_numpy(pair.astype(np.float32)).reshape(2, 1, 3, *self.size)
        return batch_of_images(left, right, [self.calibration], LEFT, RIGHT)


def packed(frames: Sequence[SensorFrame]) -> PackedPairs:
    """Frames of one rig as ART takes them.

    Raises:
        DataError: An image is missing or broken.
    """
    pairs = [frame.stereo(LEFT, RIGHT) for frame in frames]
    images = np.stack([np.concatenate([pair.left, pair.right], axis=2) for pair in pairs])
    return np.ascontiguousarray(images.transpose(0, 3, 1, 2), dtype=np.float32)


def unpacked(pair: NDArray[np.float32], frame: SensorFrame) -> SensorFrame:
    """The frame with the views of a packed pair, shape (6, H, W)."""
    left, right = torch.from_numpy(pair).chunk(2)
    return with_pair(frame, left, right)


def targets(truths: Sequence[Boxes3D]) -> NDArray[np.object_]:
    """Boxes of N pairs in ART's form, shape (N,); NumPy would treat boxes as sequences."""
    result = np.empty(len(truths), object)
    for i, boxes in enumerate(truths):
        result[i] = boxes
    return result
