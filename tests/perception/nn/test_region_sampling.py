"""Anchors' labels against the paper's rules, one by one."""

from __future__ import annotations

import torch

from avsec_gym.perception.nn.box_coding import overlaps
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.nn.region_sampling import (
    anchor_labels,
    sampled_labels,
    sampled_regions,
)


def test_labels_by_plain_loops() -> None:
    generator = torch.Generator().manual_seed(0)
    corner = 90 * torch.rand(300, 2, generator=generator) - 5
    anchors = torch.cat((corner, corner + 12 + 18 * torch.rand(300, 2, generator=generator)), 1)
    objects = torch.tensor([[20.0, 30, 45, 50], [50, 10, 74, 40], [3, 80, 5, 82]])
    labels, owner = anchor_labels(anchors, objects, (100, 110))
    shared = overlaps(anchors, objects)
    inside = [x1 >= 0 and y1 >= 0 and x2 < 110 and y2 < 100 for x1, y1, x2, y2 in anchors.tolist()]
    best = [max(float(shared[i, j]) for i in range(300) if inside[i]) for j in range(len(objects))]
    for i in range(300):
        most = float(shared[i].max())
        is_best = any(float(shared[i, j]) == best[j] > 0 for j in range(len(objects)))
        if not inside[i]:
            expected = -1
        elif most >= 0.7 or is_best:
            expected = 1
        else:
            expected = 0 if most < 0.3 else -1
        assert labels[i] == expected
        if inside[i] and most > 0:
            assert shared[i, owner[i]] == most
    assert {-1, 0, 1} == set(labels.tolist())


def test_anchors_may_leave_the_image() -> None:
    anchors = torch.tensor([[-20.0, 0, 20, 20], [-9, 0, 21, 20], [40, 0, 60, 20]])
    objects = torch.tensor([[0.0, 0, 20, 20]])
    assert anchor_labels(anchors, objects)[0].tolist() == [-1, 1, 0]
    assert anchor_labels(anchors, objects, (30, 80))[0].tolist() == [-1, -1, 0]


def test_samples_have_their_shares() -> None:
    labels = torch.tensor([1] * 10 + [0] * 50 + [-1] * 5)
    sample = sampled_labels(labels, SampleCount(anchors=16, true_anchors=0.25), None)
    assert ((sample == 1).sum(), (sample == 0).sum()) == (4, 12)
    assert torch.equal(sample[sample >= 0], labels[sample >= 0])
    few = sampled_labels(labels[8:], SampleCount(anchors=16), None)
    assert ((few == 1).sum(), (few == 0).sum()) == (2, 14)


def test_regions_are_drawn_again_where_they_are_few() -> None:
    true = torch.tensor([True, True, False, False, False])
    unclear = torch.tensor([False, False, False, False, True])
    count = SampleCount(regions=12, true_regions=0.25)
    picked = sampled_regions(true, ~true & ~unclear, count, torch.Generator().manual_seed(0))
    assert picked[:2].tolist() == [0, 1]
    assert len(picked) == 12
    assert set(picked[2:].tolist()) == {2, 3}
