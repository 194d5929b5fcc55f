"""Targets by plain loops over other libraries' geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
import torch
from torch import Tensor

from avsec_gym.geometry import box_corners
from avsec_gym.perception.detectors.pointrcnn.configuration import RegionSampling
from avsec_gym.perception.detectors.pointrcnn.proposals import in_proposals, overlaps
from avsec_gym.perception.detectors.pointrcnn.targets import point_targets, region_targets

MakeScene = Callable[[int], Any]
SAMPLING = RegionSampling(40)


@pytest.fixture
def objects(scene: MakeScene) -> Tensor:
    return torch.from_numpy(scene(0).rows).float()


def proposals_about(objects: Tensor, far: int = 60) -> Tensor:
    """Some on the objects, some touching them, others far away."""
    generator = torch.Generator().manual_seed(0)
    near = objects.repeat(20, 1)
    near[:, :3] += 0.8 * torch.randn(60, 3, generator=generator) * torch.tensor([1, 0.3, 1])
    away = objects.repeat(far // 3, 1) + torch.tensor([60.0, 0, 0, 0, 0, 0, 0])
    return torch.cat([near, away])


def holders(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Which points shapely and a look at heights find in a box."""
    bottom = shapely.Polygon(box_corners(box[:3], box[3:6], box[6])[:4, [0, 2]])
    beside = shapely.contains(bottom, shapely.points(points[:, [0, 2]]))
    return beside & (points[:, 1] <= box[1]) & (points[:, 1] >= box[1] - box[3])


def test_points_on_cars_tell_their_car_and_those_beside_it_nothing(objects: Tensor) -> None:
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(2000, 3, generator=generator) * torch.tensor([12, 3, 18.0])
    points -= torch.tensor([6, 0.5, -6.0])
    hidden = objects[:1] + torch.tensor([0, 0, 6.0, 0, 0, 0, 0])
    targets = point_targets(points, objects, 0.2, ignored=hidden)
    places = points.double().numpy()
    margin = np.array([0, 0.2, 0, 0.4, 0.4, 0.4, 0])
    unsure = [holders(places, box + margin) for box in torch.cat([objects, hidden]).numpy()]
    expected = np.where(np.any(unsure, axis=0), -1, 0)
    for box in objects.double().numpy():
        inside = holders(places, box)
        expected[inside] = 1
        middle = box[:3] - [0, box[3] / 2, 0]
        told = targets.boxes[torch.from_numpy(inside)]
        np.testing.assert_allclose(told[:, :3], middle - places[inside], atol=1e-5)
        np.testing.assert_allclose(told[:, 3:], np.tile(box[3:], (len(told), 1)), atol=1e-5)
    np.testing.assert_array_equal(targets.labels, expected)
    assert not targets.boxes[targets.labels < 1].any()
    assert min((expected == label).sum() for label in (-1, 0, 1)) > 20


def test_without_objects_everything_is_background() -> None:
    targets = point_targets(torch.rand(10, 3), torch.zeros(0, 7), 0.2)
    assert not targets.labels.any()
    regions = region_targets(torch.rand(5, 7) + 1, torch.zeros(0, 7), SAMPLING)
    assert regions.regions.shape == (40, 7)
    assert not regions.labels.any()
    assert not regions.has_box.any()


def test_labels_are_what_the_overlaps_say(objects: Tensor) -> None:
    torch.manual_seed(0)
    targets = region_targets(proposals_about(objects), objects, SAMPLING)
    most, owner = overlaps(targets.regions, objects).max(1)
    assert targets.regions.shape == (40, 7)
    # A proposal keeps the object that it lay on when it was drawn.
    own = in_proposals(objects[owner], targets.regions)
    learned = targets.has_box
    torch.testing.assert_close(targets.boxes[learned], own[learned])
    assert (most[learned] > 0.55).all()
    assert (most[targets.labels == 1] > 0.6).all()
    assert (most[targets.labels == 0] < 0.45 + 1e-6).all()
    assert 12 < learned.sum() <= 21
    assert (targets.labels == 0).sum() > 15


def test_half_lie_on_objects_and_four_fifths_of_the_others_touch_them(objects: Tensor) -> None:
    torch.manual_seed(0)
    small = replace(SAMPLING, regions=10)
    proposals = proposals_about(objects)
    assert (overlaps(proposals, objects).max(1).values > 0.55).sum() >= 5
    for _ in range(20):
        targets = region_targets(proposals, objects, small)
        far = targets.regions[:, 0] > 30
        assert far.sum() == 1
        assert targets.has_box.sum() >= 4
        assert (targets.labels[far] == 0).all()


def test_shaken_proposals_differ_from_the_drawn_ones_but_still_lie_on_their_objects(
    objects: Tensor,
) -> None:
    torch.manual_seed(0)
    # Nothing but the objects themselves, and a far one.
    away = objects[:1] + torch.tensor([60.0, 0, 0, 0, 0, 0, 0])
    targets = region_targets(away, objects, replace(SAMPLING, shakes=30))
    on_object = targets.regions[:, 0] < 30
    assert on_object.sum() == 3
    assert targets.has_box[on_object].all()
    torch.manual_seed(0)
    again = region_targets(away, objects, replace(SAMPLING, shakes=30))
    assert torch.equal(targets.regions, again.regions)
    distances = torch.cdist(targets.regions[on_object], objects).min(1).values
    assert (distances > 0).any()


def test_all_on_objects_leaves_no_background(objects: Tensor) -> None:
    torch.manual_seed(0)
    targets = region_targets(objects, objects, SAMPLING)
    assert len(targets.regions) == 40
    assert targets.has_box.float().mean() > 0.9
