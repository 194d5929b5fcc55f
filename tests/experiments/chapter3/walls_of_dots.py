"""What chapter 3's tests let sensors see: a wall of dark random dots, whose depth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.rig import camera_rig

PLACES = (0.0, 0.56, -0.28, 0.28)
LABEL = "Car 0.00 0 -1.57 100.00 50.00 140.00 90.00 1.50 1.60 4.00 0.00 1.65 12.00 -1.57\n"
"""Of a car 12 m ahead."""
SCENE = '{"road_type": "highway", "objects": [{"moving": true}]}'
RIG = camera_rig(PLACES, focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))


def wall(number: int, distance: float = 8.0) -> SensorFrame:
    """By all sensors of the rig.

    Args:
        number: Of the frame; others have other dots.
        distance: Metres ahead.
    """
    rng = np.random.default_rng(number)
    dots = rng.integers(0, 100, (120, 300, 1), np.uint8).repeat(3, axis=2)
    starts = [20 + round(200 * place / distance) for place in PLACES]
    images = {camera: dots[:, start : start + 240] for camera, start in enumerate(starts)}
    half = np.array([5.0, 2.0]) * distance / 8
    x, y = np.meshgrid(np.linspace(-half[0], half[0], 150), np.linspace(-half[1], half[1], 40))
    spots = np.stack([x.ravel(), y.ravel(), np.full(x.size, distance), np.ones(x.size)], axis=1)
    points = (spots @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:010d}", RIG.calibration, images, points)


def write_wall(root: Path, drive: int, number: int, seed: int, distance: float = 8.0) -> Path:
    """One frame of a drive below a root; the drive's folder."""
    day = root / "2026_01_01"
    folder = day / f"2026_01_01_drive_{drive:04d}_sync"
    write_raw_frame(folder, number, wall(seed, distance))
    if not (day / "calib_cam_to_cam.txt").exists():
        write_raw_calibration(day, RIG.calibration, image_size=RIG.size)
    return folder


def write_labelled_drives(
    root: Path, drives: int, frames: int, first: int = 0, distance: float = 8.0
) -> Path:
    """Drives on a highway with `LABEL` in each frame; their root.

    Args:
        root: Where to.
        drives: How many.
        frames: Of each.
        first: Other dots.
        distance: Metres to the walls.
    """
    for drive in range(1, drives + 1):
        for number in range(frames):
            folder = write_wall(root, drive, number, first + 100 * drive + number, distance)
            for kind, text in (
                ("label_02/data/{}.txt", LABEL),
                ("moving_02/data/{}.txt", "1\n"),
                ("scene_02/data/{}.json", SCENE),
            ):
                path = folder / kind.format(f"{number:010d}")
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
    return root
