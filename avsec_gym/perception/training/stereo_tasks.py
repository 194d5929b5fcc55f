"""The stereo networks as tasks: DSGN, Stereo R-CNN and PSMNet on labelled pairs."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from avsec_gym.perception.training.detection_task import DetectionTask, TrainableDetector
from avsec_gym.perception.training.disparity_task import DisparityTask
from avsec_gym.perception.training.stereo_task import stereo_samples
from avsec_gym.perception.training.tasks import TaskOptions


def dsgn_task(options: TaskOptions) -> DetectionTask:
    """DSGN; see `make_task`."""
    from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector

    torch.manual_seed(options.seed)
    detector = DsgnDetector(options.preset)
    return _detection_task(detector, detector.categories, options)


def stereo_rcnn_task(options: TaskOptions) -> DetectionTask:
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
    detector: TrainableDetector, categories: Sequence[str], options: TaskOptions
) -> DetectionTask:
    card = options.begin(detector.network)
    samples = stereo_samples(options, detector.configuration.input_size)
    task = DetectionTask(detector, categories, *samples)
    if card is not None:
        task.continue_with(card.beside)
    return task
