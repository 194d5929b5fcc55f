from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti import archives
from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.layouts import KittiLayout

from .conftest import CALIBRATION, write_png
from .test_odometry import odometry_root  # noqa: F401
from .test_tracking_sequences import tracking_root  # noqa: F401


def test_tracking(tracking_root: Path) -> None:  # noqa: F811
    for root in (tracking_root, tracking_root / "training"):
        report = check_data(root, deep=True)
        assert report.layout is KittiLayout.TRACKING
        assert report.ok
        parts = {Path(part.folder).name: part for part in report.parts}
        assert parts["label_02"].objects == {"Car": 4}
        assert parts["image_02"].image_sizes == {"4x3": 3}
        assert parts["velodyne"].files == 2
        assert [gap.examples for gap in report.gaps] == [("0004/000001",)]


def test_what_is_broken_and_what_lacks_in_tracking(tracking_root: Path) -> None:  # noqa: F811
    folder = tracking_root / "training"
    (folder / "oxts" / "0004.txt").write_text("1 2 3\n")
    (folder / "velodyne" / "0004" / "000002.bin").write_bytes(bytes(17))
    for path in (folder / "image_03" / "0004").iterdir():
        path.unlink()
    (folder / "image_03" / "0004").rmdir()
    (folder / "image_03").rmdir()
    report = check_data(tracking_root)
    assert {Path(str(broken.path)).name for broken in report.broken} == {"0004.txt", "000002.bin"}
    notes = "\n".join(report.notes)
    assert "There is no folder training/image_03; data_tracking_image_3.zip brings it." in notes


def test_odometry(odometry_root: Path) -> None:  # noqa: F811
    for root in (odometry_root, odometry_root.parent):
        report = check_data(root, deep=True)
        assert report.layout is KittiLayout.ODOMETRY
        assert report.ok
        assert {Path(part.folder).name: part.files for part in report.parts} == {
            **{f"image_{i}": 2 for i in range(4)},
            "velodyne": 2,
            "calib.txt": 1,
            "times.txt": 1,
            "poses": 1,
        }
        assert not report.gaps
    (odometry_root / "sequences" / "03" / "velodyne" / "000001.bin").unlink()
    (odometry_root / "poses" / "03.txt").write_text("1 0 0\n")
    report = check_data(odometry_root)
    assert [gap.examples for gap in report.gaps] == [("03/000001",)]
    assert [Path(str(broken.path)).name for broken in report.broken] == ["03.txt"]


def test_archives_unzipped_apart_are_to_be_merged(tmp_path: Path) -> None:
    for archive, part, content in (
        ("data_object_calib", "calib/000000.txt", CALIBRATION.encode()),
        ("data_object_image_2", "image_2/000000.png", write_png(4, 3)),
        ("my images", "image_3/000000.png", write_png(4, 3)),
    ):
        path = tmp_path / archive / "training" / part
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
    for root in (tmp_path, tmp_path / "my images"):
        notes = "\n".join(check_data(root).notes)
        assert "data_object_image_2/ has training/image_2; my images/ has training/image_3" in notes
        command = notes.split("`")[-2]
        assert command.startswith("cp -al ")
        assert f"'{tmp_path}/my images'/." in command
    notes = "\n".join(check_data(tmp_path / "data_object_calib").notes)
    assert "There is no folder training/velodyne; data_object_velodyne.zip brings it." in notes


def test_the_command_that_merges_archives_merges_them(tmp_path: Path) -> None:
    import subprocess

    for archive, part in (("a", "calib/0000.txt"), ("b", "label_02/0000.txt")):
        path = tmp_path / archive / "training" / part
        path.parent.mkdir(parents=True)
        path.write_text("")
    command = "\n".join(check_data(tmp_path).notes).split("`")[-2]
    subprocess.run(command, shell=True, check=True)
    assert (tmp_path / "a/training/label_02/0000.txt").is_file()
    assert not any("apart" in note for note in check_data(tmp_path / "a").notes)


def test_sets_of_the_same_parts_are_no_archives(object_root: Path) -> None:
    (object_root.parent / "other/training/label_2").mkdir(parents=True)
    (object_root.parent / "other/training/label_2/000000.txt").write_text("")
    assert not any("apart" in note for note in check_data(object_root.parent).notes)


def test_days_of_raw_unzipped_apart(tmp_path: Path) -> None:
    day = "2011_09_26"
    scan = tmp_path / f"{day}_drive_0005_sync/{day}/{day}_drive_0005_sync/velodyne_points/data"
    scan.mkdir(parents=True)
    calibration = tmp_path / f"{day}_calib" / day / "calib_cam_to_cam.txt"
    calibration.parent.mkdir(parents=True)
    calibration.write_text("")
    notes = "\n".join(check_data(tmp_path).notes)
    assert f"{day}_calib/ has {day}/calib_cam_to_cam.txt" in notes
    assert f"{day}_drive_0005_sync/ has {day}/{day}_drive_0005_sync/velodyne_points" in notes


def test_what_may_not_be_looked_at_beside_it_is_passed_over(
    object_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (object_root.parent / "secret").mkdir()

    def is_folder(path: Path) -> bool:
        if "secret" in path.parts:
            raise DataError("The file cannot be read (Permission denied).", path=path)
        return path.is_dir()

    monkeypatch.setattr(archives, "is_folder", is_folder)
    assert archives.archives_apart(object_root) is None
    assert check_data(object_root).ok
