"""How noisy a scan's ranges are, and how even its ground: measured alike on real and made scans."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats

STEP = np.radians(0.18)
"""The step between most neighbours in KITTI's rings."""
_STEP_TOLERANCE = np.radians(0.08)
_NEAR = 25.0
"""Metres ahead of and behind the LiDAR within which the road's cells lie..."""
_ASIDE = 4.0
"""... and to its sides."""
_LOW, _HIGH = -2.4, -1.2
"""Heights of the road below the LiDAR, metres."""
_FEWEST = 30
_FROM_NORMAL = 1.4826
"""A normal distribution's standard deviation over its median absolute value."""


def range_noise(points: Points, beam: NDArray[np.int64], low: float, high: float) -> float | None:
    """Standard deviation of ranges from one pulse to the next, metres, without outliers.

    Second differences along each ring: a plane cancels, noise adds up to the root of six times.

    Args:
        points: Shape (M, 4), in the order of KITTI's files.
        beam: Beam of each point, shape (M,).
        low: Shortest range that counts, metres.
        high: Longest range that counts, metres.

    Returns:
        None with fewer than 30 triples of neighbours.
    """
    distance = np.linalg.norm(points[:, :3].astype(float), axis=1)
    azimuth = np.arctan2(points[:, 1], points[:, 0]).astype(float)
    step = np.abs(np.diff(azimuth) - STEP) < _STEP_TOLERANCE
    same = (beam[2:] == beam[:-2]) & step[1:] & step[:-1]
    same &= (distance[1:-1] > low) & (distance[1:-1] < high)
    second = (distance[:-2] - 2.0 * distance[1:-1] + distance[2:])[same] / np.sqrt(6.0)
    return float(_FROM_NORMAL * np.median(np.abs(second))) if len(second) >= _FEWEST else None


def ground_residual(points: Points, cell: float) -> tuple[float, float] | None:
    """How far the road around the vehicle is from planes, metres.

    Args:
        points: Shape (M, 4).
        cell: Side of the squares to which planes are fitted, metres.

    Returns:
        Median and 90th percentile of the squares' standard deviations; kerbs and feet of parked
        cars are in the latter.  None without a square of 30 points.
    """
    places = points[:, :3].astype(float)
    road = (np.abs(places[:, 0]) < _NEAR) & (np.abs(places[:, 1]) < _ASIDE)
    places = places[road & (places[:, 2] > _LOW) & (places[:, 2] < _HIGH)]
    squares = np.floor(places[:, :2] / cell).astype(np.int64)
    _, square = np.unique(squares, axis=0, return_inverse=True)
    order = np.argsort(square, kind="stable")
    groups = np.split(places[order], np.flatnonzero(np.diff(square[order])) + 1)
    found = [_from_plane(group) for group in groups if len(group) >= _FEWEST]
    return (float(np.median(found)), float(np.percentile(found, 90))) if found else None


def _from_plane(places: Floats) -> float:
    level = np.column_stack([places[:, :2] - places[:, :2].mean(axis=0), np.ones(len(places))])
    solution = np.linalg.lstsq(level, places[:, 2], rcond=None)[0]
    return float((places[:, 2] - level @ solution).std())
