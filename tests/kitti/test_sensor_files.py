from __future__ import annotations

import pickle
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.sensor_files import (
    ImageFile,
    ScanFile,
    check_scan_size,
    read_image,
    read_image_size,
    read_points,
)

Png = Callable[..., bytes]


def test_an_image_is_red_green_blue(tmp_path: Path, png: Png) -> None:
    path = tmp_path / "image.png"
    path.write_bytes(png(4, 3, bytes(range(36))))
    image = read_image(path)
    assert image.dtype == np.uint8
    np.testing.assert_array_equal(image, np.arange(36).reshape(3, 4, 3))
    assert read_image_size(path) == (4, 3)
    again = pickle.loads(pickle.dumps(ImageFile(path)))
    np.testing.assert_array_equal(again(), image)


def _flip(content: bytes, position: int) -> bytes:
    return content[:position] + bytes([content[position] ^ 255]) + content[position + 1 :]


def _claiming(png: Png, width: int, height: int) -> bytes:
    """A PNG bomb: a tiny file whose valid header claims a huge image."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    content = png(1, 1)
    return content[:12] + header + struct.pack(">I", zlib.crc32(header)) + content[33:]


BROKEN_IMAGES = {
    "empty": (lambda _: b"", "empty", True),
    "not a PNG": (lambda _: b"\xff\xd8\xff\xe0" + bytes(100), "not a PNG", True),
    "header only": (lambda png: png(4, 3)[:20], "cut off", True),
    "cut off": (lambda png: png(400, 300, bytes(360000))[:-20], "cut off", True),
    "without its end": (lambda png: png(4, 3)[:-12], "cut off", True),
    "damaged header": (lambda png: _flip(png(4, 3), 17), "header is damaged", True),
    "bomb": (lambda png: _claiming(png, 100_000, 100_000), "claims 100000 x 100000", True),
    "no pixels": (lambda png: _claiming(png, 0, 5), "claims 0 x 5", True),
    "16 bits": (lambda png: png(2, 3, bytes(36), bits=16), "16 bits", True),
    "damaged pixels": (lambda png: _flip(png(40, 30), 50), "damaged", False),
    "fewer pixels than claimed": (lambda png: _claiming(png, 40, 30), "cannot be decoded", False),
}


@pytest.mark.parametrize(
    ("content", "message", "in_header"), BROKEN_IMAGES.values(), ids=BROKEN_IMAGES.keys()
)
def test_a_broken_image_is_named(
    tmp_path: Path, png: Png, content: Callable[[Png], bytes], message: str, in_header: bool
) -> None:
    path = tmp_path / "000107.png"
    path.write_bytes(content(png))
    for read in (read_image, read_image_size) if in_header else (read_image,):
        with pytest.raises(DataError, match=message) as caught:
            read(path)
        assert caught.value.path == str(path)
        assert caught.value.remedy


def test_points_come_back(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform(size=(50, 4)).astype(np.float32)
    path = tmp_path / "000107.bin"
    points.astype("<f4").tofile(path)
    np.testing.assert_array_equal(read_points(path), points)
    assert check_scan_size(path) == 50
    read = pickle.loads(pickle.dumps(ScanFile(path)))()
    assert read.dtype == np.float32
    assert read.flags.writeable


BROKEN_SCANS = {
    "empty": (b"", "empty"),
    "cut off": (bytes(1603), "16 bytes for each point, this file has 1603"),
    "NaN": (np.array([[0, 1, 2, 0.3], [0, np.nan, 2, 0.3]], "<f4").tobytes(), "1 of 2.*is point 1"),
    "infinite": (np.array([[np.inf, 1, 2, 3]], "<f4").tobytes(), "not finite"),
    "huge": (np.array([[1e30, 1, 2, 0]], "<f4").tobytes(), "beyond"),
    "beyond a kilometre": (np.array([[0, 0, -1001, 0]], "<f4").tobytes(), "beyond 1000 m"),
    "bright": (np.array([[9, 1, 2, 0], [9, 1, 2, 128]], "<f4").tobytes(), "1 of 2.*reflectance"),
    "dark": (np.array([[9, 1, 2, -0.1]], "<f4").tobytes(), "reflectance"),
}


@pytest.mark.parametrize(("content", "message"), BROKEN_SCANS.values(), ids=BROKEN_SCANS.keys())
def test_a_broken_scan_is_named(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "000107.bin"
    path.write_bytes(content)
    with pytest.raises(DataError, match=message) as caught:
        read_points(path)
    assert caught.value.path == str(path)
    assert caught.value.remedy


def test_what_is_not_there_is_named(tmp_path: Path) -> None:
    for read in (read_image, read_image_size, read_points, check_scan_size):
        with pytest.raises(DataError, match="absent"):
            read(tmp_path / "absent")
    for read in (read_image, read_image_size, read_points):
        with pytest.raises(DataError, match=r"a folder, not a file"):
            read(tmp_path)


def test_real_images_and_scans(shared: Path) -> None:
    folder = shared / "kitti/object/training"
    for path in sorted((folder / "image_2").iterdir()):
        image = read_image(path)
        assert image.shape[1::-1] == read_image_size(path)
        assert image.std() > 10
    for path in sorted((folder / "velodyne").iterdir()):
        points = read_points(path)
        assert 80_000 < len(points) < 140_000
        assert np.abs(points[:, :2]).max() < 121
        assert points[:, 3].min() >= 0
        assert points[:, 3].max() <= 1
