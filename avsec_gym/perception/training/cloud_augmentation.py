"""LiDAR scans that are as true as those there are: mirrored, turned, scaled about the sensor."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.perception.training.cloud_samples import CloudSample
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.scan_variation import drawn_variation

LARGEST_TURN = 0.2
"""The largest turn, radians."""


def varied(
    sample: CloudSample, augmentation: Augmentation, randomness: np.random.Generator
) -> CloudSample:
    """A variation of a sample; see `drawn_variation`."""
    variation = drawn_variation(augmentation, LARGEST_TURN, randomness)
    sample = mirrored(sample) if variation.mirrored else sample
    return scaled(turned(sample, variation.turn), variation.scale)


def mirrored(sample: CloudSample) -> CloudSample:
    """Left and right exchanged."""
    right, left = sample.azimuths
    sides = np.array([1, -1, 1, 1, -1.0])
    return CloudSample(
        sample.points * np.array([1, -1, 1, 1], np.float32),
        sample.rectangles * sides,
        sample.ignored * sides,
        (-left, -right),
    )


def turned(sample: CloudSample, angle: float) -> CloudSample:
    """Turned to the left about the sensor's upright axis by an angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, sin], [-sin, cos]])

    def places(rows: Floats) -> Floats:
        return np.concatenate([rows[:, :2] @ turn, rows[:, 2:4], rows[:, 4:] + angle], axis=1)

    points = sample.points.copy()
    points[:, :2] = points[:, :2] @ turn.astype(np.float32)
    right, left = sample.azimuths
    return CloudSample(
        points, places(sample.rectangles), places(sample.ignored), (right + angle, left + angle)
    )


def scaled(sample: CloudSample, factor: float) -> CloudSample:
    """Everything larger and farther by a factor."""
    sizes = np.array([factor, factor, factor, factor, 1.0])
    return CloudSample(
        sample.points * np.array([factor, factor, factor, 1], np.float32),
        sample.rectangles * sizes,
        sample.ignored * sizes,
        sample.azimuths,
    )
