"""A detector that is quick and can be fooled: a plug-in, and small frames for it to look at.

A module of its own, not a test: other processes load it as anyone's plug-in (conftest.py).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import box_corners, ego_to_camera, project, transform_points
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.registry import Kind, names, register
from avsec_gym.rig import KITTI_CAMERAS, SensorRig, camera_rig

GROUND = 1.65
LEVEL = 120
"""Grey levels from which on something is a car."""
BACKGROUND, CAR = 112, 180
SIZE = (1.5, 1.6, 4.0)
SCENES = (
    [[14.0, 5.5, 0.0], [26.0, -5.5, 0.0]],
    [[20.0, 7.0, 0.0]],
    [[12.0, -6.0, 0.0], [33.0, 1.0, 0.0]],
)
"""Poses of the cars of each frame, ego frame; nothing is in the way."""
CLEAN = "clean"
"""Folder of frames for a validator to be fitted on, beside those that are played."""


class BrightCars:
    """Sees a car wherever the left image is bright, standing where its lower edge is."""

    name = "bright_cars"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        import cv2

        grey = cv2.blur(frame.image(2).astype(np.float32).mean(axis=2), (7, 7))
        _, _, found, centres = cv2.connectedComponentsWithStats((grey >= LEVEL).astype(np.uint8))
        area, bottom = found[1:, cv2.CC_STAT_AREA], found[1:, 1] + found[1:, 3] - 3  # Blurred.
        projection = frame.calibration.projection(2)
        below = bottom - projection[1, 2]
        cars = (area >= 30) & (below > 5)
        depth = projection[1, 1] * GROUND / below[cars]
        x = (centres[1:, 0][cars] - projection[0, 2]) * depth / projection[0, 0]
        count = len(depth)
        return Boxes3D(
            np.column_stack([x, np.full(count, GROUND), depth + SIZE[2] / 2]),
            np.tile(SIZE, (count, 1)),
            np.full(count, -np.pi / 2),
            np.minimum(area[cars] / 200.0, 1.0),
            np.full(count, "Car"),
        )


def register_detector() -> None:
    """What the plug-in's entry point names."""
    if "bright_cars" not in names(Kind.DETECTOR):
        register(Kind.DETECTOR, "bright_cars", BrightCars)


def rig() -> SensorRig:
    """KITTI's with a third of its pixels in each direction."""
    return camera_rig(KITTI_CAMERAS, focal_length=240.0, centre=(207.0, 57.0), size=(414, 125))


def scan(location: np.ndarray) -> np.ndarray:
    """The road, every 30 cm, and the rears of the cars, every 10 cm."""
    x, z = np.meshgrid(np.arange(-12.0, 12.0, 0.3), np.arange(4.0, 45.0, 0.3))
    surfaces = [np.stack([x, np.full_like(x, GROUND), z], axis=-1)]
    height, width, length = SIZE
    across, up = np.meshgrid(np.arange(0.0, width, 0.1) - width / 2, np.arange(0.0, height, 0.1))
    for place in location:
        rear = np.stack([across, -up, np.full_like(up, -length / 2)], axis=-1)
        surfaces.append(place + rear)
    points = np.concatenate([surface.reshape(-1, 3) for surface in surfaces])
    seen = transform_points(rig().calibration.camera_to_velodyne, points)
    return np.c_[seen, np.full(len(seen), 0.3)].astype(np.float32)


def write_frames(root: Path) -> None:
    """Those of `SCENES`, and `CLEAN` ones: their mirror images, with other noise."""
    for number, poses in enumerate(SCENES):
        write_frame(root, number, poses)
        mirrored = [[x, -y, -heading] for x, y, heading in poses]
        write_frame(root / CLEAN, len(SCENES) + number, mirrored)


def write_frame(root: Path, number: int, poses: list[list[float]]) -> None:
    """Bright boxes before a dark background, in KITTI's object layout, with a scan."""
    calibration = rig().calibration
    noise = np.random.default_rng(number).integers(-6, 7, (125, 414, 3))
    location, rotation_y = ego_to_camera(np.array(poses), GROUND)
    dimensions, count = np.tile(SIZE, (len(poses), 1)), len(poses)
    images, rectangles = {}, []
    for camera in (2, 3):
        image = BACKGROUND + noise
        corners = box_corners(location, dimensions, rotation_y)
        pixels, _ = project(calibration.projection(camera), corners)
        low, high = np.rint(pixels.min(axis=1)).astype(int), np.rint(pixels.max(axis=1))
        for (left, top), (right, bottom) in zip(low, high.astype(int), strict=True):
            image[max(top, 0) : bottom, max(left, 0) : right] = CAR
        images[camera] = image.astype(np.uint8)
        rectangles.append(np.hstack([low, high]).clip(0, [413, 124, 413, 124]))
    labels = Boxes3D(
        location,
        dimensions,
        rotation_y,
        np.ones(count),
        np.full(count, "Car"),
        box2d=rectangles[0].astype(float),
        truncation=np.zeros(count),
        occlusion=np.zeros(count),
        alpha=rotation_y - np.arctan2(location[:, 0], location[:, 2]),
    )
    frame = SensorFrame(f"{number:06d}", calibration, images, scan(location))
    write_object_frame(root / "training", frame, labels)
