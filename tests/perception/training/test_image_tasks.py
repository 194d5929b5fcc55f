"""The detectors of images as tasks: they learn, and say how well, on a few small frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors.faster_rcnn.configuration import SMALL as FASTER_RCNN
from avsec_gym.perception.detectors.faster_rcnn.detector import FasterRcnnDetector
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.detectors.yolo.configuration import SMALL as YOLO
from avsec_gym.perception.detectors.yolo.detector import YoloDetector
from avsec_gym.perception.nn.region_counts import ProposalCount
from avsec_gym.perception.training.configuration import Augmentation, TrainingConfiguration
from avsec_gym.perception.training.image_tasks import ImageDetectionTask
from avsec_gym.perception.training.stereo_samples import prepare_samples
from avsec_gym.perception.training.tasks import TASKS
from avsec_gym.perception.training.trainer import train
from avsec_gym.perception.training.training_data import training_data

pytestmark = pytest.mark.usefixtures("undrawn_curves")

SIZE = (64, 192)
NARROW_RCNN = replace(
    FASTER_RCNN,
    input_size=SIZE,
    stem_channels=8,
    stage_blocks=(1, 1, 1, 1),
    stage_channels=(8, 8, 8, 8),
    pyramid_channels=16,
    anchor_sizes=(8, 12, 16, 24, 32),
    box_channels=16,
    training_proposals=ProposalCount(64, 32),
    test_proposals=ProposalCount(32, 8),
)
NARROW_YOLO = replace(
    YOLO,
    input_size=SIZE,
    stem_channels=8,
    stage_blocks=(1, 1, 1, 1, 1),
    stage_channels=(16, 16, 32, 32, 32),
)


def _task(name: str, folder: Path, cache: Path) -> ImageDetectionTask:
    torch.manual_seed(0)
    data = training_data([folder])
    parts = [prepare_samples(frames, SIZE, cache) for frames in (data.training, data.validation)]
    detector: FasterRcnnDetector | YoloDetector = (
        YoloDetector(NARROW_YOLO) if name == "yolo" else FasterRcnnDetector(NARROW_RCNN)
    )
    return ImageDetectionTask(detector, ("Car",), parts[0], parts[1], Augmentation(), {})


@pytest.mark.parametrize("name", ["faster_rcnn", "yolo"])
def test_every_part_learns(name: str, spot_folder: Path, tmp_path: Path) -> None:
    assert name in TASKS
    task = _task(name, spot_folder, tmp_path / "cache")
    before = {key: value.clone() for key, value in task.network.named_parameters()}
    outcome = train(task, TrainingConfiguration(epochs=1, batch=2), tmp_path / "run")
    assert (outcome.finished, outcome.steps) == (True, 3)
    still = [k for k, value in task.network.named_parameters() if torch.equal(value, before[k])]
    assert not still
    assert task.leading_metric == "Car_2d_ap40"


def test_the_truth_as_detections_is_perfect(spot_folder: Path, tmp_path: Path) -> None:
    """Found in the reduced images, scored in the cameras' own pixels."""
    frames = training_data([spot_folder]).training
    samples = prepare_samples(frames, SIZE, tmp_path / "cache")
    detector = YoloDetector(NARROW_YOLO)
    truth = iter([samples[index].truth.box2d for index in range(6)])
    detector.detect_batch = lambda images: [  # type: ignore[method-assign]
        image_boxes(box, np.ones(len(box)), ["Car"] * len(box))
        for _, box in zip(images, truth, strict=False)
    ]
    metrics = ImageDetectionTask(
        detector, ("Car",), samples, samples, Augmentation(), {}
    ).validate()
    assert metrics["Car_2d_ap40"] == metrics["Car_2d_ap40_iou50"]
    perfect = average_precision(samples.labels, samples.labels, classes=("Car",))
    assert metrics["Car_2d_ap11"] == perfect.value("Car", "2d") > 0
    assert np.isfinite(metrics["loss"])
