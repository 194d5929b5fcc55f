"""Stereo R-CNN as a whole: the published one's layers and figures, gradients to the pixels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.configuration import (
    RESNET101,
    SMALL,
    StereoRcnnConfiguration,
)
from avsec_gym.perception.detectors.stereo_rcnn.network import StereoRcnnNetwork, merge
from avsec_gym.perception.nn.region_counts import ProposalCount
from avsec_gym.perception.nn.resnet import Bottleneck

TINY = replace(
    RESNET101,
    name="tiny",
    stem_channels=8,
    stage_blocks=(1, 1, 1, 1),
    stage_channels=(8, 8, 8, 8),
    pyramid_channels=8,
    rpn_channels=8,
    training_proposals=ProposalCount(200, 20),
    test_proposals=ProposalCount(100, 10),
    box_channels=16,
    keypoint_channels=8,
    keypoint_convolutions=1,
    he_initialisation=True,
)
"""The published classes and switches, with small numbers."""


def _network(configuration: StereoRcnnConfiguration) -> StereoRcnnNetwork:
    torch.manual_seed(0)
    return StereoRcnnNetwork(configuration)


def _pair(height: int, width: int, dtype: torch.dtype = torch.float32) -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(1)
    left, right = torch.randn(2, 1, 3, height, width, generator=generator, dtype=dtype)
    return left, right


def test_parameters_of_the_published_network() -> None:
    with torch.device("meta"):
        network = StereoRcnnNetwork(RESNET101)
    assert sum(parameter.numel() for parameter in network.parameters()) == 105_891_446


def test_layers_of_the_published_network(shared: Path) -> None:
    with torch.device("meta"):
        network = StereoRcnnNetwork(RESNET101)
    ours = {f"{key} {tuple(value.shape)}" for key, value in network.state_dict().items()}
    assert ours == set((shared / "parity" / "stereo_rcnn_keys.txt").read_text().splitlines())


def test_the_small_one_weighs_less_than_eight_megabytes_in_half_precision() -> None:
    assert 2 * sum(value.numel() for value in _network(SMALL).state_dict().values()) < 8e6


def test_a_coarse_level_is_enlarged_about_the_image() -> None:
    """Pixels' edges agree (align_corners False): a ramp stays one, away from the border."""
    coarse = torch.arange(10.0).expand(1, 1, 4, 10)
    fine = merge(coarse, torch.ones(1, 1, 8, 20))
    expected = (torch.arange(20.0) + 0.5) / 2 - 0.5 + 1
    torch.testing.assert_close(fine[0, 0, 3, 1:-1], expected[1:-1])


def test_forward_joins_the_parts() -> None:
    network, (left, right) = _network(TINY).eval(), _pair(64, 128)
    output = network(left, right)
    assert output.proposals.left.shape == (1, 10, 4)
    assert output.boxes.class_probabilities.shape == (1, 10, 2)
    assert output.boxes.box_deltas.shape == (1, 10, 2, 6)
    assert output.boxes.dimensions_orientation.shape == (1, 10, 2, 5)
    assert output.keypoints.logits.shape == (1, 10, 6, 28)
    pyramids = network.features(left), network.features(right)
    boxes, keypoints = network.heads(*pyramids, output.proposals.left, output.proposals.right)
    torch.testing.assert_close(boxes.box_deltas, output.boxes.box_deltas, atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(keypoints.logits, output.keypoints.logits, atol=1e-4, rtol=1e-4)


def test_a_pair_does_not_depend_on_its_batch() -> None:
    network = _network(TINY).eval().double()
    left, right = _pair(64, 128, torch.float64)
    alone = network(left, right)
    together = network(torch.cat((right, left)), torch.cat((left, right)))
    torch.testing.assert_close(together.proposals.left[1:], alone.proposals.left)
    torch.testing.assert_close(together.boxes.class_logits[1:], alone.boxes.class_logits)
    torch.testing.assert_close(together.keypoints.logits[1:], alone.keypoints.logits)


def test_training_keeps_what_is_frozen() -> None:
    network = _network(TINY).train()
    for module in network.modules():
        if isinstance(module, Bottleneck):
            torch.nn.init.ones_(module.bn3.weight)  # Else the first step changes these alone.
    before = {key: value.clone() for key, value in network.state_dict().items()}
    optimizer = torch.optim.SGD(network.parameters(), 0.1)
    output = network(*_pair(64, 128))
    assert output.proposals.left.shape == (1, 20, 4)
    (output.rpn.logits.square().mean() + output.boxes.class_logits.square().mean()).backward()
    optimizer.step()
    changed = {
        key for key, value in network.state_dict().items() if not torch.equal(value, before[key])
    }
    assert "RCNN_layer2.0.0.conv1.weight" in changed
    assert "RCNN_toplayer.weight" in changed
    assert not any(".bn" in key or "downsample.1" in key for key in changed)
    assert not any(key.startswith(("RCNN_layer0", "RCNN_layer1")) for key in changed)


def test_gradients_reach_the_pixels_of_both_views() -> None:
    network = _network(SMALL).eval()
    left, right = (image.requires_grad_() for image in _pair(*SMALL.size_for(375, 1242)))
    output = network.rpn(*network.pair_features(left, right))
    output.logits.square().sum().backward()
    for image in (left, right):
        assert image.grad is not None
        assert (image.grad != 0).any(1).double().mean() >= 0.99


@pytest.mark.usefixtures("smooth_activations")
@pytest.mark.parametrize("configuration", [TINY, replace(TINY, normalisation="group")])
def test_gradient_agrees_with_finite_differences(configuration: StereoRcnnConfiguration) -> None:
    """In double precision, with the proposals of the unchanged pair."""
    network = _network(configuration).eval().double()
    left, right = (image.requires_grad_() for image in _pair(64, 128, torch.float64))
    regions = network(left, right).proposals

    def loss(left: Tensor, right: Tensor) -> Tensor:
        pyramids = network.pair_features(left, right)
        rpn = network.rpn(*pyramids)
        boxes, keypoints = network.heads(*pyramids, regions.left, regions.right)
        outputs = (
            rpn.logits,
            rpn.deltas,
            boxes.class_logits,
            boxes.box_deltas,
            boxes.dimensions_orientation,
            keypoints.logits,
        )
        return sum((output.square().mean() for output in outputs), torch.zeros(()))

    loss(left, right).backward()
    generator = torch.Generator().manual_seed(2)
    for image in (left, right):
        assert image.grad is not None
        direction = torch.randn(image.shape, generator=generator, dtype=torch.float64)
        step = 1e-6 * direction
        with torch.no_grad():
            both = [
                loss(left + sign * step, right)
                if image is left
                else loss(left, right + sign * step)
                for sign in (1, -1)
            ]
        slope = (both[0] - both[1]) / 2e-6
        torch.testing.assert_close((image.grad * direction).sum(), slope, rtol=1e-4, atol=1e-9)


def test_sizes_that_images_are_resized_to() -> None:
    assert RESNET101.size_for(375, 1242) == (600, 1987)
    assert SMALL.size_for(375, 1242) == SMALL.input_size


@pytest.mark.parametrize(
    "change",
    [
        {"categories": ()},
        {"crossed_scores": True, "anchor_ratios": (0.5, 2.0)},
        {"frozen_stages": 6},
    ],
)
def test_numbers_that_do_not_go_together(change: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError):
        replace(SMALL, **change)  # type: ignore[arg-type]


def test_an_unknown_preset_names_those_there_are() -> None:
    with pytest.raises(ConfigurationError, match="resnet101, small"):
        StereoRcnnConfiguration.preset("resnet50")
