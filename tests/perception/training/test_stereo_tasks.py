"""The stereo networks as tasks: each learns, and resumes bit for bit, on a few small frames."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from avsec_gym.cli import run
from avsec_gym.perception.depth.psmnet import PsmNetConfiguration
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.dsgn.grid import CAR, DepthScale, GridAxis, WorldGrid
from avsec_gym.perception.detectors.stereo_rcnn.configuration import (
    PRESETS,
    ProposalCount,
    StereoRcnnConfiguration,
)
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.training.checkpoint import CHECKPOINT
from avsec_gym.perception.training.configuration import Augmentation, TrainingConfiguration
from avsec_gym.perception.training.curves import read_curves
from avsec_gym.perception.training.disparity_task import DisparityTask, disparity_errors
from avsec_gym.perception.training.stereo_samples import StereoSamples, prepare_samples
from avsec_gym.perception.training.stereo_tasks import StereoDetectionTask
from avsec_gym.perception.training.task import Task
from avsec_gym.perception.training.trainer import train
from avsec_gym.perception.training.training_data import training_data
from avsec_gym.perception.weights.store import load_weights, read_card

pytestmark = pytest.mark.usefixtures("undrawn_curves")

SIZE = (64, 192)
FEATURES = FeatureConfiguration(
    first=8, stages=((8, 1),) * 4, windows=((8, 8), (4, 4)), pooled=8, matching=(8, 8), groups=4
)
DSGN = DsgnConfiguration(
    input_size=SIZE,
    padded_size=SIZE,
    features=replace(FEATURES, joined=(2, 3, 4), semantic=(8, 8)),
    groups=4,
    planes=DepthScale(40.0, 2.4, 8),
    bins=DepthScale(40.0, 2.4, 8),
    full_depth=False,
    volume_channels=16,
    grid=WorldGrid(GridAxis(-16, 16, 32), GridAxis(3, -1, 4), GridAxis(34, 2, 32)),
    grid_channels=8,
    view_channels=16,
    anchors=(CAR,),
)
RCNN: StereoRcnnConfiguration = replace(
    PRESETS["small"],
    input_size=SIZE,
    stem_channels=8,
    stage_blocks=(1, 1, 1, 1),
    stage_channels=(8, 8, 8, 8),
    pyramid_channels=16,
    rpn_channels=16,
    box_channels=16,
    keypoint_channels=16,
    keypoint_convolutions=1,
    training_proposals=ProposalCount(64, 32),
    test_proposals=ProposalCount(32, 8),
)

Data = tuple[StereoSamples, StereoSamples]


@pytest.fixture
def samples(spot_folder: Path, tmp_path: Path) -> Data:
    data = training_data([spot_folder])
    one, two = (
        prepare_samples(frames, SIZE, tmp_path / "cache")
        for frames in (data.training, data.validation)
    )
    return one, two


def dsgn(data: Data) -> Task:  # type: ignore[type-arg]
    torch.manual_seed(0)
    return StereoDetectionTask(DsgnDetector(DSGN), ("Car",), *data, Augmentation(), {})


def dsgn_of_a_cpu(data: Data) -> Task:  # type: ignore[type-arg]
    """With the heads, the loss and the volume that the small presets have."""
    torch.manual_seed(0)
    configuration = replace(
        DSGN, angles=2, half_turns=True, fit=True, depth_loss="planes", object_pixels=8.0,
        correlation_groups=4, volume_channels=4, volume_begins_with_hourglass=True,
    )  # fmt: skip
    return StereoDetectionTask(DsgnDetector(configuration), ("Car",), *data, Augmentation(), {})


def stereo_rcnn(data: Data) -> Task:  # type: ignore[type-arg]
    torch.manual_seed(0)
    return StereoDetectionTask(StereoRcnnDetector(RCNN), ("Car",), *data, Augmentation(), {})


def psmnet(data: Data) -> Task:  # type: ignore[type-arg]
    torch.manual_seed(0)
    configuration = PsmNetConfiguration(SIZE, 32, FEATURES, 8, 4)
    return DisparityTask(PsmNetDepth(configuration), *data, Augmentation(), {})


@pytest.mark.slow
@pytest.mark.parametrize("make", [dsgn, dsgn_of_a_cpu, stereo_rcnn, psmnet])
def test_resumed_training_equals_uninterrupted_one(
    samples: Data,
    resumed_equals_uninterrupted: Callable[[Callable[[], object]], Path],
    make: Callable[[Data], Task],  # type: ignore[type-arg]
) -> None:
    run = resumed_equals_uninterrupted(lambda: make(samples))
    assert read_curves(run)[-1]["metrics"].keys() >= {make(samples).leading_metric}


@pytest.mark.slow
def test_a_matching_network_learns_the_disparity_of_the_background(
    samples: Data, tmp_path: Path
) -> None:
    task = psmnet(samples)
    before = task.validate()["end_point_error"]
    train(task, TrainingConfiguration(epochs=10, batch=3, learning_rate=3e-3), tmp_path / "run")
    assert task.validate()["end_point_error"] < 0.5 * before


def test_errors_count_as_in_the_stereo_benchmark() -> None:
    truth = torch.tensor([0.0, 10.0, 10.0, 100.0, 100.0])
    found = torch.tensor([50.0, 12.0, 14.0, 104.0, 106.0])
    # 4 of 100 is less than 5 %; what is unknown does not count.
    assert disparity_errors(found, truth) == (2 + 4 + 4 + 6, 2, 4)


@pytest.mark.slow
def test_command_trains_in_sittings_and_leaves_weights_with_a_card(
    spot_folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(PRESETS, "tiny", replace(RCNN, name="tiny"))
    out = tmp_path / "run"
    arguments = ["train", "stereo_rcnn", "--data", str(spot_folder), "--out", str(out)]
    arguments += ["--preset", "tiny", "--epochs", "2", "--batch", "3", "--json"]
    assert run([*arguments, "--minutes", "0"]) == 3
    assert json.loads(capsys.readouterr().out)["steps"] == 0
    assert run(arguments) == 1
    assert "--resume" in capsys.readouterr().err
    assert run([*arguments, "--resume"]) == 0
    told = json.loads(capsys.readouterr().out)
    measured = {name: told.pop(name) for name in ("seconds", "compute_seconds", "images_per_hour")}
    assert 0 < measured["compute_seconds"] < measured["seconds"]
    assert told.pop("arithmetic").startswith(("float32: a step", "bfloat16: a step"))
    assert told == {
        "schema": "avsec.train/1",
        "network": "stereo_rcnn", "out": str(out), "finished": True, "steps": 4, "samples_seen": 12,
        "Car_3d_ap40": 0.0,
    }  # fmt: skip
    card = read_card(out / "weights.safetensors")
    assert card is not None
    assert (card.network, card.steps, card.training["batch"]) == ("stereo_rcnn", 4, 3)
    assert card.data["training"][0]["frames"] == 6
    assert card.samples_seen == 3 * card.steps
    assert card.images_per_hour == pytest.approx(
        3600 * card.samples_seen / card.compute_seconds, rel=0.2
    )
    load_weights(out / "weights.safetensors", StereoRcnnDetector(RCNN).network)
    assert run([*arguments, "--resume", "--keep", "last"]) == 0
    last = read_card(out / "weights.safetensors")
    assert last is not None
    assert (last.sha256, last.metrics, last.steps) == (card.sha256, card.metrics, 4)
    longer = [*arguments, "--start", str(out / "weights.safetensors"), "--minutes", "0"]
    assert run([*longer, "--out", str(tmp_path / "longer")]) == 3
    state = torch.load(tmp_path / "longer" / CHECKPOINT, weights_only=True)["trained"]
    learned = card.beside["term_weights.log_variances"]
    assert any(learned)
    assert state["term_weights.log_variances"].tolist() == pytest.approx(learned)
    assert run([*longer[:-2], "--epochs", "1", "--out", str(tmp_path / "longer_2")]) == 0
    went_on = read_card(tmp_path / "longer_2" / "weights.safetensors")
    assert went_on is not None
    assert [card_facts["sha256"] for card_facts in went_on.trainings()] == [
        card.sha256,
        went_on.sha256,
    ]
    capsys.readouterr()
    other = ["train", "psmnet", "--preset", "full", "--out", str(tmp_path / "other")]
    assert run([*other, "--data", str(tmp_path / "no")]) == 1
    assert "avsec world make" in capsys.readouterr().err
