"""The task of PointRCNN: cars among the points of labelled scans, both stages at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.perception.detectors.pointrcnn.detector import PointRcnnDetector
from avsec_gym.perception.detectors.pointrcnn.losses import pointrcnn_losses
from avsec_gym.perception.detectors.pointrcnn.points_input import sampled_points
from avsec_gym.perception.detectors.pointrcnn.proposals import overlaps
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.point_augmentation import LARGEST_TURN, varied_points
from avsec_gym.perception.training.point_samples import (
    NEEDED,
    PointSamples,
    prepare_point_samples,
)
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data
from avsec_gym.perception.weights.store import load_weights


@dataclass(frozen=True, eq=False)
class PointBatch:
    """Scans with the truth.

    Args:
        points: Camera frame, shape (B, N, 3).
        objects: Of each scan, (M, 7).
        ignored: Of each scan, (K, 7).
    """

    points: Tensor
    objects: list[Tensor]
    ignored: list[Tensor]

    def to(self, device: torch.device | str) -> PointBatch:
        """On another device."""
        objects, ignored = (
            [boxes.to(device) for boxes in each] for each in (self.objects, self.ignored)
        )
        return PointBatch(self.points.to(device), objects, ignored)


class PointRcnnTask:
    """A `Task`.

    Args:
        detector: Its network is trained in place.
        training: What the network sees of scans.
        validation: Of other scans.
        augmentation: Of training samples; see `varied_points`.
        data: JSON-able: what the samples are.
    """

    name = "pointrcnn"

    def __init__(
        self,
        detector: PointRcnnDetector,
        training: PointSamples,
        validation: PointSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        self.leading_metric = f"{detector.configuration.category}_3d_ap40"
        self._detector, self._augmentation, self._data = detector, augmentation, data
        self._training, self._validation = training, validation

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> PointBatch:
        """See `Task`."""
        view = self._detector.configuration.view
        points, objects, ignored = [], [], []
        for index in indices:
            one = varied_points(self._training[index], self._augmentation, randomness)
            points.append(torch.from_numpy(sampled_points(one.points, view, randomness)))
            objects.append(torch.from_numpy(one.objects).float())
            ignored.append(torch.from_numpy(one.ignored).float())
        return PointBatch(torch.stack(points), objects, ignored)

    def losses(self, batch: PointBatch) -> dict[str, Tensor]:
        """See `Task`."""
        network = self._detector.network
        return pointrcnn_losses(network, batch.points, batch.objects, batch.ignored)

    def validate(self) -> dict[str, float]:
        """Average precision (percent, moderate, unless named otherwise), and recalls of proposals.

        ``..._iou50`` stands for the easier thresholds `LOW_IOU`, 0.5 for cars; ``proposal_recall``
        for the share of the objects that a proposal overlaps by half.
        """
        samples = self._validation
        stages = [self._detector.both_stages(samples.frame(i)) for i in range(len(samples))]
        proposed, found = zip(*stages, strict=True)
        category = self._detector.configuration.category
        strict, low = (
            average_precision(samples.labels, found, classes=(category,), min_iou=iou)
            for iou in (STANDARD_IOU, LOW_IOU)
        )
        return {
            f"{category}_3d_ap40": strict.value(category, recall_points=40),
            f"{category}_3d_ap11": strict.value(category),
            f"{category}_3d_ap11_easy": strict.value(category, level="easy"),
            f"{category}_3d_ap11_hard": strict.value(category, level="hard"),
            f"{category}_3d_ap11_iou50": low.value(category),
            f"{category}_bev_ap11": strict.value(category, "bev"),
            f"{category}_2d_ap11": strict.value(category, "2d"),
            "proposal_recall": self._recall(proposed),
            "detections_per_frame": float(np.mean([len(boxes) for boxes in found])),
        }

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._detector.configuration),
            "augmentation": asdict(self._augmentation) | {"largest_turn": LARGEST_TURN},
            "data": self._data,
        }

    def _recall(self, proposed: Sequence[Boxes3D]) -> float:
        """Share of the objects that can be found and that a proposal overlaps by half."""
        hits: list[bool] = []
        for index, boxes in enumerate(proposed):
            objects = torch.from_numpy(self._validation[index].objects)
            rows = np.column_stack([boxes.location, boxes.dimensions, boxes.rotation_y])
            shared = overlaps(objects, torch.from_numpy(rows))
            hits += (shared >= 0.5).any(1).tolist()
        return float(np.mean(hits)) if hits else 0.0


def pointrcnn_task(options: TaskOptions) -> PointRcnnTask:
    """PointRCNN; see `make_task`."""
    torch.manual_seed(options.seed)
    detector = PointRcnnDetector(options.preset)
    if options.start is not None:
        load_weights(options.start, detector.network)
    data = training_data(options.data, options.validation, needed=NEEDED)
    training, validation = (
        prepare_point_samples(
            frames, detector.configuration, options.cache, on_progress=options.on_progress
        )
        for frames in (data.training, data.validation)
    )
    return PointRcnnTask(detector, training, validation, options.augmentation, data.description())
