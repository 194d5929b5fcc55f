"""Points and boxes in the camera frame that are as true as those there are."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.point_samples import PointSample
from avsec_gym.perception.training.scan_variation import drawn_variation

LARGEST_TURN = np.pi / 18
"""The largest turn, radians, as published."""


def varied_points(
    sample: PointSample, augmentation: Augmentation, randomness: np.random.Generator
) -> PointSample:
    """A variation of a sample; see `drawn_variation`."""
    variation = drawn_variation(augmentation, LARGEST_TURN, randomness)
    sample = mirrored(sample) if variation.mirrored else sample
    return scaled(turned(sample, variation.turn), variation.scale)


def mirrored(sample: PointSample) -> PointSample:
    """Left and right exchanged."""

    def boxes(rows: Floats) -> Floats:
        return np.column_stack([-rows[:, 0], rows[:, 1:6], np.pi - rows[:, 6]])

    sides = np.array([-1, 1, 1], np.float32)
    return PointSample(sample.points * sides, boxes(sample.objects), boxes(sample.ignored))


def turned(sample: PointSample, angle: float) -> PointSample:
    """Turned about the camera's y axis, as `rotation_y` counts, by an angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])

    def boxes(rows: Floats) -> Floats:
        return np.column_stack([rows[:, :3] @ turn, rows[:, 3:6], rows[:, 6] + angle])

    points = sample.points @ turn.astype(np.float32)
    return PointSample(points, boxes(sample.objects), boxes(sample.ignored))


def scaled(sample: PointSample, factor: float) -> PointSample:
    """Everything larger and farther by a factor."""
    sizes = np.array([*[factor] * 6, 1.0])
    points = sample.points * np.float32(factor)
    return PointSample(points, sample.objects * sizes, sample.ignored * sizes)
