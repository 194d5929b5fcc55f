"""Farthest points by a plain search, and what makes them a good choice."""

from __future__ import annotations

import numpy as np
import torch
from scipy.spatial import cKDTree

from avsec_gym.geometry import Floats
from avsec_gym.perception.nn.point_sampling import farthest_points


def by_search(points: Floats, count: int) -> list[int]:
    chosen = [0]
    while len(chosen) < count:
        distances, _ = cKDTree(points[chosen]).query(points)
        chosen.append(int(np.argmax(distances)))
    return chosen


def test_each_is_the_farthest_from_those_before() -> None:
    clouds = np.random.default_rng(0).uniform(0, [40, 3, 50], (3, 200, 3)).astype(np.float32)
    found = farthest_points(torch.from_numpy(clouds), 30)
    for cloud, indices in zip(clouds, found.tolist(), strict=True):
        assert indices == by_search(cloud.astype(float), 30)


def test_all_points_are_covered_and_those_chosen_are_apart() -> None:
    cloud = torch.rand(1, 500, 3, generator=torch.Generator().manual_seed(0))
    chosen = cloud[0, farthest_points(cloud, 40)[0]]
    reach = torch.cdist(cloud[0], chosen).min(1).values.max()
    apart = torch.cdist(chosen, chosen) + 9 * torch.eye(40)
    # The defining property of the greedy choice: nothing is farther than the chosen are apart.
    assert reach <= apart.min() + 1e-6


def test_more_than_there_are() -> None:
    cloud = torch.rand(1, 5, 3, generator=torch.Generator().manual_seed(0))
    found = farthest_points(cloud, 8)
    assert found.shape == (1, 8)
    assert set(found[0].tolist()) == set(range(5))
