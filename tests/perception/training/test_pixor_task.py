"""PIXOR as a task: it learns, resumes bit for bit, and is judged from above."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.cli import run
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors.pixor import configuration as presets
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion, PixorConfiguration
from avsec_gym.perception.detectors.pixor.detector import PixorDetector
from avsec_gym.perception.training.configuration import Augmentation, TrainingConfiguration
from avsec_gym.perception.training.pixor_task import PixorTask, pixor_task
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.trainer import train
from avsec_gym.perception.weights.store import load_weights, read_card

pytestmark = pytest.mark.usefixtures("undrawn_curves")

TINY = replace(
    PixorConfiguration.preset("small"),
    region=BirdEyeRegion((0.0, 22.4), (-6.4, 6.4), (-2.5, 0.5), 0.4, 0.5),
    stem=8,
    planes=(4, 6, 8, 8),
    blocks=(1, 1, 1, 1),
    strides=(1, 1, 2, 2),
    laterals=(16, 16, 16),
)


@pytest.fixture
def options(scan_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> TaskOptions:
    monkeypatch.setitem(presets._PRESETS, "tiny", TINY)
    still = Augmentation(flip=0.0, zoom=1.0)
    return TaskOptions("tiny", (scan_folder,), (), tmp_path / "cache", augmentation=still)


def test_batches_show_the_cars_where_the_targets_are(options: TaskOptions) -> None:
    task = pixor_task(options)
    assert task.samples == 6
    batch = task.batch([0, 4], np.random.default_rng(0))
    assert batch.scans.shape == (2, *TINY.region.shape)
    again = task.batch([0, 4], np.random.default_rng(0))
    assert torch.equal(batch.scans, again.scans)
    # All slices above the road are occupied on the car only; both grids have cells of 0.4 m.
    raised = batch.scans[:, 3:-1].amax(dim=1) > 0
    for number in range(2):
        assert (raised[number] & batch.targets.positive[number]).sum() > 15
        assert (raised[number] & ~batch.targets.positive[number]).sum() < raised[number].sum() / 2


def test_resumed_training_equals_uninterrupted_one(
    options: TaskOptions, resumed_equals_uninterrupted: Callable[[Callable[[], object]], Path]
) -> None:
    resumed_equals_uninterrupted(lambda: pixor_task(options))


def test_perfect_rectangles_have_full_precision_from_above(options: TaskOptions) -> None:
    # All frames: in the two that are held out, the car is too small in the image to count.
    task = pixor_task(replace(options, validation=options.data))
    network = task.network

    class ByHeart(torch.nn.Module):
        """Says what the targets say, for the validation frames in their order."""

        def __init__(self) -> None:
            super().__init__()
            self.calls, self.any = 0, torch.nn.Parameter(torch.zeros(1))

        def forward(self, scans: torch.Tensor) -> object:
            output = network(scans)
            targets = task.batch_of([task._validation[self.calls]]).targets
            self.calls += 1
            logits = torch.where(targets.positive, 4.0, -9.0)
            return replace(output, logits=logits, values=targets.values)

    task._detector.network = ByHeart()  # type: ignore[assignment]
    metrics = task.validate()
    assert task.leading_metric == "Car_bev_ap40"
    assert metrics["Car_bev_ap40"] == _best(task, recall_points=40) > 0
    assert metrics["detections_per_frame"] == 1


@pytest.mark.slow
def test_learns_to_find_the_cars(options: TaskOptions, tmp_path: Path) -> None:
    task = pixor_task(replace(options, validation=options.data))
    configuration = TrainingConfiguration(
        epochs=40, batch=2, learning_rate=1e-2, average=0.8, validate_every=40
    )
    train(task, configuration, tmp_path / "run")
    assert task.validate()["Car_bev_ap11_iou50"] > 0.6 * _best(task, recall_points=11)


def _best(task: PixorTask, recall_points: int) -> float:
    """What the labels themselves would reach: less than 100, as they are few."""
    labels = task._validation.labels
    found = average_precision(labels, labels, classes=("Car",))
    return found.value("Car", "bev", recall_points=recall_points)


@pytest.mark.slow
def test_command_leaves_weights_with_a_card(
    options: TaskOptions, scan_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    arguments = ["train", "pixor", "--data", str(scan_folder), "--out", str(out)]
    arguments += ["--preset", "tiny", "--epochs", "1", "--batch", "3", "--json"]
    assert run(arguments) == 0
    assert json.loads(capsys.readouterr().out)["steps"] == 2
    card = read_card(out / "weights.safetensors")
    assert card is not None
    assert (card.network, card.data["training"][0]["frames"]) == ("pixor", 6)
    assert "Car_bev_ap40" in card.metrics
    load_weights(out / "weights.safetensors", PixorDetector(TINY).network)
