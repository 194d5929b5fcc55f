"""A tiny PIXOR, and scans of a simple scene whose cars are known exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, Points, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion, PixorConfiguration
from avsec_gym.perception.detectors.pixor.upright_boxes import upright_boxes

GROUND = -1.7


@pytest.fixture(scope="session")
def tiny() -> PixorConfiguration:
    """All parts of the small network, with few channels and a narrow view."""
    return replace(
        PixorConfiguration.preset("small"),
        region=BirdEyeRegion((0.0, 22.4), (-9.6, 9.6), (-2.0, 0.5), 0.2, 0.5),
        stem=8,
        planes=(4, 6, 8, 12),
        blocks=(1, 1, 1, 1),
        laterals=(24, 24, 16),
    )


@dataclass(frozen=True)
class Scene:
    """A frame, and what is in it: boxes, and their rectangles in the velodyne frame."""

    frame: SensorFrame
    boxes: Boxes3D
    rectangles: Floats


@pytest.fixture(scope="session")
def scene(calibration: Calibration) -> Callable[[int], Scene]:
    """Makes a scene by its seed: three cars on a flat road, seen from the sensor's side."""

    def make(seed: int) -> Scene:
        randomness = np.random.default_rng(seed)
        x = np.array([8.0, 13.0, 18.0]) + randomness.uniform(-1, 1, 3)
        y = randomness.permutation([-3.5, 0.0, 3.5]) + randomness.uniform(-0.5, 0.5, 3)
        heading = np.array([0.0, 3.0, 1.4])[randomness.permutation(3)]
        rectangles = np.stack(
            [x, y, randomness.uniform(3.6, 4.4, 3), randomness.uniform(1.5, 1.8, 3), heading], 1
        )
        points = np.concatenate([_road(randomness), *(_car(row, randomness) for row in rectangles)])
        image = np.zeros((120, 400, 3), np.uint8)
        frame = SensorFrame("000042", calibration, {2: image}, points)
        boxes = upright_boxes(
            rectangles, np.full(3, GROUND), np.ones(3), "Car", 1.53, calibration, image.shape[:2]
        )
        return Scene(frame, boxes, rectangles)

    return make


def _road(randomness: np.random.Generator) -> Points:
    points = randomness.uniform([0.5, -9.5, GROUND, 0.1], [22, 9.5, GROUND, 0.2], (6000, 4))
    return points.astype(np.float32)


def _car(rectangle: Floats, randomness: np.random.Generator) -> Points:
    """The two sides that face the sensor."""
    x, y, length, width, heading = rectangle
    cos, sin = np.cos(heading), np.sin(heading)
    towards = np.array([-cos * x - sin * y, sin * x - cos * y])
    along, across = randomness.uniform(-0.5, 0.5, (2, 400)) * [[length], [width]]
    along[:200] = np.sign(towards[0]) * length / 2
    across[200:] = np.sign(towards[1]) * width / 2
    up = randomness.uniform(GROUND + 0.1, GROUND + 1.5, 400)
    places = [x + cos * along - sin * across, y + sin * along + cos * across, up, 0.5 + 0 * up]
    return np.stack(places, 1).astype(np.float32)
