"""The task of a stereo detector: its own losses, and average precision on other frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.precision import precision
from avsec_gym.perception.training.sample import StereoSampleBatch, sample_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples
from avsec_gym.perception.training.stereo_task import StereoTask

_VALIDATION_BATCH = 4
_MEASURES = (
    "3d_ap11", "3d_ap40", "3d_ap11_easy", "3d_ap11_hard", "bev_ap11", "2d_ap11", "3d_ap11_iou50",
)  # fmt: skip


class TrainableDetector(Protocol):
    """What of a detector is needed here; see `DifferentiableDetector`."""

    name: str

    @property
    def network(self) -> nn.Module:
        """What is trained."""
        ...

    @property
    def configuration(self) -> Any:
        """A dataclass with an `input_size`."""
        ...

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame."""
        ...

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        """The terms of the loss."""
        ...


class DetectionTask(StereoTask):
    """A `Task`.

    Args:
        detector: The detector, whose network is trained in place.
        categories: The categories whose precision is measured; that of the first leads.
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    def __init__(
        self,
        detector: TrainableDetector,
        categories: Sequence[str],
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        super().__init__(training, validation, augmentation, data)
        self.name = detector.name
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        weights = getattr(detector, "term_weights", None)
        if isinstance(weights, nn.Module):
            parts = {"network": self.network, "term_weights": weights.requires_grad_(True)}
            self.trained = nn.ModuleDict(parts)
        self.leading_metric = f"{categories[0]}_3d_ap40"
        self._detector = detector
        self._categories = tuple(categories)

    def continue_with(self, beside: Mapping[str, Sequence[float]]) -> None:
        """Begin with what an earlier training learned beside the network, such as term weights.

        Args:
            beside: The figures by name, as a `ModelCard` keeps them; what this task does not learn
                is ignored.
        """
        for name, value in self.trained.state_dict().items():
            if not name.startswith("network.") and len(beside.get(name, ())) == value.numel():
                value.copy_(torch.tensor(beside[name]).reshape(value.shape))

    def losses(self, batch: StereoSampleBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return self._detector.losses(batch.stereo, batch.truth, batch.disparity)

    def validate(self) -> dict[str, float]:
        """Average precision (percent, moderate, unless named otherwise), and the loss.

        ``..._iou50`` stands for the easier thresholds `LOW_IOU`, 0.5 for cars.
        """
        found: list[Boxes3D] = []
        losses = 0.0
        for indices in self._validation.groups(_VALIDATION_BATCH):
            batch = sample_batch([self._validation[index] for index in indices])
            losses += self._total_loss(batch) * len(indices)
            # Detectors may look closer at the cameras' own pixels than their networks do.
            found += [self._detector.detect(self._validation.frame(index)) for index in indices]
        return {
            **self._precision(found),
            "loss": losses / len(found),
            "detections_per_frame": float(np.mean([len(boxes) for boxes in found])),
        }

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._detector.configuration),
            "categories": list(self._categories),
            "augmentation": asdict(self._augmentation),
            "data": self._data,
        }

    def _total_loss(self, batch: StereoSampleBatch) -> float:
        device = next(self.network.parameters()).device
        terms = self.losses(batch.to(device)).values()
        return float(torch.stack([term.detach() for term in terms]).sum())

    def _precision(self, found: Sequence[Boxes3D]) -> dict[str, float]:
        metrics: dict[str, float] = {}
        for category in self._categories:
            metrics |= precision(self._validation.labels, found, category, _MEASURES)
        return metrics
