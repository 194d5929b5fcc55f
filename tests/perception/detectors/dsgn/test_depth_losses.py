"""What depth costs, against numbers worked out by hand and the instances of a drawn scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import box_corners, project
from avsec_gym.perception.detectors.dsgn.depth_losses import depth_loss, on_objects, plane_loss

BINS = torch.tensor([40.0, 20.0, 10.0, 5.0], dtype=torch.float64)


def test_depth_counts_only_what_is_known_and_within_reach() -> None:
    depth = torch.tensor([[10.0, 10.5, 30.0, 5.0, 7.0]], requires_grad=True)
    true = torch.tensor([[10.0, 10.0, 27.0, 80.0, 0.0]])
    loss = depth_loss(depth, true, 2.0, 40.4)
    assert loss.item() == pytest.approx((0 + 0.125 + 2.5) / 3)
    loss.backward()
    assert depth.grad[0, 3:].tolist() == [0.0, 0.0]


def test_two_planes_share_a_depth_between_them() -> None:
    logits = torch.log(torch.tensor([0.1, 0.6, 0.2, 0.1], dtype=torch.float64))[None, :, None, None]
    one = torch.ones(1, 1, 1, dtype=torch.float64)
    # 12 m: 0.2 of the way from 10 to 20 m.
    loss = plane_loss(logits, BINS, 12 * one, one)
    assert loss.item() == pytest.approx(-0.2 * math.log(0.6) - 0.8 * math.log(0.2))
    for depth, probability in ((40.0, 0.1), (20.0, 0.6), (5.0, 0.1)):
        loss = plane_loss(logits, BINS, depth * one, one)
        assert loss.item() == pytest.approx(-math.log(probability))


def test_what_two_planes_share_is_expected_where_it_is() -> None:
    """The loss is least where the expectation is the true depth."""
    logits = torch.zeros(1, 4, 1, 1, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([logits], max_iter=200, line_search_fn="strong_wolfe")
    true = torch.full((1, 1, 1), 26.0, dtype=torch.float64)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = plane_loss(logits, BINS, true, torch.ones_like(true))
        loss.backward()
        return loss

    optimiser.step(closure)
    expected = (logits.softmax(1)[0, :, 0, 0] * BINS).sum().item()
    assert expected == pytest.approx(26.0, abs=0.05)


def test_pixels_count_by_their_weights_and_only_within_the_bins() -> None:
    logits = torch.randn(1, 4, 1, 5, dtype=torch.float64, requires_grad=True)
    true = torch.tensor([[[12.0, 33.0, 0.0, 41.0, 4.9]]], dtype=torch.float64)
    weight = torch.tensor([[[8.0, 1.0, 8.0, 8.0, 8.0]]], dtype=torch.float64)
    each = [
        plane_loss(logits[..., i : i + 1], BINS, true[..., i : i + 1], weight[..., :1]).item()
        for i in range(2)
    ]
    loss = plane_loss(logits, BINS, true, weight)
    assert loss.item() == pytest.approx((8 * each[0] + each[1]) / 9)
    loss.backward()
    assert (logits.grad[..., 2:] == 0).all()
    nothing = plane_loss(logits, BINS, torch.zeros_like(true), weight)
    assert nothing.item() == 0


def test_gradient_of_the_planes_agrees_with_finite_differences() -> None:
    logits = torch.randn(2, 4, 2, 3, dtype=torch.float64, requires_grad=True)
    true = torch.rand(2, 2, 3, dtype=torch.float64) * 45
    weight = torch.rand(2, 2, 3, dtype=torch.float64) + 0.1
    assert torch.autograd.gradcheck(lambda x: plane_loss(x, BINS, true, weight), (logits,))


def test_pixels_of_cars_are_those_that_show_them(scene: Callable[[int], Any]) -> None:
    made = scene(5)
    projection = made.batch.left_projection
    depth = projection[:, :1, :1] * 0.54 / made.disparity
    shown = on_objects(depth, projection, [made.boxes], 1)[0].numpy()
    # The scene's cars stand on a road at 1.65 m: whatever is higher and not far away shows one.
    v = np.arange(shown.shape[0])[:, None]
    height = (v - projection[0, 1, 2].item()) * depth[0].numpy() / projection[0, 1, 1].item()
    expected = (height < 1.5) & (depth[0].numpy() < 30)
    # Beside tyres and wheels, where the road is as near as they are.
    assert (shown == expected).mean() > 0.98
    assert expected.sum() > 500
    coarse = on_objects(depth[:, ::4, ::4], projection, [made.boxes], 4)[0].numpy()
    assert (coarse == shown[::4, ::4]).mean() > 0.995


def test_a_turned_box_holds_its_own_places_only() -> None:
    projection = torch.tensor([[700.0, 0, 300, 40], [0, 700, 100, 0.2], [0, 0, 1, 0.0]])[None]
    box = Boxes3D(
        np.array([[2.0, 1.7, 15.0]]), np.array([[1.5, 1.6, 4.0]]), np.array([0.6]),
        np.ones(1), np.array(["Car"]),
    )  # fmt: skip
    corners = box_corners(box.location, box.dimensions, box.rotation_y)[0]
    inside, outside = (
        box.location[0] - [0, 0.75, 0] + k * (corners - corners.mean(0)) for k in (0.9, 1.3)
    )
    for places, expected in ((inside, True), (outside, False)):
        pixels = np.round(project(projection[0].numpy(), places)[0]).astype(int)
        depth = torch.zeros(1, 300, 700)
        for (u, v), (_, _, z) in zip(pixels, places, strict=True):
            depth[0] = 0
            depth[0, v, u] = z
            found = on_objects(depth, projection, [box], 1)
            assert bool(found[0, v, u]) == expected
            assert found.sum() == expected


def test_pixels_of_several_images_are_those_of_each(scene: Callable[[int], Any]) -> None:
    made = [scene(number) for number in (5, 6, 7)]
    depth = torch.cat(
        [each.batch.left_projection[:, :1, :1] * 0.54 / each.disparity for each in made]
    )
    projection = torch.cat([each.batch.left_projection for each in made])
    objects = [made[0].boxes, made[1].boxes[:0], made[2].boxes[:1]]
    depth = depth[:, ::2, ::2]
    together = on_objects(depth, projection, objects, 2)
    assert together[0].any()
    assert not together[1].any()
    for image, boxes in enumerate(objects):
        one = slice(image, image + 1)
        assert torch.equal(together[one], on_objects(depth[one], projection[one], [boxes], 2))
