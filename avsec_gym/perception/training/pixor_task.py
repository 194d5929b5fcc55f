"""The task of PIXOR: cars in labelled LiDAR scans, judged from above on other frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.perception.detectors.pixor.bird_eye_input import bird_eye_input
from avsec_gym.perception.detectors.pixor.detector import PixorDetector
from avsec_gym.perception.detectors.pixor.losses import pixor_losses
from avsec_gym.perception.detectors.pixor.targets import PixorTargets, cell_targets
from avsec_gym.perception.training.cloud_augmentation import LARGEST_TURN, varied
from avsec_gym.perception.training.cloud_samples import (
    NEEDED,
    CloudSample,
    CloudSamples,
    prepare_cloud_samples,
)
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data
from avsec_gym.perception.weights.store import load_weights


@dataclass(frozen=True, eq=False)
class PixorBatch:
    """Scans with the truth.

    Args:
        scans: Shape (B, channels, rows, columns).
        targets: Of each.
    """

    scans: Tensor
    targets: PixorTargets

    def to(self, device: torch.device | str) -> PixorBatch:
        """On another device."""
        return PixorBatch(self.scans.to(device), self.targets.to(device))


class PixorTask:
    """A `Task`.

    Args:
        detector: Its network is trained in place.
        training: Scans cropped to the network's region.
        validation: Other scans.
        augmentation: Of training samples; see `varied`.
        data: JSON-able: what the samples are.
    """

    name = "pixor"

    def __init__(
        self,
        detector: PixorDetector,
        training: CloudSamples,
        validation: CloudSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        self.leading_metric = f"{detector.configuration.category}_bev_ap40"
        self._detector, self._augmentation, self._data = detector, augmentation, data
        self._training, self._validation = training, validation

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> PixorBatch:
        """See `Task`."""
        samples = [varied(self._training[i], self._augmentation, randomness) for i in indices]
        return self.batch_of(samples)

    def batch_of(self, samples: Sequence[CloudSample]) -> PixorBatch:
        """Samples as they are."""
        configuration = self._detector.configuration
        scans = [bird_eye_input(one.points, configuration.region) for one in samples]
        targets = [
            cell_targets(one.rectangles, configuration, ignored=one.ignored, azimuths=one.azimuths)
            for one in samples
        ]
        return PixorBatch(torch.from_numpy(np.stack(scans)), PixorTargets.concatenate(targets))

    def losses(self, batch: PixorBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return pixor_losses(self.network(batch.scans), batch.targets, self._detector.configuration)

    def validate(self) -> dict[str, float]:
        """Average precision (percent, moderate, unless named otherwise).

        ``..._iou50`` stands for the easier thresholds `LOW_IOU`, 0.5 for cars.
        """
        samples = self._validation
        found = [self._detector.detect(samples.frame(index)) for index in range(len(samples))]
        category = self._detector.configuration.category
        strict, low = (
            average_precision(samples.labels, found, classes=(category,), min_iou=iou)
            for iou in (STANDARD_IOU, LOW_IOU)
        )
        return {
            f"{category}_bev_ap40": strict.value(category, "bev", recall_points=40),
            f"{category}_bev_ap11": strict.value(category, "bev"),
            f"{category}_bev_ap11_easy": strict.value(category, "bev", "easy"),
            f"{category}_bev_ap11_hard": strict.value(category, "bev", "hard"),
            f"{category}_bev_ap11_iou50": low.value(category, "bev"),
            f"{category}_3d_ap11": strict.value(category),
            f"{category}_2d_ap11": strict.value(category, "2d"),
            "detections_per_frame": float(np.mean([len(boxes) for boxes in found])),
        }

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._detector.configuration),
            "augmentation": asdict(self._augmentation) | {"largest_turn": LARGEST_TURN},
            "data": self._data,
        }


def pixor_task(options: TaskOptions) -> PixorTask:
    """PIXOR; see `make_task`."""
    torch.manual_seed(options.seed)
    detector = PixorDetector(options.preset)
    if options.start is not None:
        load_weights(options.start, detector.network)
    data = training_data(options.data, options.validation, needed=NEEDED)
    configuration = detector.configuration
    training, validation = (
        prepare_cloud_samples(
            frames,
            configuration.region,
            configuration.category,
            options.cache,
            on_progress=options.on_progress,
        )
        for frames in (data.training, data.validation)
    )
    return PixorTask(detector, training, validation, options.augmentation, data.description())
