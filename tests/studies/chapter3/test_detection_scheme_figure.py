"""The picture of the documentation says what the validator says."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.validation.thresholds import Threshold
from studies.chapter3.detection_scheme_figure import draw_detection_scheme, main


def test_what_contradicts_is_red_and_beyond_the_threshold(walls: ModuleType) -> None:
    frame = walls.wall(0, distance=12.0)
    figure = draw_detection_scheme(frame, Threshold(error=0.05), seed=3)
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
