"""`avsec disparity`: maps of known errors, estimators on real pairs, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.cli import run
from avsec_gym.kitti.map_files import read_disparity, write_disparity
from avsec_gym.kitti.stereo import LAYOUTS
from tests.kitti.test_stereo import make_stereo


def answer(words: list[object], capsys: pytest.CaptureFixture[str], code: int = 0) -> dict:
    assert run(["disparity", *map(str, words), "--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.name)
def test_maps_of_others(tmp_path: Path, layout, capsys: pytest.CaptureFixture[str]) -> None:
    make_stereo(tmp_path / "kitti", layout)
    found = np.full((3, 4), 7.5, np.float32)
    found[0, 1] = 11.5  # 4 px off: wrong by both rules.
    found[0, 2] = np.nan  # A hole becomes the smaller one of its neighbours, 7.5.
    write_disparity(tmp_path / "mine/000000_10.png", found)
    words = ["--kitti", tmp_path / "kitti", "--disparities", tmp_path / "mine"]
    result = answer(words, capsys)
    assert result["pairs"] == 1
    assert result["truth"] == layout.truth["occ"]
    mine = result["estimators"]["mine"]
    assert mine["density"]["value"] == pytest.approx(10 / 11, abs=1e-5)
    assert mine["found"]["end_point_error"]["value"] == pytest.approx(4 / 10)
    assert mine["all"]["d1"]["value"] == pytest.approx(1 / 11, abs=1e-5)
    assert run(["disparity", *map(str, words)]) == 0
    assert "9.09" in capsys.readouterr().out


def test_what_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make_stereo(tmp_path / "kitti", LAYOUTS[1])
    assert run(["disparity", "--kitti", str(tmp_path / "kitti"), "--truth", "noc"]) == 1
    assert "disp_noc_0/" in capsys.readouterr().err
    assert run(["disparity", "--kitti", str(tmp_path / "kitti"), "--depth", "sgmb"]) == 2
    assert "sgbm" in capsys.readouterr().err
    (tmp_path / "object/training/image_2").mkdir(parents=True)
    (tmp_path / "object/training/image_2/000000.png").touch()
    for kind in ("image_3", "calib"):
        (tmp_path / "object/training" / kind).mkdir()
    words = ["--kitti", str(tmp_path / "object"), "--depth", "sgbm"]
    assert run(["disparity", *words]) == 1
    assert "disparity_2/" in capsys.readouterr().err
    write_disparity(tmp_path / "small/000000_10.png", np.ones((2, 2), np.float32))
    words = ["--kitti", str(tmp_path / "kitti"), "--disparities", str(tmp_path / "small")]
    assert run(["disparity", *words]) == 1
    assert "2x2 pixels, the truth 4x3" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["stereo2012", "stereo2015"])
def test_matching_on_a_real_pair(
    name: str, shared: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = shared / "kitti" / name
    result = answer(["--kitti", root, "--depth", "sgbm"], capsys)
    sgbm = result["estimators"]["sgbm"]
    # By hand, of the pixels that were found: no code shared but the matching.
    from avsec_gym.kitti.stereo import KittiStereo
    from avsec_gym.perception.depth import make_depth

    data = KittiStereo(root)
    found = make_depth("sgbm").disparity(data.frame("000000_10")).values
    truth = read_disparity(next((root / "training").glob("disp_occ*/000000_10.png")))
    with np.errstate(invalid="ignore"):
        error = np.abs(found - truth)
        wrong = (error > 3) & (error > 0.05 * truth)
    both = np.isfinite(error)
    assert sgbm["found"]["d1"]["value"] == pytest.approx(wrong.sum() / both.sum(), abs=1e-5)
    assert sgbm["found"]["end_point_error"]["value"] == pytest.approx(error[both].mean(), abs=1e-4)
    assert sgbm["found"]["d1"]["value"] < sgbm["all"]["d1"]["value"] < 0.3
