"""Residual bodies: resolutions, what is frozen, which way signals go."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.configuration import SMALL
from avsec_gym.perception.nn.resnet import Bottleneck, freeze, residual_stages, stem

BATCH = replace(SMALL, normalisation="batch", edges="zeros")


def test_resolutions_of_the_published_input() -> None:
    """600 x 1987 pixels, as KITTI's 375 x 1242 become; the pooling rounds up."""
    configuration = replace(SMALL, stem_channels=8, stage_channels=(8, 8, 8, 8))
    images = torch.zeros(1, 3, 600, 1987)
    features = stem(configuration)(images)
    shapes = []
    for stage in residual_stages(configuration):
        features = stage(features)
        shapes.append(tuple(features.shape[-2:]))
    assert shapes == [(150, 497), (75, 249), (38, 125), (19, 63)]


def test_the_first_convolution_has_the_stride() -> None:
    """So a bottleneck of stride 2 never looks at pixels of odd rows and columns."""
    torch.manual_seed(0)
    block = Bottleneck(16, 8, 2, BATCH).eval()
    inputs = torch.randn(1, 16, 8, 8)
    changed = inputs.clone()
    changed[:, :, 1::2] += 1
    changed[:, :, :, 1::2] += 1
    torch.testing.assert_close(block(changed), block(inputs), rtol=0, atol=0)


def test_a_bottleneck_without_weights_is_the_identity() -> None:
    block = Bottleneck(32, 8, 1, BATCH).eval()
    torch.nn.init.zeros_(block.bn3.weight)
    inputs = torch.rand(2, 32, 5, 6)
    torch.testing.assert_close(block(inputs), inputs)


def test_what_is_frozen_keeps_statistics_but_passes_gradients() -> None:
    part = stem(replace(SMALL, normalisation="frozen_batch"))
    freeze(part)
    before = {key: value.clone() for key, value in part.state_dict().items()}
    images = torch.rand(1, 3, 16, 16, requires_grad=True)
    part(images).sum().backward()
    assert images.grad is not None
    assert images.grad.abs().max() > 0
    assert all(parameter.grad is None for parameter in part.parameters())
    assert all(torch.equal(before[key], value) for key, value in part.state_dict().items())


def test_groups_need_channels_that_divide() -> None:
    with pytest.raises(ConfigurationError, match="multiple of 8"):
        stem(replace(SMALL, stem_channels=12))


@pytest.mark.parametrize("edges", ["zeros", "replicate"])
def test_zeros_beyond_the_edge_make_the_outermost_cells_others(edges: str) -> None:
    """An even picture stays even with replication only; else groups are scaled by their edges."""
    torch.manual_seed(0)
    configuration = replace(SMALL, edges=edges)  # type: ignore[arg-type]
    features = torch.relu(stem(configuration)[0](torch.ones(1, 3, 64, 64)))
    assert (features.std((2, 3)).max() < 1e-5) == (edges == "replicate")


def test_residual_blocks_begin_as_identities() -> None:
    torch.manual_seed(0)
    stage = residual_stages(SMALL)[2]
    features = torch.relu(torch.randn(1, 4 * SMALL.stage_channels[1], 8, 8))
    first, *others = stage[0]
    after = first(features)
    for block in others:
        torch.testing.assert_close(block(after), after)
