"""How closely the generated layouts match KITTI: statistics, distances, one figure.

Run ``python -m avsec_gym.experiments.layout_statistics --kitti ROOT --scenarios DIR``.
"""

from __future__ import annotations

import argparse
import json
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.layouts import Layout, generate_layouts

OBSTACLES = ("Car", "Van", "Truck", "Misc")
PEOPLE = ("Pedestrian", "Person_sitting", "Cyclist")
CATEGORIES = ("Car", "Van", "Truck", "Misc", "Pedestrian", "Cyclist", "Person_sitting", "Tram")
GOAL_CENTRES = {"left": (15.0, 3.5), "straight": (15.0, 0.0), "right": (15.0, -3.5)}
"""Centres of the planner's goal regions in the ego frame, metres."""

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Quantity:
    """One statistic of a set of frames: how to take samples and how to compare them."""

    title: str
    unit: str
    measure: Callable[[Sequence[Boxes3D]], Floats]
    edges: Floats
    distance: Literal["wasserstein", "variation"] = "wasserstein"
    """1-Wasserstein distance of the samples, in the unit, or total variation of the histograms."""


def statistics(frames: Sequence[Boxes3D]) -> dict[str, Floats]:
    """Samples of every quantity in `QUANTITIES`, by name.

    Args:
        frames: One set of boxes for each frame, with 2D boxes, truncation and occlusion.
    """
    return {name: quantity.measure(frames) for name, quantity in QUANTITIES.items()}


def distance(quantity: Quantity, first: Floats, second: Floats) -> float:
    """How far two sets of samples are apart; 0 is a perfect match."""
    if quantity.distance == "variation":
        shares = [np.histogram(samples, quantity.edges)[0] for samples in (first, second)]
        shares = [counts / max(counts.sum(), 1) for counts in shares]
        return float(0.5 * np.abs(shares[0] - shares[1]).sum())
    quantiles = (np.arange(20_000) + 0.5) / 20_000
    return float(np.abs(np.quantile(first, quantiles) - np.quantile(second, quantiles)).mean())


def compare(
    ours: Sequence[Boxes3D], kitti: Sequence[Boxes3D], splits: int = 10, seed: int = 0
) -> dict[str, dict[str, Any]]:
    """The distance between two sets of frames in every quantity, with a yardstick.

    Args:
        ours: Generated frames.
        kitti: Labelled frames.
        splits: How many random halvings of `kitti` the yardstick averages.
        seed: Of the halvings.

    Returns:
        JSON-able: for each quantity its ``distance``, its ``yardstick`` (the same distance between
        two random halves of KITTI), both ``means``, the ``unit`` and the ``kind`` of distance.
    """
    mine, real = statistics(ours), statistics(kitti)
    rng = np.random.default_rng(seed)
    yardsticks: dict[str, list[float]] = {name: [] for name in QUANTITIES}
    for _ in range(splits):
        order = rng.permutation(len(kitti))
        halves = [statistics([kitti[i] for i in half]) for half in np.array_split(order, 2)]
        for name, quantity in QUANTITIES.items():
            yardsticks[name].append(distance(quantity, halves[0][name], halves[1][name]))
    return {
        name: {
            "kind": quantity.distance,
            "unit": quantity.unit if quantity.distance == "wasserstein" else "",
            "distance": round(distance(quantity, mine[name], real[name]), 4),
            "yardstick": round(float(np.mean(yardsticks[name])), 4),
            "means": [round(float(mine[name].mean()), 4), round(float(real[name].mean()), 4)],
        }
        for name, quantity in QUANTITIES.items()
    }


def objects_per_frame(frames: Sequence[Boxes3D]) -> dict[str, float]:
    """Mean number of objects of each category in a frame."""
    names = np.concatenate([boxes.category for boxes in frames])
    return {name: round(float((names == name).sum()) / len(frames), 4) for name in CATEGORIES}


def occupied_goals(frames: Sequence[Boxes3D]) -> dict[str, float]:
    """Share of frames in which an obstacle covers the centre of each goal region."""
    covered = np.array([[_covers(boxes, goal) for goal in GOAL_CENTRES.values()] for boxes in frames])
    return dict(zip(GOAL_CENTRES, covered.mean(axis=0).round(4).tolist(), strict=True))


def _covers(boxes: Boxes3D, point: tuple[float, float]) -> bool:
    obstacles = boxes[np.isin(boxes.category, OBSTACLES)]
    offset = np.asarray(point) - obstacles.poses[:, :2]
    cos, sin = np.cos(obstacles.poses[:, 2]), np.sin(obstacles.poses[:, 2])
    along = np.abs(cos * offset[:, 0] + sin * offset[:, 1])
    across = np.abs(cos * offset[:, 1] - sin * offset[:, 0])
    return bool(((along <= obstacles.length / 2) & (across <= obstacles.width / 2)).any())


def _column(
    value: Callable[[Boxes3D], Floats], categories: Sequence[str]
) -> Callable[[Sequence[Boxes3D]], Floats]:
    """Samples of one value over all objects of some categories."""

    def measure(frames: Sequence[Boxes3D]) -> Floats:
        return np.concatenate(
            [value(boxes)[np.isin(boxes.category, categories)] for boxes in frames]
        )

    return measure


def _cars(frames: Sequence[Boxes3D]) -> Floats:
    return np.array([(boxes.category == "Car").sum() for boxes in frames], float)


def _image_height(boxes: Boxes3D) -> Floats:
    assert boxes.box2d is not None
    return np.asarray(boxes.box2d[:, 3] - boxes.box2d[:, 1])


def _truncated(frames: Sequence[Boxes3D]) -> Floats:
    shares = _column(lambda boxes: np.asarray(boxes.truncation), OBSTACLES)(frames)
    return np.asarray(shares[shares > 0])
