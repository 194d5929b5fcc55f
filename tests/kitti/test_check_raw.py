from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.layouts import KittiLayout

DATE, DRIVE = "2026_01_01", "2026_01_01_drive_0007_sync"


def test_what_is_there(raw_root: Path) -> None:
    steps: list[tuple[int, int]] = []
    report = check_data(raw_root, deep=True, on_progress=lambda *step: steps.append(step))
    assert report.ok
    assert report.layout is KittiLayout.RAW
    assert not report.gaps
    parts = {part.folder: part for part in report.parts}
    assert parts[DATE].files == 3
    assert parts[f"{DATE}/{DRIVE}/image_04/data"].image_sizes == {"12x8": 4}
    assert parts[f"{DATE}/{DRIVE}"].objects == {"Car": 1}
    assert steps[-1] == (35, 35)
    assert json.loads(json.dumps(report.to_json()))["layout"] == "raw"
    assert check_data(raw_root / DATE).ok
    assert [part.folder for part in check_data(raw_root / DATE / DRIVE).parts][:2] == [
        DATE,
        "image_00/data",
    ]


def test_what_is_missing_is_no_fault(raw_root: Path) -> None:
    folder = raw_root / DATE / DRIVE
    for name in ("oxts", "image_03"):
        shutil.rmtree(folder / name)
    (folder / "tracklet_labels.xml").unlink()
    (folder / "velodyne_points" / "data" / "0000000001.bin").unlink()
    (raw_root / DATE / "calib_imu_to_velo.txt").unlink()
    (raw_root / DATE / "2026_01_01_drive_0008_extract").mkdir()
    (folder / "image_02" / "data" / "Thumbs.db").touch()
    report = check_data(raw_root)
    assert report.ok
    assert [str(gap) for gap in report.gaps] == [
        f"1 frames have {DATE}/{DRIVE}/image_02 but no {DATE}/{DRIVE}/velodyne_points, "
        "such as 0000000001"
    ]
    notes = "\n".join(report.notes)
    for note in (
        f"{DRIVE} has no image_03, oxts: no stereo pairs, no speeds or poses.",
        f"{DRIVE} has no timestamps of image_00, image_01, image_04.",
        f"{DRIVE} has no tracklet_labels.xml",
        "velodyne_points has 3 of the 4 frames from 0 to 3",
        f"{DATE} has no calib_imu_to_velo.txt",
        "0008_extract holds unrectified data",
        "'Thumbs.db'",
    ):
        assert note in notes
    (raw_root / DATE / "calib_velo_to_cam.txt").unlink()
    report = check_data(raw_root)
    assert report.ok
    assert any("frames cannot be loaded" in note for note in report.notes)
    shutil.rmtree(folder)
    assert any("There is no drive" in note for note in check_data(raw_root).notes)


def test_object_data_beside_the_dates_are_noted(raw_root: Path) -> None:
    (raw_root / "training" / "label_2").mkdir(parents=True)
    report = check_data(raw_root)
    assert report.layout is KittiLayout.RAW
    assert any("training/ has the object layout" in note for note in report.notes)


def test_what_is_broken_and_it_goes_on(raw_root: Path, png: Callable[..., bytes]) -> None:
    folder = raw_root / DATE / DRIVE
    for name, content in (
        ("../calib_velo_to_cam.txt", b"R: 1 2 3\n"),
        ("image_02/data/0000000001.png", b""),
        ("image_03/data/0000000002.png", png(5, 3)),
        ("oxts/data/0000000001.txt", b"1 2 3\n"),
        ("oxts/timestamps.txt", b"2026-01-01 12:00:00.0\n"),
        ("tracklet_labels.xml", b"<a>"),
        ("velodyne_points/data/0000000003.bin", bytes(17)),
    ):
        (folder / name).resolve().write_bytes(content)
    report = check_data(raw_root)
    assert not report.ok
    found = sorted(Path(str(broken.path)).name for broken in report.broken)
    assert found == [
        "0000000001.png",
        "0000000001.txt",
        "0000000002.png",
        "0000000003.bin",
        "calib_velo_to_cam.txt",
        "timestamps.txt",
        "tracklet_labels.xml",
    ]
    assert all(broken.remedy for broken in report.broken)
    assert any("1 times, but the last frame is 3" in broken.problem for broken in report.broken)


def test_the_real_partial_drive(shared: Path) -> None:
    report = check_data(shared / "kitti/raw", deep=True)
    assert report.ok
    gaps = {(gap.has[-8:], gap.lacks[-8:]): gap.frames for gap in report.gaps}
    assert gaps == {("image_02", "e_points"): 2, ("e_points", "image_02"): 4}
    assert any("0052_sync has no image_00, image_01, image_03, oxts" in n for n in report.notes)
