"""The stereo networks as tasks: DSGN, Stereo R-CNN and PSMNet on labelled pairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import nn

from avsec_gym.perception.training.detection_task import DetectionTask, TrainableDetector
from avsec_gym.perception.training.disparity_task import DisparityTask
from avsec_gym.perception.training.stereo_samples import StereoSamples, prepare_samples
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data
from avsec_gym.perception.weights.store import ModelCard, load_weights


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
    _start(estimator.network, options)
    size = estimator.configuration.input_size
    training, validation, data = _samples(options, size)
    return DisparityTask(estimator, training, validation, options.augmentation, data)


def _detection_task(
    detector: TrainableDetector, categories: Sequence[str], options: TaskOptions
) -> DetectionTask:
    card = _start(detector.network, options)
    size = detector.configuration.input_size
    training, validation, data = _samples(options, size)
    task = DetectionTask(detector, categories, training, validation, options.augmentation, data)
    if card is not None:
        task.continue_with(card.beside)
    return task


def _start(network: nn.Module, options: TaskOptions) -> ModelCard | None:
    return None if options.start is None else load_weights(options.start, network)


def _samples(
    options: TaskOptions, size: tuple[int, int] | None
) -> tuple[StereoSamples, StereoSamples, dict[str, Any]]:
    data = training_data(options.data, options.validation)
    training, validation = (
        prepare_samples(frames, size, options.cache, on_progress=options.on_progress)
        for frames in (data.training, data.validation)
    )
    return training, validation, data.description()
