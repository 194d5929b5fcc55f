"""Image features with and without their pyramid."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration, FeatureExtraction

_TINY = FeatureConfiguration(
    first=4,
    stages=((4, 1), (8, 1), (8, 1), (8, 1)),
    windows=((8, 16), (4, 4)),
    pooled=4,
    matching=(8, 6),
    semantic=(8, 5),
)


def test_sizes():
    extraction = FeatureExtraction(_TINY)
    joined = extraction(torch.randn(2, 3, 32, 64))
    assert joined.shape == (2, 8 + 8 + 4 + 4, 8, 16)
    assert extraction.lastconv(joined).shape == (2, 6, 8, 16)
    assert extraction.rpnconv(joined).shape == (2, 5, 8, 16)


def test_the_pyramid_carries_one_corner_to_the_other():
    torch.manual_seed(0)
    reached = []
    for pyramid in (True, False):
        extraction = FeatureExtraction(
            replace(_TINY, pyramid=pyramid, windows=((8, 48), (4, 4)))
        ).eval()
        images = torch.randn(1, 3, 32, 192, requires_grad=True)
        extraction(images)[0, :, -1, -1].sum().backward()
        reached.append(bool(images.grad[0, :, :8, :8].abs().sum() > 0))
    assert reached == [True, False]


def test_the_same_weights_run_without_the_pyramid():
    torch.manual_seed(0)
    extraction = FeatureExtraction(_TINY).eval()
    bare = FeatureExtraction(replace(_TINY, pyramid=False)).eval()
    bare.load_state_dict(extraction.state_dict())
    images = torch.randn(1, 3, 32, 64)
    torch.testing.assert_close(bare(images)[:, :16], extraction(images)[:, :16])
    assert not bare(images)[:, 16:].any()
    assert extraction(images)[:, 16:].any()


def test_the_largest_window_comes_last():
    extraction = FeatureExtraction(_TINY).eval()
    joined = extraction(torch.randn(1, 3, 32, 64))
    largest = joined[0, -4:]  # one mean over everything
    assert torch.allclose(largest, largest[:, :1, :1])


def test_stages_that_do_not_exist_are_refused():
    with pytest.raises(ConfigurationError, match="four stages"):
        replace(_TINY, joined=(2, 5))
