from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.kitti.sensor_files import read_image, read_points, write_image, write_points
from avsec_gym.kitti.writing import write_object_frame, write_raw_frame
from avsec_gym.storage import atomic_write

COLOUR = np.random.default_rng(0).integers(0, 255, (6, 9, 3), np.uint8)
GREY = np.repeat(COLOUR[..., :1], 3, axis=2)


def test_images_come_back(tmp_path: Path) -> None:
    for compression in (0, 1, 9):
        path = tmp_path / f"{compression}.png"
        write_image(path, COLOUR, compression=compression)
        np.testing.assert_array_equal(read_image(path), COLOUR)
        with Pillow.open(path) as theirs:
            np.testing.assert_array_equal(np.asarray(theirs), COLOUR)
    write_image(tmp_path / "grey.png", GREY, grey=True)
    with Pillow.open(tmp_path / "grey.png") as theirs:
        assert theirs.mode == "L"
    np.testing.assert_array_equal(read_image(tmp_path / "grey.png"), GREY)
    write_image(tmp_path / "again.png", COLOUR)
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "1.png").read_bytes()


def test_a_view_of_an_image_is_written_as_it_is_seen(tmp_path: Path) -> None:
    write_image(tmp_path / "view.png", COLOUR[::-1, ::2])
    np.testing.assert_array_equal(read_image(tmp_path / "view.png"), COLOUR[::-1, ::2])


def test_scans_come_back(tmp_path: Path) -> None:
    points = np.random.default_rng(1).uniform(0, 1, (30, 4)).astype(np.float32)
    write_points(tmp_path / "a.bin", points)
    np.testing.assert_array_equal(read_points(tmp_path / "a.bin"), points)
    assert (tmp_path / "a.bin").stat().st_size == 30 * 16


def test_what_cannot_be_read_is_not_written(tmp_path: Path) -> None:
    for image in (COLOUR[..., 0], COLOUR.astype(float), COLOUR[:0], COLOUR[..., :2]):
        with pytest.raises(ConfigurationError):
            write_image(tmp_path / "a.png", image)
    with pytest.raises(ConfigurationError, match="0 to 9"):
        write_image(tmp_path / "a.png", COLOUR, compression=10)
    for points in (np.zeros((0, 4)), np.zeros((3, 3)), np.full((1, 4), np.nan), [[0, 0, 1e9, 0]]):
        with pytest.raises(ConfigurationError):
            write_points(tmp_path / "a.bin", np.asarray(points, np.float32))
    assert not list(tmp_path.iterdir())


def test_nothing_is_overwritten_unasked_or_left_half(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.png"
    write_image(path, COLOUR)
    before = path.read_bytes()
    with pytest.raises(DataError, match="exists"):
        write_image(path, GREY)

    def fail(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(atomic_write.os, "replace", fail)
    with pytest.raises(DataError, match=r"a\.png: .*no space left"):
        write_image(path, GREY, overwrite=True)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.png"]


def test_an_object_frame_goes_round(object_root: Path, tmp_path: Path) -> None:
    given = KittiObject(object_root)
    target = tmp_path / "copy" / "training"
    for id in given.ids():
        write_object_frame(target, given.frame(id), given.labels(id, keep_dont_care=True))
    for path in sorted((object_root / "training").rglob("*.txt")):
        if path.parent.name == "label_2":
            copy = target / path.relative_to(object_root / "training")
            assert copy.read_bytes() == path.read_bytes()
    copied = KittiObject(target.parent)
    assert copied.ids() == given.ids()
    for id in given.ids():
        one, two = given.frame(id), copied.frame(id)
        np.testing.assert_array_equal(two.calibration.projections, one.calibration.projections)
        assert sorted(two.images) == sorted(one.images)
        assert two.has_points == one.has_points
        assert [earlier.id for earlier in two.previous] == [earlier.id for earlier in one.previous]
        np.testing.assert_array_equal(two.image(), one.image())
    with pytest.raises(DataError, match="exists"):
        write_object_frame(target, given.frame("000000"))
    with pytest.raises(ConfigurationError, match="six digits"):
        write_object_frame(target, replace(given.frame("000000"), id="7"))


def test_the_label_comes_last(object_root: Path, tmp_path: Path) -> None:
    """A frame whose calibration cannot be written has no label."""
    data = KittiObject(object_root)
    (tmp_path / "training").mkdir()
    (tmp_path / "training" / "calib").write_text("a file where a folder should be")
    with pytest.raises(DataError, match="calib"):
        write_object_frame(tmp_path / "training", data.frame("000000"), data.labels("000000"))
    assert not (tmp_path / "training" / "label_2").exists()


def test_cameras_0_and_1_are_grey_in_the_files(tmp_path: Path, rig: Calibration) -> None:
    drive = tmp_path / "2026_01_01" / "2026_01_01_drive_0000_sync"
    frame = SensorFrame("000000", rig, {0: GREY, 1: COLOUR, 2: COLOUR, 4: COLOUR})
    write_raw_frame(drive, 0, frame)
    write_object_frame(tmp_path / "training", frame)
    for template in (
        drive / "image_{:02d}/data/0000000000.png",
        tmp_path / "training/image_{}/000000.png",
    ):
        modes = []
        for camera in (0, 1, 2, 4):
            with Pillow.open(str(template).format(camera)) as image:
                modes.append(image.mode)
        assert modes == ["L", "L", "RGB", "RGB"]
    assert KittiRaw(tmp_path).drive("0000").frames(["image_04"]) == [0]
    with pytest.raises(ConfigurationError):
        write_raw_frame(drive, -1, frame)
