from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.layouts import KittiLayout


def test_what_is_there(object_root: Path) -> None:
    steps: list[tuple[int, int]] = []
    report = check_data(object_root, on_progress=lambda *step: steps.append(step))
    assert report.ok
    assert report.layout is KittiLayout.OBJECT
    parts = {part.folder: part for part in report.parts}
    assert parts["training/label_2"].objects == {"Car": 2, "DontCare": 2, "Van": 2}
    assert parts["training/image_2"].image_sizes == {"4x3": 2}
    assert parts["training/velodyne"].files == 1
    assert steps == [(i, 10) for i in range(1, 11)]
    assert json.loads(json.dumps(report.to_json()))["layout"] == "object"


def test_what_is_missing(object_root: Path) -> None:
    (object_root / "training" / "calib" / "000003.txt").unlink()
    gaps = {(gap.has, gap.lacks): gap for gap in check_data(object_root).gaps}
    assert gaps["training/label_2", "training/calib"].examples == ("000003",)
    assert ("training/image_2", "training/velodyne") in gaps
    assert "such as 000003" in str(gaps["training/image_2", "training/image_3"])


def test_what_is_broken_and_it_goes_on(object_root: Path, png: Callable[..., bytes]) -> None:
    folder = object_root / "training"
    (folder / "label_2" / "000000.txt").write_text("Car 0.00 1\n")
    (folder / "calib" / "000000.txt").write_text("")
    (folder / "image_2" / "000003.png").write_bytes(png(4, 3)[:-5])
    (folder / "image_3" / "000000.png").write_bytes(png(5, 3))
    (folder / "velodyne" / "000000.bin").write_bytes(bytes(17))
    (object_root / "ImageSets" / "val.txt").write_text("000003\n000003\n")
    (folder / "label_2" / ".DS_Store").write_text("")
    report = check_data(object_root)
    assert not report.ok
    names = sorted(Path(str(broken.path)).relative_to(object_root) for broken in report.broken)
    assert [str(name) for name in names] == [
        "ImageSets/val.txt",
        "training/calib/000000.txt",
        "training/image_2/000003.png",
        "training/image_3/000000.png",
        "training/label_2/000000.txt",
        "training/velodyne/000000.bin",
    ]
    assert all(broken.remedy for broken in report.broken)
    assert any(":1: " in str(broken) for broken in report.broken)
    assert any(".DS_Store" in note for note in report.notes)
    json.dumps(report.to_json())


def test_deep_reads_the_pixels(object_root: Path) -> None:
    path = object_root / "training" / "image_2" / "000000.png"
    content = bytearray(path.read_bytes())
    content[45] ^= 255
    path.write_bytes(content)
    assert check_data(object_root).ok
    assert [b.path for b in check_data(object_root, deep=True).broken] == [str(path)]


def test_a_result_folder(tmp_path: Path) -> None:
    line = "Car -1 -1 0 217.9 184.4 276.4 209.9 1.51 1.62 4.09 -23.3 2.28 46.5 1.6 0.5"
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "000001.txt").write_text("\n")
    (tmp_path / "data" / "000002.txt").write_text(line)
    (tmp_path / "data" / "000003.txt").write_text(line + " 7")
    report = check_data(tmp_path)
    assert report.layout is KittiLayout.DETECTIONS
    assert report.parts[0].files == 3
    assert report.parts[0].objects == {"Car": 1}
    assert [broken.line for broken in report.broken] == [1]


def test_a_label_folder_is_told_from_results(object_root: Path) -> None:
    report = check_data(object_root / "training" / "label_2")
    assert report.layout is KittiLayout.LABELS
    assert report.ok


def test_a_testing_half_needs_no_labels(object_root: Path) -> None:
    (object_root / "training").rename(object_root / "testing")
    report = check_data(object_root)
    assert not any("label_2" in gap.lacks for gap in report.gaps)
    assert {part.folder.split("/")[0] for part in report.parts} == {"testing"}


def test_tracking_labels(tmp_path: Path) -> None:
    line = "0 1 Car 0 0 -1.8 10 20 30 40 1.5 1.6 4.0 2.0 1.5 20.0 -1.6\n"
    folder = tmp_path / "training" / "label_02"
    folder.mkdir(parents=True)
    (folder / "0000.txt").write_text(line + "1" + line[1:])
    (folder / "0001.txt").write_text(line + line)
    (folder / "readme.txt").write_text("mine")
    for root in (tmp_path, tmp_path / "training", folder):
        report = check_data(root)
        assert report.layout is KittiLayout.TRACKING
        assert [(part.files, part.broken, part.objects) for part in report.parts] == [
            (2, 1, {"Car": 2})
        ]
        assert [broken.line for broken in report.broken] == [2]
        assert any("'readme.txt'" in note for note in report.notes)


@pytest.mark.parametrize(
    ("name", "layout"),
    [
        ("my drive/oxts/data/0000000000.txt", KittiLayout.UNKNOWN),
        ("training/disp_occ_0/000000_10.png", KittiLayout.STEREO),
        ("photos/cat.png", KittiLayout.UNKNOWN),
    ],
)
def test_other_layouts_are_recognised(tmp_path: Path, name: str, layout: KittiLayout) -> None:
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).touch()
    report = check_data(tmp_path)
    assert report.layout is layout
    assert not report.ok
    assert report.notes[0] == layout.description


def test_the_folder_above_is_put_right(object_root: Path) -> None:
    report = check_data(object_root.parent)
    assert report.layout is KittiLayout.UNKNOWN
    assert any("object/" in note for note in report.notes)
    with pytest.raises(DataError, match="no such folder"):
        check_data(object_root / "absent")


def test_empty_folders_are_not_ok(tmp_path: Path) -> None:
    assert not check_data(tmp_path).ok
    (tmp_path / "training" / "label_2").mkdir(parents=True)
    report = check_data(tmp_path)
    assert not report.ok
    assert "training/label_2 holds no frames." in report.notes


@pytest.mark.slow
def test_real_data(shared: Path) -> None:
    report = check_data(shared / "kitti/object", deep=True)
    assert report.ok
    assert {part.folder: part.files for part in report.parts}["training/calib"] == 7481
    kitti = shared / "kitti"
    notes = check_data(kitti).notes
    for name in ("object", "raw", "tracking"):
        assert f"Its subfolder {name}/ has the {name} layout: name that." in notes
    assert check_data(shared / "detections/point_gnn").parts[0].objects == {"Car": 2520}


@pytest.mark.parametrize(
    ("entry", "value", "fault"),
    [(3, 400.0, "to the left of camera 2"), (0, 900.0, "rectified pair"), (2, 7.0, "rectified")],
)
def test_cameras_2_and_3_are_a_pair(
    object_root: Path, entry: int, value: float, fault: str
) -> None:
    """Unless there are no pictures of one of them."""
    path = object_root / "training" / "calib" / "000003.txt"
    lines = path.read_text().splitlines()
    number = next(i for i, line in enumerate(lines) if line.startswith("P3:"))
    words = lines[number].split()
    words[entry + 1] = str(value)
    lines[number] = " ".join(words)
    path.write_text("\n".join(lines))
    (broken,) = check_data(object_root).broken
    assert fault in str(broken)
    assert str(broken).startswith(str(path))
    shutil.rmtree(object_root / "training" / "image_3")
    assert check_data(object_root).ok
