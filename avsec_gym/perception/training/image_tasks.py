"""The detectors of single images as tasks: their losses on left images, and 2D precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import MinIou
from avsec_gym.perception.detectors.faster_rcnn.detector import FasterRcnnDetector
from avsec_gym.perception.detectors.yolo.detector import YoloDetector
from avsec_gym.perception.training.detection_task import DetectionTask
from avsec_gym.perception.training.precision import half_in_images
from avsec_gym.perception.training.sample import StereoSampleBatch
from avsec_gym.perception.training.stereo_task import stereo_samples
from avsec_gym.perception.training.tasks import TaskOptions


def faster_rcnn_task(options: TaskOptions) -> ImageDetectionTask:
    """Faster R-CNN; see `make_task`."""
    torch.manual_seed(options.seed)
    return _task(FasterRcnnDetector(options.preset), options)


def yolo_task(options: TaskOptions) -> ImageDetectionTask:
    """YOLOv3; see `make_task`."""
    torch.manual_seed(options.seed)
    return _task(YoloDetector(options.preset), options)


class ImageDetectionTask(DetectionTask[FasterRcnnDetector | YoloDetector]):
    """A `Task`: left images, cars judged in the image.

    Samples are stereo pairs, so that they are reduced once for all networks of a size, and that
    another view's image stands in the mirror.
    """

    leading_measure = "2d_ap40"
    measures = (
        "2d_ap40", "2d_ap11", "2d_ap11_easy", "2d_ap11_hard", "2d_ap40_iou50", "2d_ap11_iou50",
    )  # fmt: skip

    def losses(self, batch: StereoSampleBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return self._detector.losses(batch.stereo.left, batch.truth)

    def found(self, batch: StereoSampleBatch, indices: Sequence[int]) -> list[Boxes3D]:
        """See `DetectionTask`."""
        images = batch.stereo.left
        size = (images.shape[2], images.shape[3])
        return [
            _enlarged(boxes, size, self._validation.sizes[index])
            for index, boxes in zip(indices, self._detector.detect_batch(images), strict=True)
        ]

    def easier(self, category: str) -> MinIou:
        """An overlap of 0.5 instead of the benchmark's, for every category."""
        return half_in_images(category)


def _task(detector: FasterRcnnDetector | YoloDetector, options: TaskOptions) -> ImageDetectionTask:
    options.begin(detector.network)
    configuration = detector.configuration
    samples = stereo_samples(options, configuration.input_size)
    return ImageDetectionTask(detector, configuration.categories, *samples)


def _enlarged(boxes: Boxes3D, size: tuple[int, int], own: tuple[int, int]) -> Boxes3D:
    """2D boxes in images of one size, in those of the camera's own size."""
    assert boxes.box2d is not None, "detections in images have 2D boxes"
    scale = np.array([own[1] / size[1], own[0] / size[0]] * 2)
    return replace(boxes, box2d=(boxes.box2d + 0.5) * scale - 0.5)
