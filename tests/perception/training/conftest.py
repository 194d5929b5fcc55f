"""A pair of images whose truth is known: a bright spot where an object's bottom centre is seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats, box_corners, project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import write_disparity
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.perception.training.checkpoint import CHECKPOINT
from avsec_gym.perception.training.configuration import TrainingConfiguration
from avsec_gym.perception.training.sample import StereoSample
from avsec_gym.perception.training.task import Task
from avsec_gym.perception.training.trainer import train
from avsec_gym.storage.text_files import write_text

HEIGHT, WIDTH = 120, 400
BEHIND = 4.0
"""Disparity of everything else, pixels."""


def spot_calibration() -> Calibration:
    """Cameras as KITTI's, a third as large, not quite at equal heights."""
    projections = np.zeros((4, 3, 4))
    for camera, column in ((2, (13.0, 0.07, 0.003)), (3, (-113.0, 0.72, 0.003))):
        projections[camera] = [[240.0, 0, 195, 0], [0, 235, 55, 0], [0, 0, 1, 0]]
        projections[camera, :, 3] = column
    velodyne = np.array([[0.0, -1, 0, 0], [0, 0, -1, -0.08], [1, 0, 0, -0.27]])
    return Calibration(projections, np.eye(3), velodyne)


def spot_boxes(x: float = 2.0, z: float = 14.0, rotation_y: float = 0.4) -> Boxes3D:
    location, dimensions = np.array([[x, 1.6, z]]), np.array([[1.5, 1.7, 4.0]])
    corners = box_corners(location, dimensions, np.array([rotation_y]))[0]
    uv, _ = project(spot_calibration().projection(2), corners)
    box2d = np.clip(np.array([*uv.min(0), *uv.max(0)]), 0, [WIDTH - 1, HEIGHT - 1] * 2)
    return Boxes3D(
        location, dimensions, np.array([rotation_y]), np.ones(1), np.array(["Car"]), box2d[None],
        np.zeros(1), np.zeros(1), np.array([rotation_y - np.arctan2(x, z)]),
    )  # fmt: skip


def spot_images(boxes: Boxes3D) -> tuple[list[NDArray[np.uint8]], list[NDArray[np.float32]]]:
    """Images and disparity maps of both cameras."""
    calibration = spot_calibration()
    scale = calibration.focal_length(2) * calibration.baseline(2, 3)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    images, disparities = [], []
    for camera in (2, 3):
        (place,), _ = project(calibration.projection(camera), boxes.location)
        distance = (u - place[0]) ** 2 + (v - place[1]) ** 2
        spot = 40 + 200 * np.exp(-distance / (2 * 3.0**2))
        images.append(np.repeat(np.round(spot)[..., None], 3, axis=2).astype(np.uint8))
        near = np.float32(scale / boxes.location[0, 2])
        disparities.append(np.where(distance < 8**2, near, np.float32(BEHIND)).astype(np.float32))
    return images, disparities


@pytest.fixture
def spot_sample() -> Callable[..., StereoSample]:
    """Makes a sample from x, z and rotation_y of its object."""

    def make(x: float = 2.0, z: float = 14.0, rotation_y: float = 0.4) -> StereoSample:
        boxes = spot_boxes(x, z, rotation_y)
        images, disparities = spot_images(boxes)
        calibration = spot_calibration()
        projections = [calibration.projection(camera) for camera in (2, 3)]
        return StereoSample(*images, *projections, *disparities, boxes)

    return make


@pytest.fixture
def spot_folder(tmp_path: Path) -> Path:
    """Eight frames in the object layout, six to train on, two to validate on."""
    return write_spots(tmp_path / "kitti", [(-2.0 + 0.5 * i, 10.0 + i) for i in range(8)])


def write_spots(root: Path, places: Sequence[tuple[float, float]]) -> Path:
    for number, (x, z) in enumerate(places):
        boxes = spot_boxes(x, z)
        images, disparities = spot_images(boxes)
        id = f"{number:06d}"
        frame = SensorFrame(id, spot_calibration(), dict(zip((2, 3), images, strict=True)))
        write_object_frame(root / "training", frame, boxes)
        write_disparity(root / "training" / "disparity_2" / f"{id}.png", disparities[0])
    ids = [f"{number:06d}\n" for number in range(len(places))]
    write_text(root / "ImageSets" / "train.txt", "".join(ids[:-2]))
    write_text(root / "ImageSets" / "val.txt", "".join(ids[-2:]))
    return root


@pytest.fixture
def spot_errors() -> Callable[[StereoSample], Floats]:
    """How far the spots are from where the truth says, in both views, pixels."""

    def measure(sample: StereoSample) -> Floats:
        v, u = np.mgrid[: sample.size[0], : sample.size[1]]
        errors = []
        for image, projection in (
            (sample.left, sample.left_projection),
            (sample.right, sample.right_projection),
        ):
            weight = np.maximum(image[..., 0].astype(float) - 60, 0)
            seen = np.array([(weight * u).sum(), (weight * v).sum()]) / weight.sum()
            errors.append(np.abs(seen - project(projection, sample.truth.location)[0][0]).max())
        return np.array(errors)

    return measure


@pytest.fixture
def scan_folder(spot_folder: Path) -> Path:
    """The frames of `spot_folder` with scans: points on their car, and on the road."""
    data = KittiObject(spot_folder)
    back = spot_calibration().camera_to_velodyne
    for id in data.ids():
        randomness, car = np.random.default_rng(int(id)), data.labels(id)
        height, width, length = car.dimensions[0]
        along, across, up = (randomness.uniform(-0.5, 0.5, (3, 300)).T * [length, width, height]).T
        cos, sin = np.cos(car.rotation_y[0]), np.sin(car.rotation_y[0])
        aside = [cos * along + sin * across, -up - height / 2, cos * across - sin * along]
        road = randomness.uniform([-15, 1.6, 1], [15, 1.6, 30], (2000, 3))
        places = transform_points(back, np.concatenate([car.location + np.stack(aside, 1), road]))
        points = np.column_stack([places, randomness.uniform(0, 1, len(places))])
        path = spot_folder / "training" / "velodyne" / f"{id}.bin"
        path.parent.mkdir(exist_ok=True)
        points.astype("<f4").tofile(path)
    return spot_folder


@pytest.fixture
def resumed_equals_uninterrupted(tmp_path: Path) -> Callable[[Callable[[], Task[Any]]], Path]:
    """Checks it bit for bit, and that every part learns; returns the folder of the whole run.

    It takes a function that makes the task anew; samples are as many as in `spot_folder`.
    """
    steps = TrainingConfiguration(epochs=2, batch=2, seed=1, arithmetic="float32")

    def check(make: Callable[[], Task[Any]]) -> Path:
        whole, halves = tmp_path / "whole", tmp_path / "halves"
        begun = {name: value.clone() for name, value in make().trained.named_parameters()}
        train(make(), steps, whole)

        task = make()
        learn, left = task.losses, iter(range(4))

        def stopped(batch: Any) -> dict[str, torch.Tensor]:
            if next(left) == 3:
                raise KeyboardInterrupt
            return learn(batch)

        task.losses = stopped  # type: ignore[method-assign]
        with pytest.raises(KeyboardInterrupt):
            train(task, steps, halves)
        train(make(), steps, halves, resume=True)

        one, two = (torch.load(run / CHECKPOINT, weights_only=True) for run in (whole, halves))
        assert (one["step"], two["step"]) == (6, 6)
        for part in ("trained", "average"):
            for name, value in one[part].items():
                assert torch.equal(value, two[part][name]), (part, name)
        still = [name for name, value in begun.items() if torch.equal(value, one["trained"][name])]
        assert not still
        return whole

    return check
