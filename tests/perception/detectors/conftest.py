"""Pictures whose truth is known, textured rectangles in front of noise; and a LiDAR's rig."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration
from avsec_gym.perception.detectors.image_detector import image_boxes

Picture = tuple[Tensor, Boxes3D]


@pytest.fixture
def painted() -> Callable[..., Picture]:
    """Makes images (B, 3, 64, 192) and their truth: two cars in each of them."""

    def paint(*seeds: int) -> tuple[Tensor, list[Boxes3D]]:
        height, width, images, truth = 64, 192, [], []
        for seed in seeds:
            random = np.random.default_rng(seed)
            # Noise everywhere: where colours are exactly equal, maxima have no derivative.
            image = random.uniform(60, 120, (height, width, 3))
            boxes = []
            for half in range(2):
                w, h = random.integers(20, 60), random.integers(14, 36)
                x = half * width // 2 + random.integers(0, width // 2 - w)
                y = random.integers(0, height - h)
                colour = random.uniform(0, 100, 3)
                image[y : y + h, x : x + w] = random.uniform(80, 150, (h, w, 1)) + colour
                boxes.append([x, y, x + w - 1, y + h - 1])
            images.append(torch.from_numpy(image).permute(2, 0, 1).float())
            truth.append(image_boxes(np.array(boxes, float), np.ones(2), ["Car", "Car"]))
        return torch.stack(images), truth

    return paint  # type: ignore[return-value]


@pytest.fixture(scope="session")
def calibration() -> Calibration:
    """A rig like KITTI's, whose camera looks half a degree aside."""
    turn = 0.01
    cos, sin = np.cos(turn), np.sin(turn)
    velodyne = np.array([[-sin, -cos, 0, 0.02], [0, 0, -1, -0.08], [cos, -sin, 0, -0.27]])
    projections = np.zeros((4, 3, 4))
    projections[2] = [[240.0, 0, 200, 13.0], [0, 240, 60, 0.1], [0, 0, 1, 0.003]]
    return Calibration(projections, np.eye(3), velodyne)
