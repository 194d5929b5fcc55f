"""The stereo networks as tasks: DSGN, Stereo R-CNN and PSMNet on labelled pairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.perception.training.detection_task import DetectionTask, TrainableDetector
from avsec_gym.perception.training.disparity_task import DisparityTask
from avsec_gym.perception.training.sample import StereoSampleBatch
from avsec_gym.perception.training.stereo_task import stereo_samples
from avsec_gym.perception.training.tasks import TaskOptions


class TrainableStereoDetector(TrainableDetector, Protocol):
    """What of a detector is needed here; see `DifferentiableDetector`."""

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame."""
        ...

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        """The terms of the loss."""
        ...


class StereoDetectionTask(DetectionTask[TrainableStereoDetector]):
    """A `Task`: stereo pairs, objects judged in space."""

    leading_measure = "3d_ap40"
    measures = (
        "3d_ap11", "3d_ap40", "3d_ap11_easy", "3d_ap11_hard",
        "bev_ap11", "2d_ap11", "3d_ap11_iou50",
    )  # fmt: skip

    def losses(self, batch: StereoSampleBatch) -> dict[str, Tensor]:
        """See `Task`."""
        targets = {} if batch.targets is None else {"targets": batch.targets}
        return self._detector.losses(batch.stereo, batch.truth, batch.disparity, **targets)

    def found(self, batch: StereoSampleBatch, indices: Sequence[int]) -> list[Boxes3D]:
        """See `DetectionTask`."""
        # Detectors may look closer at the cameras' own pixels than their networks do.
        return [self._detector.detect(self._validation.frame(index)) for index in indices]


def dsgn_task(options: TaskOptions) -> StereoDetectionTask:
    """DSGN; see `make_task`."""
    from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector

    torch.manual_seed(options.seed)
    detector = DsgnDetector(options.preset)
    return _detection_task(detector, detector.categories, options)


def stereo_rcnn_task(options: TaskOptions) -> StereoDetectionTask:
    """Stereo R-CNN; see `make_task`."""
    from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector

    torch.manual_seed(options.seed)
    detector = StereoRcnnDetector(options.preset)
    return _detection_task(detector, detector.configuration.categories, options)


def psmnet_task(options: TaskOptions) -> DisparityTask:
    """PSMNet; see `make_task`."""
    from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth

    torch.manual_seed(options.seed)
    estimator = PsmNetDepth(options.preset)
    options.begin(estimator.network)
    return DisparityTask(estimator, *stereo_samples(options, estimator.configuration.input_size))


def _detection_task(
    detector: TrainableStereoDetector, categories: Sequence[str], options: TaskOptions
) -> StereoDetectionTask:
    card = options.begin(detector.network)
    samples = stereo_samples(options, detector.configuration.input_size)
    task = StereoDetectionTask(detector, categories, *samples)
    if card is not None:
        task.continue_with(card.beside)
    return task
