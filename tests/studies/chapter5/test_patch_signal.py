"""Shares of gradients against drawn ones, ghosts away from cars, and the page of a small run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig
from avsec_gym.world.export import default_suite
from studies.chapter5 import patch_signal
from studies.chapter5.patch_signal import NEAR, common_share
from studies.chapter5.patch_signal_page import main as page


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5])
def test_the_common_share_is_that_of_what_was_drawn(share: float) -> None:
    """In places that have a direction in common, and noise across it."""
    random = torch.Generator().manual_seed(3)
    common = torch.randn(4000, generator=random)
    noise = torch.randn(60, 4000, generator=random)
    drawn = share**0.5 * common + (1 - share) ** 0.5 * noise
    sizes = torch.rand(60, 1, generator=random) + 0.1
    assert common_share(drawn * sizes) == pytest.approx(share, abs=0.01)


class CarsEverywhere:
    """A scene whose cars leave little room between them."""

    def __len__(self) -> int:
        return 1

    def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
        images = {camera: np.zeros((375, 1242, 3), np.uint8) for camera in (2, 3)}
        x, z = (axis.ravel() for axis in np.meshgrid(np.arange(-9.0, 10.0, 9.0), [6.0, 12.0, 24.0]))
        location = np.c_[x, np.full(9, 1.65), z]
        dimensions = np.tile([1.5, 1.6, 3.9], (9, 1))
        truth = Boxes3D(location, dimensions, np.zeros(9), np.ones(9), np.array(["Car"] * 9))
        return SensorFrame("000000", kitti_rig().calibration, images), truth

    def description(self) -> dict[str, Any]:
        return {}


def test_no_ghost_could_be_a_real_car() -> None:
    scenes = CarsEverywhere()
    _, truth = scenes[0]
    for seed in range(30):
        away = truth.location - patch_signal._placed(scenes, [seed]).ghost.location
        assert np.hypot(away[:, 0], away[:, 2]).min() > 2 * NEAR


@pytest.mark.slow
def test_a_page_is_made(tmp_path: Path) -> None:
    out = tmp_path / "signal.json"
    few = ["--gradients", "2", "--judged", "1", "--pictures", "1", "--own", "1", "--steps", "3"]
    words = ["--world", str(default_suite("mixed")), *few, "--json", str(out)]
    assert patch_signal.main(words) == 0
    result = json.loads(out.read_text())
    for signal in result["detectors"].values():
        assert signal["own_after"]["loss"] < signal["own_before"]["loss"]
    assert page([str(out), "--out", str(tmp_path / "page.md")]) == 0
    text = (tmp_path / "page.md").read_text()
    assert f"{result['detectors']['stereo_rcnn']['own_after']['loss']:.2f}".lstrip("-") in text
