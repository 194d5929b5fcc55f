"""A tiny PointRCNN, and scans of a simple scene whose cars are known exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.perception.detectors.boxes_in_view import boxes_in_view
from avsec_gym.perception.detectors.pointrcnn.configuration import (
    Level,
    PointRcnnConfiguration,
    PointView,
    ProposalRule,
    Refinement,
    RegionSampling,
)

GROUND = 1.65


@pytest.fixture(scope="session")
def tiny() -> PointRcnnConfiguration:
    """All parts of the small network, with few points and channels."""
    return replace(
        PointRcnnConfiguration.preset("small"),
        view=PointView((-10.0, 10.0), (-1.0, 3.0), (0.0, 25.0), 512, far=15.0, most_far=0.5),
        levels=(
            Level(128, (0.5, 1.0), (8, 8), ((8, 16), (8, 16))),
            Level(32, (1.5, 3.0), (8, 8), ((16, 32), (16, 32))),
        ),
        propagation=((32, 32), (48,)),
        head=(32,),
        dropout=0.0,
        proposals=ProposalRule(256, 16, 0.5, is_turned=True),
        training_proposals=ProposalRule(256, 32, 0.7, is_turned=True),
        refinement=Refinement(
            48,
            inputs=(16, 32),
            levels=(Level(16, (0.8,), (8,), ((32, 32),)), Level(None, (9.0,), (1,), ((32, 48),))),
            head=(32,),
            is_normalised=True,
        ),
        sampling=RegionSampling(16),
    )


@dataclass(frozen=True)
class Scene:
    """A frame, and what is in it: boxes, and the same as rows."""

    frame: SensorFrame
    boxes: Boxes3D
    rows: Floats


@pytest.fixture(scope="session")
def scene(calibration: Calibration) -> Callable[[int], Scene]:
    """Makes a scene by its seed: three cars on a flat road, seen from the sensor's side."""

    def make(seed: int) -> Scene:
        randomness = np.random.default_rng(seed)
        z = np.array([9.0, 14.0, 19.0]) + randomness.uniform(-1, 1, 3)
        x = randomness.permutation([-3.5, 0.0, 3.5]) + randomness.uniform(-0.5, 0.5, 3)
        low, high = [1.4, 1.5, 3.6], [1.6, 1.8, 4.4]
        heading = np.array([-1.5, 1.4, 0.1])[randomness.permutation(3)]
        location = np.stack([x, np.full(3, GROUND), z], 1)
        rows = np.column_stack([location, randomness.uniform(low, high, (3, 3)), heading])
        road = randomness.uniform([-9.5, GROUND, 3], [9.5, GROUND, 24], (2500, 3))
        places = np.concatenate([road, *(_car(row, randomness) for row in rows)])
        points = np.column_stack(
            [transform_points(calibration.camera_to_velodyne, places), 0.3 + 0 * places[:, 0]]
        )
        image = np.zeros((120, 400, 3), np.uint8)
        frame = SensorFrame("000042", calibration, {2: image}, points.astype(np.float32))
        boxes = boxes_in_view(
            location, rows[:, 3:6], heading, np.ones(3), "Car", calibration, image.shape[:2]
        )
        return Scene(frame, boxes, rows)

    return make


def _car(row: Floats, randomness: np.random.Generator) -> Floats:
    """The two sides that face the sensor."""
    x, y, z, height, width, length, heading = row
    cos, sin = np.cos(heading), np.sin(heading)
    towards = np.array([-cos * x + sin * z, -sin * x - cos * z])
    along, across = randomness.uniform(-0.5, 0.5, (2, 300)) * [[length], [width]]
    along[:150] = 0.98 * np.sign(towards[0]) * length / 2
    across[150:] = 0.98 * np.sign(towards[1]) * width / 2
    up = randomness.uniform(0.1, 0.95 * height, 300)
    return np.stack([x + cos * along + sin * across, y - up, z - sin * along + cos * across], 1)
