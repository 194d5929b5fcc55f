"""A tiny DSGN, and stereo pairs of a simple scene whose boxes and depths are known exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.grid import CAR, DepthScale, GridAxis, WorldGrid
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.stereo_batch import StereoBatch


@pytest.fixture(scope="session")
def tiny() -> DsgnConfiguration:
    """All parts of the full network, with few channels and a coarse grid."""
    return DsgnConfiguration(
        input_size=(64, 192),
        padded_size=(64, 192),
        features=FeatureConfiguration(
            first=8,
            stages=((8, 1), (16, 1), (16, 1), (16, 1)),
            joined=(2, 3, 4),
            windows=((8, 8), (4, 4)),
            pooled=8,
            matching=(16, 8),
            semantic=(16, 8),
            groups=4,
        ),
        groups=4,
        planes=DepthScale(26.0, 4.0, 16, power=-1),
        bins=DepthScale(26.0, 4.0, 16, power=-1),
        sampled=DepthScale(26.0, 4.0, 16, power=-1),
        full_depth=False,
        volume_channels=16,
        grid=WorldGrid(GridAxis(-8, 8, 32), GridAxis(2.5, -0.7, 8), GridAxis(26, 4, 44)),
        grid_channels=16,
        grid_hourglass=False,
        pooled_heights=4,
        view_channels=32,
        anchors=(CAR,),
    )


@pytest.fixture(params=["original", "half turns, fit, planes"])
def any_tiny(tiny: DsgnConfiguration, request: pytest.FixtureRequest) -> DsgnConfiguration:
    """With the heads and losses of the original, and with those that the small presets add."""
    if request.param == "original":
        return tiny
    return replace(
        tiny, angles=2, half_turns=True, fit=True, depth_loss="planes", object_pixels=8.0
    )


@dataclass(frozen=True)
class Scene:
    """A pair, what is on it, and the disparity of the left image (1, H, W)."""

    batch: StereoBatch
    boxes: Boxes3D
    disparity: Tensor


@pytest.fixture(scope="session")
def scene() -> Callable[[int], Scene]:
    """Makes a scene by its seed: two or three cars on a flat road, textured all over."""
    return _scene


def _scene(seed: int) -> Scene:
    randomness = np.random.default_rng(seed)
    count = int(randomness.integers(2, 4))
    x = np.array([-4.0, 0.5, 4.5])[:count] + randomness.uniform(-0.4, 0.4, count)
    z = randomness.permutation([9.0, 13.5, 18.0])[:count] + randomness.uniform(-1, 1, count)
    boxes = Boxes3D(
        np.column_stack([x, np.full(count, 1.65), z]),
        np.column_stack([[1.5, 1.6, 3.9]] * count).T * randomness.uniform(0.95, 1.05, (count, 3)),
        randomness.choice([-1.57, 1.57, 0.3], count) + randomness.uniform(-0.15, 0.15, count),
        np.ones(count),
        np.array(["Car"] * count),
    )
    height, width, focal, baseline = 80, 240, 140.0, 0.54
    projection = np.array(
        [[focal, 0, width / 2, 0], [0, focal, height * 0.4, 0], [0, 0, 1, 0]], float
    )
    right_projection = projection.copy()
    right_projection[0, 3] = -focal * baseline
    left, depth = _view(boxes, projection, 0.0, (height, width))
    right, _ = _view(boxes, projection, baseline, (height, width))
    tensors = [torch.from_numpy(image).permute(2, 0, 1)[None].float() for image in (left, right)]
    batch = StereoBatch(
        *tensors,
        torch.from_numpy(projection)[None],
        torch.from_numpy(right_projection)[None],
        (height, width),
    )
    return Scene(batch, boxes, torch.from_numpy(focal * baseline / depth)[None].float())


def _view(
    boxes: Boxes3D, projection: np.ndarray, aside: float, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Image (H, W, 3) in grey levels and depth (H, W) of a camera moved to the right."""
    v, u = np.mgrid[: size[0], : size[1]].astype(float)
    rays = np.stack([u, v, np.ones_like(u)], -1) @ np.linalg.inv(projection[:, :3]).T
    start = np.array([aside, 0.0, 0.0])
    with np.errstate(divide="ignore"):
        depth = np.where(rays[..., 1] > 0, 1.65 / rays[..., 1], 60.0).clip(max=60.0)
    tint = np.zeros(size)
    for i in range(len(boxes)):
        cos, sin = np.cos(boxes.rotation_y[i]), np.sin(boxes.rotation_y[i])
        turn = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
        middle = boxes.location[i] - [0, boxes.dimensions[i, 0] / 2, 0]
        half = boxes.dimensions[i, [2, 0, 1]] / 2
        direction, origin = rays @ turn.T, turn @ (start - middle)
        with np.errstate(divide="ignore"):
            one, two = (-half - origin) / direction, (half - origin) / direction
        enter, leave = np.minimum(one, two).max(-1), np.maximum(one, two).min(-1)
        hit = (enter < leave) & (enter > 0) & (enter < depth)
        depth, tint = np.where(hit, enter, depth), np.where(hit, i + 1.0, tint)
    points = start + rays * depth[..., None]
    waves = np.array([[3.1, 5.3, 2.3], [7.7, 2.9, 6.1], [1.3, 9.1, 4.7], [11.0, 4.0, 8.0]])
    pattern = np.sin(points @ waves.T + np.arange(4)).sum(-1) / 8
    shades = np.stack([0.5 + 0.25 * np.cos(tint * k) for k in (1.0, 2.0, 3.0)], -1)
    return 255 * (shades + pattern[..., None] * 0.5).clip(0, 1), depth
