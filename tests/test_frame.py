from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, Image, LazyImages, SensorFrame, StereoPair


@pytest.fixture
def calibration() -> Calibration:
    camera = np.array([[700.0, 0, 600, 0], [0, 700, 180, 0], [0, 0, 1, 0]])
    projections = np.stack([camera] * 4)
    projections[3, 0, 3] = -350
    ahead = np.array([[0.0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    return Calibration(projections, np.eye(3), ahead)


def test_images_are_loaded_when_asked_for_and_once(calibration: Calibration) -> None:
    calls: list[int] = []

    def load() -> Image:
        calls.append(2)
        return np.zeros((3, 4, 3), np.uint8)

    frame = SensorFrame("000000", calibration, LazyImages({2: load}))
    assert 2 in frame.images
    assert len(frame.images) == 1
    assert "LazyImages([2])" in repr(frame)
    assert calls == []
    assert frame.image(2) is frame.image(2)
    assert calls == [2]


def test_points_are_loaded_when_asked_for_and_once(calibration: Calibration) -> None:
    frame = SensorFrame("000000", calibration, scan=lambda: np.ones((5, 4), np.float32))
    assert frame.has_points
    assert frame.points is frame.points


def test_an_attack_leaves_the_frame_as_it_was(calibration: Calibration) -> None:
    black, white = np.zeros((3, 4, 3), np.uint8), np.full((3, 4, 3), 255, np.uint8)
    for images in ({2: black, 3: black}, LazyImages({2: lambda: black, 3: black})):
        frame = SensorFrame("000000", calibration, images, scan=np.zeros((5, 4), np.float32))
        attacked = frame.with_image(3, white).with_points(np.ones((6, 4), np.float32))
        assert attacked.image(3).min() == 255
        assert attacked.image(2).max() == 0
        assert len(attacked.points) == 6
        assert frame.image(3).max() == 0
        assert len(frame.points) == 5
        assert attacked.id == frame.id


@pytest.mark.parametrize("entry", [(0, 0), (1, 1), (0, 2), (1, 2)], ids=str)
def test_cameras_that_are_not_rectified_to_each_other_are_no_pair(
    calibration: Calibration, entry: tuple[int, int]
) -> None:
    """Depths by f b / z would all be wrong, without a word."""
    projections = calibration.projections.copy()
    projections[(3, *entry)] += 30.0
    image = np.zeros((3, 4, 3), np.uint8)
    other = replace(calibration, projections=projections)
    with pytest.raises(DataError, match="P2 and P3 are not those of a rectified pair"):
        SensorFrame("000000", other, {2: image, 3: image}).stereo()


def test_a_stereo_pair(calibration: Calibration) -> None:
    image = np.zeros((3, 4, 3), np.uint8)
    frame = SensorFrame("000000", calibration, {2: image, 3: image})
    pair = frame.stereo()
    assert (pair.focal_length, pair.baseline) == (700, 0.5)
    with pytest.raises(DataError, match="exchanged"):
        frame.stereo(3, 2)
    with pytest.raises(DataError, match="4 x 3 pixels, camera 3 3 x 3"):
        frame.with_image(3, image[:, :3]).stereo()
    with pytest.raises(ConfigurationError, match="one size"):
        StereoPair(image, image[1:], 700, 0.5)


def test_what_a_frame_lacks_is_named(calibration: Calibration) -> None:
    frame = SensorFrame("000107", calibration)
    with pytest.raises(DataError, match="Frame 000107 has no image of camera 2"):
        frame.image()
    with pytest.raises(DataError, match="Frame 000107 has no LiDAR scan"):
        _ = frame.points


@pytest.mark.parametrize(
    "change",
    [
        {"projections": np.zeros((4, 3, 3))},
        {"r0_rect": np.eye(4)},
        {"r0_rect": np.zeros((3, 3))},
        {"r0_rect": np.diag([1.0, 1, -1])},
        {"tr_velo_to_cam": np.full((3, 4), np.nan)},
        {"tr_imu_to_velo": np.ones((3, 4))},
    ],
)
def test_what_cannot_be_a_calibration(calibration: Calibration, change: dict) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(change))):
        replace(calibration, **change)


def test_heavy_libraries_are_imported_late() -> None:
    code = (
        "import sys, avsec_gym.frame, avsec_gym.kitti;"
        "print(*{'torch', 'cv2', 'matplotlib', 'commonroad'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
