"""The detectors of single images as tasks: their losses on left images, and 2D precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.faster_rcnn.detector import FasterRcnnDetector
from avsec_gym.perception.detectors.yolo.detector import YoloDetector
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.precision import precision
from avsec_gym.perception.training.sample import StereoSampleBatch, sample_batch
from avsec_gym.perception.training.stereo_samples import StereoSamples
from avsec_gym.perception.training.stereo_task import StereoTask, stereo_samples
from avsec_gym.perception.training.tasks import TaskOptions

_VALIDATION_BATCH = 4
_MEASURES = (
    "2d_ap40", "2d_ap11", "2d_ap11_easy", "2d_ap11_hard", "2d_ap40_iou50", "2d_ap11_iou50",
)  # fmt: skip
_HALF = 0.5
"""The easier overlap, beside the benchmark's."""


def faster_rcnn_task(options: TaskOptions) -> ImageDetectionTask:
    """Faster R-CNN; see `make_task`."""
    torch.manual_seed(options.seed)
    return _task(FasterRcnnDetector(options.preset), options)


def yolo_task(options: TaskOptions) -> ImageDetectionTask:
    """YOLOv3; see `make_task`."""
    torch.manual_seed(options.seed)
    return _task(YoloDetector(options.preset), options)


class ImageDetectionTask(StereoTask):
    """A `Task`.

    Samples are stereo pairs, so that they are reduced once for all networks of a size, and that
    another view's image stands in the mirror.

    Args:
        detector: The detector, whose network is trained in place.
        training: Samples of the network's input size.
        validation: Other samples of this size.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    def __init__(
        self,
        detector: FasterRcnnDetector | YoloDetector,
        training: StereoSamples,
        validation: StereoSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        super().__init__(training, validation, augmentation, data)
        self.name = detector.name
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        self._categories = detector.configuration.categories
        self.leading_metric = f"{self._categories[0]}_2d_ap40"
        self._detector = detector

    def losses(self, batch: StereoSampleBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return self._detector.losses(batch.stereo.left, batch.truth)

    def validate(self) -> dict[str, float]:
        """Average precision in the image (percent, moderate, unless named otherwise), and the loss.

        ``..._iou50`` stands for an overlap of 0.5 instead of the benchmark's.
        """
        device = next(self.network.parameters()).device
        found: list[Boxes3D] = []
        loss = 0.0
        for indices in self._validation.groups(_VALIDATION_BATCH):
            batch = sample_batch([self._validation[index] for index in indices]).to(device)
            terms = self.losses(batch).values()
            loss += float(torch.stack([term.detach() for term in terms]).sum()) * len(indices)
            size = (batch.stereo.left.shape[2], batch.stereo.left.shape[3])
            for index, boxes in zip(
                indices, self._detector.detect_batch(batch.stereo.left), strict=True
            ):
                found.append(_enlarged(boxes, size, self._validation.sizes[index]))
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
            half = {category: (_HALF, _HALF, _HALF)}
            metrics |= precision(self._validation.labels, found, category, _MEASURES, half)
        return metrics


def _task(detector: FasterRcnnDetector | YoloDetector, options: TaskOptions) -> ImageDetectionTask:
    options.begin(detector.network)
    return ImageDetectionTask(detector, *stereo_samples(options, detector.configuration.input_size))


def _enlarged(boxes: Boxes3D, size: tuple[int, int], own: tuple[int, int]) -> Boxes3D:
    """2D boxes in images of one size, in those of the camera's own size."""
    assert boxes.box2d is not None, "detections in images have 2D boxes"
    scale = np.array([own[1] / size[1], own[0] / size[0]] * 2)
    return replace(boxes, box2d=(boxes.box2d + 0.5) * scale - 0.5)
