"""A tiny object layout made by hand and a tiny raw drive, so that these tests need no KITTI."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.tracklets import Tracklet
from avsec_gym.kitti.writing import write_drive_records, write_raw_frame

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
    np.linspace(0, 1, 40, dtype="<f4").tofile(folder / "velodyne" / "000000.bin")
    (root / "ImageSets").mkdir()
    (root / "ImageSets" / "val.txt").write_text("000003\n000000\n")
    return root


FRAMES = 4


@pytest.fixture
def rig() -> Calibration:
    """Five cameras and a LiDAR, each a little askew."""
    projections = np.tile([[70.0, 0, 6, 0], [0, 70, 4, 0], [0, 0, 1, 0]], (5, 1, 1))
    projections[:, 0, 3] = [0, -37.8, 4.2, -33.6, 21.7]
    projections[2:, 2, 3] = 0.003
    askew = rotation(0.01, -0.02, 0.03)
    to_camera = askew @ np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
    return Calibration(
        projections,
        rotation(-0.004, 0.007, 0.01),
        np.hstack([to_camera, [[-0.01], [-0.08], [-0.27]]]),
        np.hstack([askew, [[-0.81], [0.32], [-0.8]]]),
    )


@pytest.fixture
def raw_root(tmp_path: Path, rig: Calibration) -> Path:
    """A drive of four frames with everything, written by the writers."""
    root = tmp_path / "raw"
    drive = root / "2026_01_01" / "2026_01_01_drive_0007_sync"
    generator = np.random.default_rng(7)
    write_raw_calibration(drive.parent, rig, image_size=(12, 8))
    for number in range(FRAMES):
        images = {i: generator.integers(0, 255, (8, 12, 3), np.uint8) for i in range(5)}
        images |= {i: np.repeat(images[i][..., :1], 3, axis=2) for i in (0, 1)}
        scan = generator.uniform((-50, -50, -2, 0), (50, 50, 2, 1), (50, 4)).astype(np.float32)
        write_raw_frame(drive, number, SensorFrame(f"{number:010d}", rig, images, scan))
    times = np.datetime64("2026-01-01T12:00:00.000000789", "ns") + 100_000_000 * np.arange(FRAMES)
    write_drive_records(
        drive,
        oxts=oxts_from_poses(curve(FRAMES)),
        timestamps=dict.fromkeys(("oxts", "image_02", "velodyne_points"), times),
        tracklets=[
            Tracklet(
                category="Car",
                dimensions=np.array([1.5, 1.6, 4.0]),
                first_frame=1,
                translation=np.array([[20.0, 2.0, -1.7], [19.0, 2.0, -1.7]]),
                rotation=np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]),
                state=np.array([2, 1]),
                occlusion=np.array([0, 1]),
                truncation=np.array([0, 1]),
            )
        ],
    )
    return root


def rotation(roll: float, pitch: float, yaw: float) -> Floats:
    """Rz Ry Rx, written out."""
    (sr, sp, sy), (cr, cp, cy) = np.sin([roll, pitch, yaw]), np.cos([roll, pitch, yaw])
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def curve(count: int, period: float = 0.1) -> Floats:
    """Poses of a car that speeds up on a winding, hilly road, shape (count, 4, 4)."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    for i, time in enumerate(period * np.arange(count)):
        yaw = 2.0 + 0.6 * np.sin(0.5 * time)
        poses[i, :3, :3] = rotation(0.03 * np.sin(time), -0.02 * np.cos(0.7 * time), yaw)
        fine = np.linspace(0.0, time, 20 * i + 2)
        angle, speed = 2.0 + 0.6 * np.sin(0.5 * fine), 8.0 + 0.5 * fine
        poses[i, 0, 3] = 500.0 + np.trapezoid(speed * np.cos(angle), fine)
        poses[i, 1, 3] = -200.0 + np.trapezoid(speed * np.sin(angle), fine)
        poses[i, 2, 3] = 3.0 + 0.4 * np.sin(0.3 * time)
    return poses
