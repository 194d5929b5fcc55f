"""The points in proposals by plain loops; how a scene is turned does not matter to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.geometry import box_corners
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput
from avsec_gym.perception.detectors.pointrcnn.refinement_network import (
    RefinementNetwork,
    region_points,
)

MakeScene = Callable[[int], Any]
NOWHERE = [90.0, 1.6, 90, 1.5, 1.6, 4, 0.3]


@pytest.fixture
def rows(scene: MakeScene) -> Tensor:
    return torch.cat([torch.from_numpy(scene(0).rows).float(), torch.tensor([NOWHERE])])


def output_of(points: Tensor) -> PointOutput:
    generator = torch.Generator().manual_seed(0)
    features = torch.randn(1, len(points), 32, generator=generator, requires_grad=True)
    logits = torch.randn(1, len(points), generator=generator, requires_grad=True)
    return PointOutput(points[None], features, logits, torch.zeros(1, len(points), 76))


def scattered() -> Tensor:
    drawn = np.random.default_rng(0).uniform([-6, 0, 6], [6, 2, 22], (512, 3))
    return torch.from_numpy(drawn).float()


def test_as_by_loops(tiny: PointRcnnConfiguration, rows: Tensor) -> None:
    output = output_of(scattered())
    found = region_points(output, [rows], tiny)
    assert found.places.shape == (4, 48, 3)
    assert found.features.shape == (4, 48, 2 + 32)
    assert found.is_empty.tolist() == [False, False, False, True]
    for number, (x, y, z, height, width, length, heading) in enumerate(rows[:3].tolist()):
        expected = []
        for index, (px, py, pz) in enumerate(output.points[0].tolist()):
            along = np.cos(heading) * (px - x) - np.sin(heading) * (pz - z)
            across = np.sin(heading) * (px - x) + np.cos(heading) * (pz - z)
            beside = abs(along) <= length / 2 + 1 and abs(across) <= width / 2 + 1
            if beside and y - height - 1 <= py <= y + 1:
                is_object = float(output.scores[0, index] > 0.3)
                distance = np.sqrt(px**2 + py**2 + pz**2) / 70 - 0.5
                said = output.features[0, index].tolist()
                expected.append([along, py - y, across, is_object, distance, *said])
        assert len(expected) > 10
        expected = [expected[k % len(expected)] for k in range(48)]
        both = torch.cat([found.places[number], found.features[number]], 1)
        np.testing.assert_allclose(both, expected, atol=1e-5)
    assert not found.places[3].any()
    assert not found.features.requires_grad


def test_a_turned_scene_looks_the_same_from_its_boxes(
    tiny: PointRcnnConfiguration, rows: Tensor
) -> None:
    points, angle = scattered(), 0.7
    cos, sin = np.cos(angle), np.sin(angle)
    turn = torch.tensor([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]]).float()
    turned = torch.cat([rows[:3, :3] @ turn, rows[:3, 3:6], rows[:3, 6:] + angle], 1)
    corners, other = (box_corners(r[:, :3], r[:, 3:6], r[:, 6]) for r in (rows[:3], turned))
    np.testing.assert_allclose(other, corners @ turn.double().numpy(), atol=1e-5)
    one = region_points(output_of(points), [rows[:3]], tiny)
    two = region_points(output_of(points @ turn), [turned], tiny)
    torch.testing.assert_close(one.places, two.places, atol=1e-4, rtol=1e-4)
    torch.testing.assert_close(one.features, two.features, atol=1e-5, rtol=1e-4)


def test_one_answer_for_each_proposal_and_finite_gradients(
    tiny: PointRcnnConfiguration, rows: Tensor
) -> None:
    torch.manual_seed(0)
    plain = replace(tiny, refinement=replace(tiny.refinement, is_normalised=False))
    network = RefinementNetwork(plain)
    output = network(region_points(output_of(scattered()), [rows], plain))
    assert output.logits.shape == (4,)
    assert output.codes.shape == (4, 46)
    (output.logits.sum() + output.codes.square().sum()).backward()
    for name, value in network.named_parameters():
        assert value.grad is not None, name
        assert torch.isfinite(value.grad).all(), name
