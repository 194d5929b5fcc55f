"""The picture of the documentation says what the validator says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.chapter3.detection_scheme_figure import draw_detection_scheme, main
from avsec_gym.frame import SensorFrame
from avsec_gym.report.scenario_picture import picture_array
from avsec_gym.rig import camera_rig
from avsec_gym.validation.thresholds import Threshold

PLACES = (0.0, 0.56, -0.28, 0.28)
RIG = camera_rig(PLACES, focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))


@pytest.fixture
def wall() -> SensorFrame:
    """Dots 12 m ahead."""
    rng = np.random.default_rng(0)
    dots = rng.integers(0, 200, (120, 300, 1), np.uint8).repeat(3, axis=2)
    starts = [20 + round(200 * place / 12) for place in PLACES]
    images = {camera: dots[:, start : start + 240] for camera, start in enumerate(starts)}
    x, y = np.meshgrid(np.linspace(-7, 7, 150), np.linspace(-3, 3, 40))
    spots = np.stack([x.ravel(), y.ravel(), np.full(x.size, 12.0), np.ones(x.size)], axis=1)
    points = (spots @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame("0", RIG.calibration, images, points)


def test_what_contradicts_is_red_and_beyond_the_threshold(wall: SensorFrame) -> None:
    figure = draw_detection_scheme(wall, Threshold(error=0.05), seed=3)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    clean, attacked = titles[-2:]
    assert clean.startswith("red contradicts: no alarm\nE 0.0 % ≤ 5.0 %")
    assert attacked.startswith("red contradicts: alarm\nE ")
    assert "> 5.0 %" in attacked
    drawn = picture_array(figure).astype(int)
    below = drawn[3 * len(drawn) // 4 :]
    red = (below[..., 0] > below[..., 1] + 60) & (below[..., 0] > below[..., 2] + 60)
    half = red.shape[1] // 2
    assert red[:, :half].sum() == 0
    assert red[:, half:].sum() > 500


def test_an_unknown_frame_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    class Suite:
        def ids(self) -> list[str]:
            return ["000000"]

    monkeypatch.setattr(f"{draw_detection_scheme.__module__}.world_frames", lambda name: Suite())
    assert main(["--out", str(tmp_path), "--frame", "000009"]) == 1
    assert "no frame '000009'" in caplog.text
    assert not list(tmp_path.iterdir())
