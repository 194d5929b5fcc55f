"""What tasks of stereo and image detectors share: their network, validation and precision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import LOW_IOU, MinIou
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.precision import precision
from avsec_gym.perception.training.sample import StereoSampleBatch, sample_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples
from avsec_gym.perception.training.stereo_task import StereoTask

_VALIDATION_BATCH = 4


class TrainableDetector(Protocol):
    """What of a detector is needed by every task; see `DifferentiableDetector`."""

    name: str

    @property
    def network(self) -> nn.Module:
        """What is trained."""
        ...

    @property
    def configuration(self) -> Any:
        """A dataclass with an `input_size`."""
        ...


_Detector = TypeVar("_Detector", bound=TrainableDetector)


class DetectionTask(StereoTask, Generic[_Detector]):
    """The part of a `Task` that does not depend on what of a pair a detector takes.

    A task states its measures, its `losses`, and how detections of a validation batch are `found`.

    Args:
        detector: The detector, whose network is trained in place.
        categories: The categories whose precision is measured; that of the first leads.
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    leading_measure: str
    """The measure by which the best weights are chosen; see `precision`."""
    measures: tuple[str, ...]
    """All that a validation reports; see `precision`."""

    def __init__(
        self,
        detector: _Detector,
        categories: Sequence[str],
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        targets = getattr(detector, "target_maker", None)
        super().__init__(training, validation, augmentation, data, targets)
        self.name = detector.name
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        weights = getattr(detector, "term_weights", None)
        if isinstance(weights, nn.Module):
            parts = {"network": self.network, "term_weights": weights.requires_grad_(True)}
            self.trained = nn.ModuleDict(parts)
        self.leading_metric = f"{categories[0]}_{self.leading_measure}"
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
        raise NotImplementedError

    def found(self, batch: StereoSampleBatch, indices: Sequence[int]) -> list[Boxes3D]:
        """Detections of validation samples, in the cameras' own pixels.

        Args:
            batch: The samples as the network takes them, on its device.
            indices: The indices of the samples.
        """
        raise NotImplementedError

    def easier(self, category: str) -> MinIou:
        """The overlaps that count in measures on ``iou50``: 0.5 for cars."""
        return LOW_IOU

    def validate(self) -> dict[str, float]:
        """Average precision (percent, moderate, unless named otherwise), and the loss.

        ``..._iou50`` stands for the `easier` overlaps.
        """
        device = next(self.network.parameters()).device
        found: list[Boxes3D] = []
        loss = 0.0
        for indices in self._validation.groups(_VALIDATION_BATCH):
            batch = sample_batch([self._validation[index] for index in indices]).to(device)
            terms = self.losses(batch).values()
            loss += float(torch.stack([term.detach() for term in terms]).sum()) * len(indices)
            found += self.found(batch, indices)
        return {
            **self._precision(found),
            "loss": loss / len(found),
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

    def _precision(self, found: Sequence[Boxes3D]) -> dict[str, float]:
        metrics: dict[str, float] = {}
        for category in self._categories:
            labels, easier = self._validation.labels, self.easier(category)
            metrics |= precision(labels, found, category, self.measures, easier)
        return metrics
