"""`avsec attack patch`: a patch, its picture and card, from frames of a folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from torch import Tensor

from avsec_gym import registry
from avsec_gym.attacks.patch_configuration import PatchTraining
from avsec_gym.attacks.patch_files import load_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.commands.attack import AttackPatch
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti import write_calibration, write_labels
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.registry import Kind
from avsec_gym.rig import kitti_rig


class LikesWhite:
    """Takes brightness for ghosts."""

    name = "likes_white"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return Boxes3D.empty()

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        return [Boxes3D.empty() for _ in range(len(batch))]

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        return {"left": -batch.left.mean(), "right": -batch.right.mean()}


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    root = tmp_path / "kitti"
    boxes = Boxes3D(
        [[0, 1.65, 20]], [[1.5, 1.6, 4]], [0.0], [1], ["Car"], box2d=[[500, 150, 600, 220]],
        truncation=[0], occlusion=[0], alpha=[0],
    )  # fmt: skip
    for id in ("000000", "000003"):
        write_calibration(root / "training/calib" / f"{id}.txt", kitti_rig().calibration)
        write_labels(root / "training/label_2" / f"{id}.txt", boxes)
        for camera in (2, 3):
            image = np.random.default_rng(camera).integers(0, 256, (250, 700, 3), np.uint8)
            write_image(root / f"training/image_{camera}" / f"{id}.png", image)
    (root / "ImageSets").mkdir()
    (root / "ImageSets/train.txt").write_text("000000\n000003\n000009\n")
    return root


@pytest.fixture(autouse=True)
def _likes_white(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry._REGISTERED, (Kind.DETECTOR, "likes_white"), LikesWhite)


def test_a_patch_from_a_folder(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "patch"
    command = AttackPatch(
        ("likes_white",), kitti, out, training=PatchTraining(epochs=2, batch=1), json=True
    )
    assert command.run() == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["frames"], told["epochs"], told["steps"]) == (2, 2, 4)
    patch = load_patch(told["patch"])
    assert patch.pixels[:, 20:56, 20:56].min() > 127.5, "white is what the detector likes"
    assert patch.card is not None
    assert patch.card.detectors == {"likes_white": None}
    assert (out / "curves.jsonl").is_file()
    assert (out / "patch.png").is_file()
    with pytest.raises(DataError, match="--resume"):
        command.run()


def test_wrong_arguments(kitti: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="limit"):
        AttackPatch(("likes_white",), kitti, tmp_path, limit=0).run()
    with pytest.raises(ConfigurationError, match="no `losses`"):
        AttackPatch(("oracle",), kitti, tmp_path).run()
    with pytest.raises(DataError, match=r"val\.txt"):
        AttackPatch(("likes_white",), kitti, tmp_path, split="val").run()
