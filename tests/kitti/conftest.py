"""A tiny object layout made by hand, so that these tests need no KITTI."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

LABEL = (
    "Car 0.00 1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58\n"
    "DontCare -1 -1 -10 579.44 175.79 595.04 188.10 -1 -1 -1 -1000 -1000 -1000 -10\n"
    "Van 0.25 0 -0.00 10.00 20.00 30.00 40.50 2.00 1.90 5.00 -3.00 1.70 20.00 -0.00\n"
)

CALIBRATION = (
    "P0: 700 0 600 0 0 700 180 0 0 0 1 0\n"
    "P1: 700 0 600 -378 0 700 180 0 0 0 1 0\n"
    "P2: 700 0 600 42 0 700 180 0.2 0 0 1 0.003\n"
    "P3: 700 0 600 -336 0 700 180 2.2 0 0 1 0.003\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\n"
    "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n"
)


PngWriter = Callable[..., bytes]


def write_png(width: int, height: int, pixels: bytes | None = None, bits: int = 8) -> bytes:
    """A colour PNG written by the specification, independent of any decoder."""
    if pixels is None:
        pixels = bytes(3 * width * height)
    rows = b"".join(
        b"\0" + pixels[3 * width * row : 3 * width * (row + 1)] for row in range(height)
    )
    header = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )


@pytest.fixture(name="png")
def png_writer() -> PngWriter:
    """See `write_png`."""
    return write_png


@pytest.fixture
def object_root(tmp_path: Path) -> Path:
    """Two frames: 000000 complete, 000003 without right image, scan and past."""
    root = tmp_path / "object"
    folder = root / "training"
    for id in ("000000", "000003"):
        for kind, name, content in (
            ("label_2", f"{id}.txt", LABEL.encode()),
            ("calib", f"{id}.txt", CALIBRATION.encode()),
            ("image_2", f"{id}.png", write_png(4, 3)),
        ):
            (folder / kind).mkdir(parents=True, exist_ok=True)
            (folder / kind / name).write_bytes(content)
    for kind, name in (("image_3", "000000"), ("prev_2", "000000_01"), ("prev_3", "000000_01")):
        (folder / kind).mkdir()
        (folder / kind / f"{name}.png").write_bytes(write_png(4, 3, bytes(range(36))))
    (folder / "velodyne").mkdir()
    np.arange(40, dtype="<f4").tofile(folder / "velodyne" / "000000.bin")
    (root / "ImageSets").mkdir()
    (root / "ImageSets" / "val.txt").write_text("000003\n000000\n")
    return root
