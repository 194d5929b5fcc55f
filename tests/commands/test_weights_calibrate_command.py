"""`avsec weights calibrate`: a line fitted on frames, kept in the card."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from torch import nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.commands import weights_calibrate
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti import write_calibration, write_labels
from avsec_gym.perception import stereo_batch
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.detectors.score_calibration import NAME, ScoreCalibration
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import read_card, save_weights
from avsec_gym.registry import Kind
from avsec_gym.rig import kitti_rig

DONE, BAD_DATA = 0, 1
FRAMES = 40


def cars(*places: tuple[float, float, float]) -> Boxes3D:
    """Of x, z and score."""
    x, z, score = np.array(places).T
    n = len(places)
    location = np.column_stack([x, np.full(n, 1.65), z])
    box2d = np.column_stack([610 + 40 * x, np.full(n, 150), 640 + 40 * x, np.full(n, 200)])
    return Boxes3D(
        location, np.tile([1.5, 1.6, 4.0], (n, 1)), np.zeros(n), score, ["Car"] * n, box2d=box2d,
        truncation=np.zeros(n), occlusion=np.zeros(n), alpha=np.zeros(n),
    )  # fmt: skip


class HalfRight:
    """Where it says 0.1, half of the boxes are real; where it says 0.05, one in ten."""

    calibration: ScoreCalibration

    def detect(self, frame: SensorFrame) -> Boxes3D:
        number = int(frame.id)
        sure = (0.0 if number % 2 else 5.0, 20.0, 0.1)
        faint = (-5.0 if number % 10 == 0 else -9.0, 20.0, 0.05)
        return cars(sure, faint)


@pytest.fixture
def frames(tmp_path: Path) -> Path:
    for number in range(FRAMES):
        name, training = f"{number:06d}", tmp_path / "training"
        write_calibration(training / "calib" / f"{name}.txt", kitti_rig().calibration)
        write_labels(training / "label_2" / f"{name}.txt", cars((0, 20, 1), (-5, 20, 1)))
        for camera in ("image_2", "image_3"):
            (training / camera).mkdir(exist_ok=True)
            (training / camera / f"{name}.png").touch()
    return tmp_path


def test_the_card_gets_the_line(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "small.safetensors"
    before = ModelCard("dsgn", beside={"other": [1.0]}, metrics={"Car_bev_ap11": 99.0, "loss": 1.0})
    save_weights(file, nn.Linear(1, 1), before)
    monkeypatch.setattr(weights_calibrate, "make", lambda kind, what: HalfRight())
    assert run(["weights", "calibrate", str(file), "--kitti", str(frames)]) == DONE
    card = read_card(file)
    assert card is not None
    assert card.beside["other"] == [1.0]
    assert set(card.metrics) == {"Car_bev_ap11"}
    # Of 80 cars, 20 are among the 40 surer boxes and 4 among the rest: recalls 0 to 0.3 of eleven,
    # at a precision of a half or less.
    assert 100 * 3 * 0.5 / 11 <= card.metrics["Car_bev_ap11"] <= 100 * 4 * 0.5 / 11
    assert card.data["calibration"][0]["frames"] == FRAMES
    line = ScoreCalibration.of_card(card)
    assert line(np.array([0.1, 0.05])) == pytest.approx([0.5, 0.1], abs=0.03)


class Evidenced(HalfRight):
    """Both boxes have one score; what else it knows tells the real ones."""

    def evidenced(self, batch: object) -> list[SimpleNamespace]:
        number = batch.number  # type: ignore[attr-defined]
        real = number % 2 == 0
        boxes = cars((0.0 if real else 5.0, 20.0, 0.4))
        return [SimpleNamespace(boxes=boxes, evidence=np.array([[float(real), 0.5]]))]


def test_evidence_is_matched_with_its_box(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "small.safetensors"
    save_weights(file, nn.Linear(1, 1), ModelCard("stereo_rcnn"))
    monkeypatch.setattr(weights_calibrate, "make", lambda kind, what: Evidenced())
    batch = lambda frames: SimpleNamespace(number=int(frames[0].id))  # noqa: E731
    monkeypatch.setattr(stereo_batch, "batch_of_frames", batch)
    assert run(["weights", "calibrate", str(file), "--kitti", str(frames)]) == DONE
    line = ScoreCalibration.of_card(read_card(file))
    real, unreal = line(np.array([0.4, 0.4]), np.array([[1.0, 0.5], [0.0, 0.5]]))
    assert real > 0.9
    assert unreal < 0.1
    assert NAME in read_card(file).beside  # type: ignore[union-attr]
    command = ["weights", "calibrate", str(file), "--kitti", str(frames), "--no-evidence"]
    assert run(command) == DONE
    assert ScoreCalibration.of_card(read_card(file)).evidence == ()


class InTheImage(HalfRight):
    """The same boxes without their places in space."""

    def detect(self, frame: SensorFrame) -> Boxes3D:
        found = super().detect(frame)
        assert found.box2d is not None
        return image_boxes(found.box2d, found.score, found.category.tolist())


@pytest.mark.parametrize(
    ("network", "needed", "kind", "detector"),
    [
        ("yolo", "image_2", Kind.IMAGE_DETECTOR, InTheImage()),
        ("pixor", "velodyne", Kind.DETECTOR, HalfRight()),
    ],
)
def test_frames_need_what_the_detector_looks_at_and_no_more(
    network: str, needed: str, kind: Kind, detector: HalfRight,
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    made = []

    def make(kind: Kind, what: object) -> HalfRight:
        made.append(kind)
        return detector

    monkeypatch.setattr(weights_calibrate, "make", make)
    file = tmp_path / "small.safetensors"
    save_weights(file, nn.Linear(1, 1), ModelCard(network))
    command = ["weights", "calibrate", str(file), "--kitti", str(frames)]
    shutil.rmtree(frames / "training" / "image_3")
    kept = frames / "training" / "image_2"
    if needed != "image_2":
        assert run(command) == BAD_DATA
        assert "training/velodyne: There is no such folder" in capsys.readouterr().err
        kept.rename(frames / "training" / needed)
        for picture in (frames / "training" / needed).iterdir():
            picture.rename(picture.with_suffix(".bin"))
    assert run(command) == DONE
    assert set(made) == {kind}
    line = ScoreCalibration.of_card(read_card(file))
    assert line(np.array([0.1, 0.05])) == pytest.approx([0.5, 0.1], abs=0.03)


class Shifted(InTheImage):
    """Half of the real boxes a quarter of their width too far right: an overlap of 0.6."""

    def detect(self, frame: SensorFrame) -> Boxes3D:
        found = super().detect(frame)
        assert found.box2d is not None
        moved = found.box2d + (int(frame.id) % 4 == 1) * np.array([7, 0, 7, 0])
        return image_boxes(moved, found.score, found.category.tolist())


def test_the_easier_overlap_in_images_is_a_half(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(weights_calibrate, "make", lambda kind, what: Shifted())
    file = tmp_path / "small.safetensors"
    names = ("Car_2d_ap11", "Car_2d_ap11_iou50")
    save_weights(file, nn.Linear(1, 1), ModelCard("yolo", metrics=dict.fromkeys(names, 1.0)))
    assert run(["weights", "calibrate", str(file), "--kitti", str(frames)]) == DONE
    card = read_card(file)
    assert card is not None
    # A quarter and a half of the 40 surer boxes: recalls 0 and 0.1, and 0 to 0.2 of eleven.
    low, high = (card.metrics[name] for name in names)
    assert 100 * 2 * 0.25 / 11 - 1 < low < 7 < 100 * 3 * 0.5 / 11 - 1 < high


def test_weights_without_a_card_are_refused(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "psmnet.safetensors"
    save_weights(file, nn.Linear(1, 1), ModelCard("psmnet"))
    assert run(["weights", "calibrate", str(file), "--kitti", str(frames)]) == BAD_DATA
    assert "no weights of a detector" in capsys.readouterr().err
