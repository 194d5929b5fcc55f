"""The task of a stereo matching network: its own loss, and errors on other pairs."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.sample import StereoSampleBatch, sample_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples
from avsec_gym.perception.training.stereo_task import StereoTask

_VALIDATION_BATCH = 4
_WRONG, _RELATIVELY_WRONG = 3.0, 0.05
"""KITTI's stereo benchmark: wrong is what is off by more than both."""


class DisparityTask(StereoTask):
    """A `Task`.

    Args:
        estimator: The estimator, whose network is trained in place.
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    def __init__(
        self,
        estimator: PsmNetDepth,
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        super().__init__(training, validation, augmentation, data)
        self.name = estimator.name
        self.network: nn.Module = estimator.network.requires_grad_(True)
        self.trained = self.network
        self.leading_metric = "right_3px"
        self._estimator = estimator

    def losses(self, batch: StereoSampleBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return self._estimator.losses(batch.stereo, batch.disparity)

    def validate(self) -> dict[str, float]:
        """Errors over all known pixels, in the cameras' own: see `disparity_errors`."""
        device = next(self.network.parameters()).device
        totals = np.zeros(3)
        for indices in self._validation.groups(_VALIDATION_BATCH):
            batch = sample_batch([self._validation[index] for index in indices]).to(device)
            widths = torch.tensor([float(self._validation.sizes[index][1]) for index in indices])
            scale = (widths / batch.stereo.left.shape[-1]).to(device)[:, None, None]
            found = self._estimator.disparity_batch(batch.stereo)
            totals += disparity_errors(found * scale, batch.disparity * scale)
        error, wrong, pixels = (float(total) for total in totals)
        pixels = max(pixels, 1.0)
        return {"right_3px": 100 * (1 - wrong / pixels), "end_point_error": error / pixels}

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._estimator.configuration),
            "augmentation": asdict(self._augmentation),
            "data": self._data,
        }


def disparity_errors(found: Tensor, truth: Tensor) -> tuple[float, float, float]:
    """Sum of errors in pixels, wrong pixels (off by more than 3 and 5 %), and known pixels.

    Args:
        found: The disparities that were found, pixels, of any shape.
        truth: The same shape, 0 where unknown.
    """
    known = truth > 0
    true = truth[known]
    error = (found[known] - true).abs()
    wrong = (error > _WRONG) & (error > _RELATIVELY_WRONG * true)
    totals = torch.stack([error.double().sum(), wrong.double().sum(), known.double().sum()])
    one, two, three = totals.tolist()
    return one, two, three
