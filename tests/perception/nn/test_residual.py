"""Residual blocks."""

from __future__ import annotations

import torch

from avsec_gym.perception.nn.residual import BasicBlock, residual_stage


def test_a_block_that_adds_nothing_lets_negative_values_pass():
    block = BasicBlock(8, 8, groups=4)
    torch.nn.init.zeros_(block.conv2[1].weight)
    features = torch.randn(1, 8, 6, 10)
    torch.testing.assert_close(block(features), features)


def test_what_two_convolutions_make_of_the_input_is_added_to_it():
    torch.manual_seed(0)
    features = torch.randn(1, 8, 6, 10)
    block = BasicBlock(8, 8, groups=4)
    added = block(features) - features
    torch.testing.assert_close(added, block.conv2(block.conv1(features)))
    assert added.abs().mean() > 0.1
    wider = BasicBlock(8, 16, groups=4, stride=2)
    assert wider.downsample is not None
    rest = wider(features) - wider.conv2(wider.conv1(features))
    torch.testing.assert_close(rest, wider.downsample(features))


def test_a_stage_changes_shape_in_its_first_block():
    stage = residual_stage(8, 16, 3, groups=4, stride=2)
    assert stage(torch.randn(1, 8, 16, 24)).shape == (1, 16, 8, 12)
    assert [block.downsample is None for block in stage] == [False, True, True]


def test_dilation_sees_further():
    torch.manual_seed(0)
    reach = []
    for dilation in (1, 2):
        block = BasicBlock(4, 4, groups=0, dilation=dilation).eval()
        features = torch.randn(1, 4, 15, 15, requires_grad=True)
        block(features)[0, :, 7, 7].sum().backward()
        reach.append(int((features.grad.abs().sum((0, 1, 2)) > 0).nonzero().max()) - 7)
    assert reach == [2, 4]
