from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.detections import DetectionFolder, above, default_score_threshold

LINE = "Car -1 -1 0 217.9 184.4 276.4 209.9 1.51 1.62 4.09 -23.3 2.28 46.5 1.6 {score} \n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for id, scores in (("000001", [0.9, 0.1]), ("000004", []), ("000002", [0.5])):
        lines = "".join(LINE.format(score=score) for score in scores)
        (tmp_path / f"{id}.txt").write_text(lines + "\n")
    (tmp_path / "summary.txt").write_text("no result file\n")
    return tmp_path


def test_missing_frames_are_empty_and_reported(folder: Path) -> None:
    found, missing = DetectionFolder(folder).read(["000002", "000007", "000001", "000004"])
    assert list(found) == ["000002", "000007", "000001", "000004"]
    assert [len(boxes) for boxes in found.values()] == [1, 0, 2, 0]
    assert missing == ["000007"]


def test_everything_is_read_where_nothing_is_named(folder: Path) -> None:
    detections = DetectionFolder(folder)
    assert detections.ids() == ["000001", "000002", "000004"]
    found, missing = detections.read()
    assert list(found) == detections.ids()
    assert missing == []


def test_results_may_lie_in_data(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    above_it = tmp_path_factory.mktemp("run")
    (above_it / "data").symlink_to(folder)
    assert len(DetectionFolder(above_it).read(["000001"])[0]["000001"]) == 2


def test_nothing_is_never_evaluated_silently(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="None of the 2 frames"):
        DetectionFolder(folder).read(["000007", "000008"])
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "summary.txt").write_text("")
    with pytest.raises(DataError, match="no result files") as caught:
        DetectionFolder(tmp_path / "other")
    assert "000107.txt" in caught.value.remedy
    with pytest.raises(DataError, match="no such folder"):
        DetectionFolder(tmp_path / "absent")


def test_extra_columns_are_named(folder: Path) -> None:
    (folder / "000002.txt").write_text(LINE.format(score=1) + LINE.format(score="0.5 7"))
    with pytest.raises(DataError, match=r"000002\.txt:2: .* has 17\."):
        DetectionFolder(folder).read(["000001", "000002"])


def test_thresholds(folder: Path) -> None:
    boxes = DetectionFolder(folder).read(["000001"])[0]["000001"]
    assert above(boxes, 0.3).score.tolist() == [0.9]
    assert len(above(boxes, 0.1)) == 2
    assert default_score_threshold([0.0, 1.0]) == 0.3
    assert default_score_threshold([]) == 0.3
    assert default_score_threshold([0.5, 1.01]) == 0
    assert default_score_threshold([-0.01]) == 0


def test_a_real_detectors_results(shared: Path) -> None:
    found, missing = DetectionFolder(shared / "detections/point_gnn").read()
    assert (len(found), missing) == (600, [])
    assert sum(map(len, found.values())) == 2520
    assert sum(len(boxes) == 0 for boxes in found.values()) == 45
    scores = np.concatenate([boxes.score for boxes in found.values()])
    assert default_score_threshold(scores) == 0
