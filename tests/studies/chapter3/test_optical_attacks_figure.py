"""The picture of the documentation: drawn, and a missing data set is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig
from studies.chapter3.optical_attacks_figure import draw_optical_attacks, main


def test_it_shows_attacks() -> None:
    random = np.random.default_rng(0)
    scan = random.uniform((4, -9, -1.7, 0), (30, 9, 2, 1), (500, 4)).astype(np.float32)
    images = {2: np.full((375, 1242, 3), (60, 61, 60), np.uint8)}
    frame = SensorFrame("0", kitti_rig().calibration, images, scan)
    drawn = picture_array(draw_optical_attacks(frame)).astype(int)
    red, green, blue = drawn[..., 0], drawn[..., 1], drawn[..., 2]
    assert ((green > red + 80) & (green > blue + 80)).sum() > 500
    assert ((red > green + 80) & (red > blue + 80)).sum() > 500


def test_no_data_is_an_error(tmp_path: Path) -> None:
    assert main(["--kitti", str(tmp_path / "nowhere"), "--out", str(tmp_path)]) == 1
    assert not list(tmp_path.iterdir())
