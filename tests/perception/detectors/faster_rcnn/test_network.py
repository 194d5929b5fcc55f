"""Faster R-CNN: the layers as others count them, levels, proposals."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import nn

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.faster_rcnn.configuration import (
    RESNET50,
    RESNET101,
    SMALL,
    FasterRcnnConfiguration,
)
from avsec_gym.perception.detectors.faster_rcnn.network import FasterRcnnNetwork, region_levels
from avsec_gym.perception.detectors.faster_rcnn.region_proposals import RpnOutput, propose
from avsec_gym.perception.nn.box_coding import decode_boxes, overlaps
from avsec_gym.perception.nn.region_counts import ProposalCount

COCO = tuple(f"class{i}" for i in range(90))


@pytest.mark.parametrize(
    ("configuration", "parameters"),
    [
        # torchvision tells 41,755,286 of its fasterrcnn_resnet50_fpn, whose normalisations have
        # buffers instead of parameters; ResNet-101 has 17 bottlenecks more.
        (RESNET50, 41_755_286),
        (RESNET101, 41_755_286 + 17 * (2 * 1024 * 256 + 9 * 256 * 256)),
    ],
)
def test_parameters_of_the_published_networks(
    configuration: FasterRcnnConfiguration, parameters: int
) -> None:
    with torch.device("meta"):
        network = FasterRcnnNetwork(replace(configuration, categories=COCO))
    norms = [module for module in network.modules() if isinstance(module, nn.BatchNorm2d)]
    in_norms = sum(value.numel() for norm in norms for value in norm.parameters())
    assert sum(value.numel() for value in network.parameters()) - in_norms == parameters


def test_the_small_one_weighs_less_than_eight_megabytes_in_half_precision() -> None:
    with torch.device("meta"):
        state = FasterRcnnNetwork(SMALL).state_dict()
    assert 2 * sum(value.numel() for value in state.values()) < 8e6


def test_what_is_frozen_stays_so_in_training() -> None:
    with torch.device("meta"):
        network = FasterRcnnNetwork(RESNET50).requires_grad_(True).train()
    learned = {name for name, value in network.named_parameters() if value.requires_grad}
    assert not any(name.startswith(("body.0", "body.1.")) or ".bn" in name for name in learned)
    assert "body.2.0.0.conv1.weight" in learned


def test_levels_of_regions() -> None:
    """Lin et al., equation 1: 224 pixels belong to P4, half of it to P3."""
    sides = torch.tensor([30.0, 111.9, 112, 223.9, 224, 448, 3000])
    boxes = torch.stack([torch.zeros(7), torch.zeros(7), sides - 1, sides - 1], 1)
    assert region_levels(boxes, 224.0).tolist() == [2, 2, 3, 3, 4, 5, 5]


def test_proposals_agree_with_a_plain_loop() -> None:
    generator = torch.Generator().manual_seed(3)
    corner = 70 * torch.rand(80, 2, generator=generator, dtype=torch.float64)
    anchors = torch.cat((corner, corner + 20), 1)
    deltas = 0.3 * torch.randn(2, 80, 4, generator=generator, dtype=torch.float64)
    logits = torch.randn(2, 80, generator=generator, dtype=torch.float64)
    output = RpnOutput(logits, deltas, anchors, 60, 90)
    found = propose(output, ProposalCount(70, 15), 0.4, least_side=8.0)
    for image in range(2):
        boxes = decode_boxes(anchors, deltas[image])
        boxes[:, 0::2] = boxes[:, 0::2].clamp(0, 89)
        boxes[:, 1::2] = boxes[:, 1::2].clamp(0, 59)
        kept: list[int] = []
        for k in logits[image].argsort(descending=True)[:70].tolist():
            x1, y1, x2, y2 = boxes[k].tolist()
            shared = overlaps(boxes[[k]], boxes[kept])
            if min(x2 - x1, y2 - y1) >= 8 and not (shared > 0.4).any():
                kept.append(k)
        kept = kept[:15]
        assert found.valid[image].sum() == len(kept)
        torch.testing.assert_close(found.regions[image, : len(kept)], boxes[kept])


def test_sizes_that_images_are_resized_to() -> None:
    assert RESNET50.size_for(375, 1242) == (402, 1333)
    assert RESNET50.size_for(1000, 1200) == (800, 960)
    assert SMALL.size_for(375, 1242) == (192, 640)


def test_impossible_configurations_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="category"):
        replace(SMALL, categories=())
    with pytest.raises(ConfigurationError, match="freeze"):
        replace(SMALL, frozen_stages=6)
    with pytest.raises(ConfigurationError, match="resnet101, resnet50, small"):
        FasterRcnnConfiguration.preset("vgg16")
