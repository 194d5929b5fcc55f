"""Measurements are made once; the whole page comes from them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avsec_gym.world.export import make_data_set, suite_recipe
from studies.world import evidence, labels
from studies.world.frames import MeasuredFrames, SuiteScenes, measured, quantiles


def test_quantiles_of_what_is_known() -> None:
    assert quantiles([1.0, None, 3.0]).mean == 2.0
    assert quantiles([None]).p50 is None


def test_real_frames_must_be_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert labels.main(["--frames", "1"]) == 1
    assert not capsys.readouterr().out


@pytest.mark.slow
def test_rows_are_kept_and_more_frames_continue_them(tmp_path: Path) -> None:
    def rows(count: int) -> list[labels.LabelRow]:
        recipe = MeasuredFrames(SuiteScenes(), count, (labels.measure,), images=False)
        return measured(recipe, workers=1, rows=tmp_path).of(labels.measure)

    first = rows(1)
    (folder,) = tmp_path.iterdir()
    written = (folder / "000000.json").stat().st_mtime_ns
    assert rows(2)[:1] == first
    assert (folder / "000000.json").stat().st_mtime_ns == written


@pytest.mark.slow
def test_the_page_is_made_from_few_frames(tmp_path: Path) -> None:
    """A procedural suite stands in for KITTI: both are then alike."""
    kitti = tmp_path / "kitti"
    make_data_set(suite_recipe("mixed", 2, seed=1), kitti, workers=1)
    out = tmp_path / "out"
    numbers = ["--frames", "1", "--labels", "2", "--checks", "1", "--twins", "1", "--workers", "1"]
    places = ["--rows", str(tmp_path / "rows"), "--out", str(out), "--images", str(out)]
    target = out / "world.json"
    arguments = ["--kitti", str(kitti), *numbers, *places, "--json", str(target)]
    assert evidence.main(arguments) == 0
    result = json.loads(target.read_text())
    assert result["stereo"]["frames"] == 1
    # Lasers stand above the cameras and look over things: 95.8 % of many frames agree.
    assert result["scans"]["depth"]["agree"] > 0.94
    assert result["scans"]["boxes"]["inside"] > 0.999
    text = (out / "world.md").read_text()
    for title in ("Stereo matching", "LiDAR", "Images", "Labels", "Occlusion levels"):
        assert f"## {title}" in text
    for name in ("world_stereo", "world_scans", "world_labels"):
        assert (out / f"{name}.png").stat().st_size > 10_000
