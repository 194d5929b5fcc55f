"""Targets of hand-placed objects lead back to them."""

from __future__ import annotations

from dataclasses import replace

import torch

from avsec_gym.perception.detectors.faster_rcnn.losses import TERMS, detection_terms
from avsec_gym.perception.detectors.faster_rcnn.network import RegionBoxOutput
from avsec_gym.perception.detectors.faster_rcnn.region_proposals import RegionProposals, RpnOutput
from avsec_gym.perception.detectors.faster_rcnn.targets import (
    BOX_DEVIATIONS,
    RegionSamples,
    draw_sampling,
)
from avsec_gym.perception.detectors.image_truth import ImageTruth
from avsec_gym.perception.nn.anchors import pyramid_anchors
from avsec_gym.perception.nn.box_coding import decode_boxes, overlaps
from avsec_gym.perception.nn.region_counts import SampleCount

OBJECTS = torch.tensor([[60.0, 30, 99, 59], [200, 40, 259, 89]])
VAN = torch.tensor([[120.0, 30, 159, 59]])
NEAR, FAR, ON_VAN = [62.0, 31, 101, 60], [10.0, 80, 40, 120], [121.0, 30, 160, 59]
TRUTH = ImageTruth(OBJECTS, torch.tensor([1, 0]), VAN)
COUNT = SampleCount(64, 0.5, 32, 0.25)


def _draw(truth: ImageTruth = TRUTH, count: SampleCount = COUNT) -> tuple[RpnOutput, RegionSamples]:
    shapes = [(128 // stride, 320 // stride) for stride in (4, 8, 16, 32, 64)]
    sizes, ratios = (12, 24, 48, 96, 192), (0.5, 1.0, 2.0)
    anchors = pyramid_anchors(shapes, (4, 8, 16, 32, 64), sizes, ratios).float()
    zeros = torch.zeros(1, len(anchors))
    rpn = RpnOutput(zeros, zeros[..., None].expand(1, -1, 4), anchors, 128, 320)
    regions = torch.tensor([[NEAR, FAR, ON_VAN, [0.0] * 4]])
    proposals = RegionProposals(regions, torch.tensor([[True, True, True, False]]))
    generator = torch.Generator().manual_seed(0)
    return rpn, draw_sampling(rpn, proposals, [truth], count, generator)


def test_anchors_on_objects_lead_to_them() -> None:
    rpn, sampling = _draw()
    true = sampling.anchor_labels[0] == 1
    decoded = decode_boxes(rpn.anchors[true], sampling.anchor_targets[0, true])
    shared = overlaps(decoded, OBJECTS)
    torch.testing.assert_close(shared.amax(1), torch.ones(len(decoded)))
    assert set(shared.argmax(1).tolist()) == {0, 1}


def test_what_is_like_an_object_is_no_background() -> None:
    rpn, sampling = _draw(count=replace(COUNT, anchors=100_000))
    false = sampling.anchor_labels[0] == 0
    assert false.any()
    assert (overlaps(rpn.anchors[false], VAN) < 0.5).all()
    without = _draw(replace(TRUTH, ignored=VAN[:0]), replace(COUNT, anchors=100_000))[1]
    assert (overlaps(rpn.anchors[without.anchor_labels[0] == 0], VAN) >= 0.5).any()


def test_regions_and_their_targets() -> None:
    _, sampling = _draw()
    rows = dict(zip(map(tuple, sampling.regions[0].tolist()), range(32), strict=True))
    labels = {box: int(sampling.labels[0, row]) for box, row in rows.items()}
    expected = {tuple(NEAR): 2, tuple(OBJECTS[0].tolist()): 2, tuple(OBJECTS[1].tolist()): 1}
    assert labels == expected | {tuple(FAR): 0}
    deltas = sampling.box_targets[0] * torch.tensor(BOX_DEVIATIONS)
    moved = decode_boxes(sampling.regions[0, rows[tuple(NEAR)]], deltas[rows[tuple(NEAR)]])
    torch.testing.assert_close(moved, OBJECTS[0])
    assert not deltas[rows[tuple(FAR)]].any()


def test_right_answers_cost_nothing() -> None:
    rpn, sampling = _draw()
    sure = 50.0
    perfect = replace(
        rpn,
        logits=sure * (2.0 * (sampling.anchor_labels == 1) - 1),
        deltas=sampling.anchor_targets,
    )
    logits = torch.nn.functional.one_hot(sampling.labels, 3) * sure
    deltas = sampling.box_targets[:, :, None].expand(-1, -1, 3, -1)
    terms = detection_terms(perfect, RegionBoxOutput(logits, deltas), sampling)
    assert tuple(terms) == TERMS
    assert all(float(term) < 1e-6 for term in terms.values())


def test_terms_by_plain_sums() -> None:
    rpn, sampling = _draw()
    generator = torch.Generator().manual_seed(1)
    rpn = replace(
        rpn,
        logits=torch.randn(rpn.logits.shape, generator=generator),
        deltas=torch.randn(rpn.deltas.shape, generator=generator),
    )
    boxes = RegionBoxOutput(
        torch.randn(1, 32, 3, generator=generator), torch.randn(1, 32, 3, 4, generator=generator)
    )
    terms = detection_terms(rpn, boxes, sampling)
    sums = dict.fromkeys(TERMS, 0.0)
    count = 0
    for i, label in enumerate(sampling.anchor_labels[0].tolist()):
        if label < 0:
            continue
        count += 1
        probability = torch.sigmoid(rpn.logits[0, i])
        sums["rpn_class"] -= float(torch.log(probability if label else 1 - probability))
        if label:
            for error in (rpn.deltas[0, i] - sampling.anchor_targets[0, i]).abs().tolist():
                sums["rpn_box"] += 4.5 * error**2 if error < 1 / 9 else error - 1 / 18
    for i, label in enumerate(sampling.labels[0].tolist()):
        sums["class"] -= float(boxes.class_logits[0, i].log_softmax(0)[label])
        if label:
            for error in (boxes.deltas[0, i, label] - sampling.box_targets[0, i]).abs().tolist():
                sums["box"] += 0.5 * error**2 if error < 1 else error - 0.5
    for name, value in sums.items():
        mean = value / (count if name.startswith("rpn") else 32)
        torch.testing.assert_close(float(terms[name]), mean, rtol=1e-4, atol=1e-5)
