"""PointRCNN as a task: it learns, resumes bit for bit, and is judged in 3D."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors.pointrcnn import configuration as presets
from avsec_gym.perception.detectors.pointrcnn.configuration import (
    Level,
    PointRcnnConfiguration,
    PointView,
    ProposalRule,
    Refinement,
    RegionSampling,
)
from avsec_gym.perception.detectors.pointrcnn.detector import PointRcnnDetector
from avsec_gym.perception.nn.points_in_boxes import points_in_boxes
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.pointrcnn_task import pointrcnn_task
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.weights.store import load_weights, read_card

pytestmark = pytest.mark.usefixtures("undrawn_curves")

TINY = replace(
    PointRcnnConfiguration.preset("small"),
    view=PointView((-8.0, 8.0), forward=(0.0, 30.0), points=256, far=20.0, most_far=0.5),
    levels=(
        Level(64, (0.5, 1.0), (8, 8), ((8, 16), (8, 16))),
        Level(16, (1.5, 3.0), (8, 8), ((16, 32), (16, 32))),
    ),
    propagation=((32, 32), (48,)),
    head=(32,),
    dropout=0.0,
    proposals=ProposalRule(128, 8, 0.5),
    training_proposals=ProposalRule(128, 16, 0.7),
    refinement=Refinement(
        32,
        inputs=(16, 32),
        levels=(Level(8, (0.8,), (8,), ((32, 32),)), Level(None, (9.0,), (1,), ((32, 48),))),
        head=(32,),
    ),
    sampling=RegionSampling(8),
)


@pytest.fixture
def options(scan_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> TaskOptions:
    monkeypatch.setitem(presets._PRESETS, "tiny", TINY)
    still = Augmentation(flip=0.0, zoom=1.0)
    return TaskOptions("tiny", (scan_folder,), (), tmp_path / "cache", augmentation=still)


def test_batches_show_the_cars_where_the_boxes_are(options: TaskOptions) -> None:
    task = pointrcnn_task(options)
    assert task.samples == 6
    batch = task.batch([0, 4], np.random.default_rng(0))
    assert batch.points.shape == (2, 256, 3)
    again = task.batch([0, 4], np.random.default_rng(0))
    assert torch.equal(batch.points, again.points)
    for points, objects, ignored in zip(batch.points, batch.objects, batch.ignored, strict=True):
        assert (len(objects), len(ignored)) == (1, 0)
        inside = points_in_boxes(points, objects)[0]
        raised = points[:, 1] < 1.5
        assert inside.sum() > 20
        assert (inside & raised).sum() > 0.95 * raised.sum()


def test_resumed_training_equals_uninterrupted_one(
    options: TaskOptions, resumed_equals_uninterrupted: Callable[[Callable[[], object]], Path]
) -> None:
    resumed_equals_uninterrupted(lambda: pointrcnn_task(options))


def test_perfect_boxes_have_full_precision_and_recall(options: TaskOptions) -> None:
    # All frames: in the two that are held out, the car is too small in the image to count.
    task = pointrcnn_task(replace(options, validation=options.data))
    labels = {f"{number:06d}": boxes for number, boxes in enumerate(task._validation.labels)}

    class ByHeart(PointRcnnDetector):
        def both_stages(self, frame: SensorFrame) -> tuple[Boxes3D, Boxes3D]:
            return labels[frame.id], labels[frame.id]

    task._detector = ByHeart(TINY)
    metrics = task.validate()
    assert task.leading_metric == "Car_3d_ap40"
    best = average_precision(list(labels.values()), list(labels.values()), classes=("Car",))
    assert metrics["Car_3d_ap40"] == best.value("Car", recall_points=40) > 0
    assert metrics["proposal_recall"] == 1
    assert metrics["detections_per_frame"] == 1


@pytest.mark.slow
def test_command_leaves_weights_with_a_card(
    options: TaskOptions, scan_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    arguments = ["train", "pointrcnn", "--data", str(scan_folder), "--out", str(out)]
    arguments += ["--preset", "tiny", "--epochs", "1", "--batch", "3", "--json"]
    assert run(arguments) == 0
    assert json.loads(capsys.readouterr().out)["steps"] == 2
    card = read_card(out / "weights.safetensors")
    assert card is not None
    assert (card.network, card.data["training"][0]["frames"]) == ("pointrcnn", 6)
    assert "Car_3d_ap40" in card.metrics
    load_weights(out / "weights.safetensors", PointRcnnDetector(TINY).network)
