from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import box_corners, project, transform_points
from avsec_gym.kitti.dataset import KittiObject


def test_a_frame_has_what_is_there(object_root: Path) -> None:
    frame = KittiObject(object_root).frame("000000")
    assert sorted(frame.images) == [2, 3]
    assert frame.image(2).shape == (3, 4, 3)
    assert frame.image(3) is frame.images[3]
    assert frame.points.shape == (10, 4)
    assert frame.stereo().baseline == pytest.approx(0.54)
    assert [earlier.id for earlier in frame.previous] == ["000000_01"]
    assert frame.previous[0].image(3)[2, 3, 2] == 35
    assert not frame.previous[0].has_points


def test_what_is_not_there_is_named(object_root: Path) -> None:
    data = KittiObject(object_root)
    frame = data.frame("000003")
    with pytest.raises(DataError, match=r"no image of camera 3.*image_3/"):
        frame.stereo()
    with pytest.raises(DataError, match=r"no LiDAR scan.*velodyne/"):
        _ = frame.points
    for ask in (data.labels, data.calibration, data.frame):
        with pytest.raises(DataError, match=r"000005\.txt: .*(label_2|calib)/\."):
            ask("000005")
    with pytest.raises(DataError, match=r"ImageSets/train\.txt"):
        data.ids("train")
    with pytest.raises(DataError, match="image_0"):
        data.ids(having=["image_0"])
    with pytest.raises(DataError, match="mapping/"):
        data.raw_origin("000000")
    assert data.drives_of(["000000"]) is None
    for id in ("3", "../000000", 3, "00000٣"):
        with pytest.raises(ConfigurationError):
            data.labels(id)  # type: ignore[arg-type]


def test_ids(object_root: Path) -> None:
    for root in (object_root, object_root / "training"):
        data = KittiObject(root)
        assert data.ids() == ["000000", "000003"]
        assert data.ids("val") == ["000003", "000000"]
        assert data.ids("val", having=["image_2", "velodyne"]) == ["000000"]
        assert len(data.labels("000000")) == 2
        assert len(data.labels("000000", keep_dont_care=True)) == 3


def test_partial_data_is_fine_until_asked(object_root: Path) -> None:
    for name in ("label_2", "image_2", "image_3", "velodyne", "prev_2", "prev_3"):
        shutil.rmtree(object_root / "training" / name)
    data = KittiObject(object_root)
    assert data.ids() == ["000000", "000003"]
    assert not data.frame("000000").images


def test_other_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "image_02" / "data").mkdir(parents=True)  # KITTI raw
    for root, message in ((tmp_path, "Nothing of the KITTI"), (tmp_path / "x", "no such folder")):
        with pytest.raises(DataError, match=message):
            KittiObject(root)
    (tmp_path / "label_2").mkdir()
    with pytest.raises(DataError, match="six digits"):
        KittiObject(tmp_path).ids()


def test_broken_files_are_found_when_they_are_read(
    object_root: Path, png: Callable[..., bytes]
) -> None:
    folder = object_root / "training"
    (folder / "image_3" / "000000.png").write_bytes(png(5, 3))
    (folder / "velodyne" / "000000.bin").write_bytes(bytes(15))
    frame = KittiObject(object_root).frame("000000")
    with pytest.raises(DataError, match=r"image_3.000000\.png: .*4 x 3 pixels, camera 3 5 x 3"):
        frame.stereo()
    with pytest.raises(DataError, match=r"000000\.bin"):
        _ = frame.points


def test_a_real_frame_is_consistent(shared: Path) -> None:
    """Labelled boxes project into their 2D boxes, and hold points of the scan."""
    data = KittiObject(shared / "kitti/object")
    frame, boxes = data.frame("000107"), data.labels("000107")
    assert len(boxes) == 8
    height, width, _ = frame.stereo().left.shape
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    pixels, _ = project(frame.calibration.projection(2), corners)
    assert boxes.box2d is not None
    whole = boxes.truncation == 0
    for low, high, limit in ((0, 2, width), (1, 3, height)):
        seen = np.clip(pixels[whole, :, low], 0, limit - 1)
        np.testing.assert_allclose(seen.min(axis=1), boxes.box2d[whole, low], atol=8)
        np.testing.assert_allclose(seen.max(axis=1), boxes.box2d[whole, high], atol=8)
    points = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
    near = np.linalg.norm(points[None] - corners.mean(axis=1)[:, None], axis=-1) < 2.5
    assert (near.sum(axis=1)[:5] > 50).all()


def test_the_latest_frame_before_comes_first(shared: Path) -> None:
    frame = KittiObject(shared / "kitti/object").frame("000274")
    assert [earlier.id for earlier in frame.previous] == ["000274_01", "000274_02", "000274_03"]
    now = frame.image().astype(float)
    changes = [np.abs(earlier.image() - now).mean() for earlier in frame.previous]
    assert changes == sorted(changes)


def test_real_ids_and_origins(shared: Path) -> None:
    data = KittiObject(shared / "kitti/object/training")
    assert len(data.ids()) == 7481
    assert data.ids(having=["image_2", "image_3", "velodyne", "label_2"]) == ["000107"]
    assert len(data.ids("val")) == 3769
    assert data.raw_origin("000000").frame == 48
    drives = data.drives_of(data.ids("val"))
    assert drives is not None
    assert drives[0] == data.raw_origin(data.ids("val")[0]).folder
    assert 40 < len(set(drives)) < 100
    assert data.drives_of(["000000", "009999"]) is None
