"""Result files are found below the folder that a user names, if there is but one place."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.kitti import result_place
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.kitti.labels import write_detections
from avsec_gym.kitti.result_place import result_folder

OPENPCDET = "kitti_models/pointpillar/default/eval/epoch_80/val/default/final_result/data"
"""Below its folder `output`."""


def results(folder: Path) -> Path:
    write_detections(folder / "000107.txt", Boxes3D.empty())
    return folder


def test_openpcdets_results_are_found_from_every_folder_above(tmp_path: Path) -> None:
    place = results(tmp_path / OPENPCDET)
    # What it leaves beside them.
    (place.parents[1] / "result.pkl").write_bytes(b"")
    (place.parents[1] / "log_eval_20261123.txt").write_text("an epoch\n")
    (place.parents[5] / "ckpt").mkdir()
    above = place
    while above != tmp_path.parent:
        assert result_folder(above) == place
        assert DetectionFolder(above).ids() == ["000107"]
        above = above.parent


def test_a_folders_own_files_win_and_then_those_of_its_data(tmp_path: Path) -> None:
    results(tmp_path / "old" / "run")
    data = results(tmp_path / "data")
    results(tmp_path / "data" / "earlier")
    assert result_folder(tmp_path) == data
    results(tmp_path)
    assert result_folder(tmp_path) == tmp_path


def test_of_several_candidates_none_is_guessed(tmp_path: Path) -> None:
    names = [f"epoch_{number}/final_result/data" for number in range(1, 8)]
    for name in names:
        results(tmp_path / name)
    with pytest.raises(DataError, match="7 folders below hold result files") as error:
        result_folder(tmp_path)
    assert all(name in str(error.value) for name in names[:5])
    assert "and 2 more" in str(error.value)
    assert "Name one of them" in str(error.value)
    assert result_folder(tmp_path / "epoch_2") == tmp_path / names[1]


def test_a_search_has_bounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    deep = results(tmp_path.joinpath(*"abcdefghijk"))
    assert result_folder(tmp_path / "a") == deep
    with pytest.raises(DataError, match="holds no result files"):
        result_folder(tmp_path)
    wide = tmp_path / "wide"
    for number in range(20):
        (wide / f"{number}").mkdir(parents=True)
    monkeypatch.setattr(result_place, "_MOST_FOLDERS", 10)
    with pytest.raises(DataError, match="more than 10 folders are"):
        result_folder(wide)


def test_links_are_not_followed(tmp_path: Path) -> None:
    results(tmp_path / "elsewhere")
    root = tmp_path / "root"
    root.mkdir()
    (root / "up").symlink_to(tmp_path)
    with pytest.raises(DataError, match="holds no result files"):
        result_folder(root)


def test_nothing_there(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="holds no result files") as error:
        result_folder(tmp_path)
    assert str(tmp_path) in str(error.value)
    with pytest.raises(DataError, match="no such folder"):
        result_folder(tmp_path / "gone")
