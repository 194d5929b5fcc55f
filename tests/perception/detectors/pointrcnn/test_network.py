"""Keys and size of the original, and what an untrained network says."""

from __future__ import annotations

import re

import pytest
import torch

from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.network import PointRcnnNetwork


def parameters(network: torch.nn.Module) -> int:
    return sum(value.numel() for value in network.parameters())


def test_size_of_the_original() -> None:
    """Those of the public code's own modules, counted with stand-ins for its CUDA operators."""
    network = PointRcnnNetwork(PointRcnnConfiguration.preset("default"))
    assert parameters(network.rpn) == 3_050_669
    assert parameters(network) == 3_887_452


def test_keys_of_the_original() -> None:
    state = PointRcnnNetwork(PointRcnnConfiguration.preset("default")).state_dict()
    norm = r"bn\.bn\.(weight|bias|running_mean|running_var|num_batches_tracked)"
    unit, plain = rf"(conv\.weight|{norm})", r"conv\.(weight|bias)"
    pattern = "|".join(
        [
            rf"rpn\.backbone_net\.SA_modules\.[0-3]\.mlps\.[01]\.layer[0-2]\.{unit}",
            rf"rpn\.backbone_net\.FP_modules\.[0-3]\.mlp\.layer[01]\.{unit}",
            rf"rpn\.rpn_(cls|reg)_layer\.(0\.{unit}|2\.{plain})",
            rf"rcnn_net\.xyz_up_layer\.layer[01]\.{plain}",
            rf"rcnn_net\.merge_down_layer\.layer0\.{plain}",
            rf"rcnn_net\.SA_modules\.[0-2]\.mlps\.0\.layer[0-2]\.{plain}",
            rf"rcnn_net\.(cls|reg)_layer\.[023]\.{plain}",
        ]
    )
    assert not [name for name in state if not re.fullmatch(pattern, name)]
    assert len(state) == 244
    shapes = {name: tuple(value.shape) for name, value in state.items()}
    assert shapes["rpn.backbone_net.SA_modules.0.mlps.1.layer0.conv.weight"] == (32, 3, 1, 1)
    assert shapes["rpn.backbone_net.FP_modules.3.mlp.layer0.conv.weight"] == (512, 1536, 1, 1)
    assert shapes["rpn.rpn_reg_layer.2.conv.weight"] == (76, 128, 1)
    assert shapes["rcnn_net.merge_down_layer.layer0.conv.weight"] == (128, 256, 1, 1)
    assert shapes["rcnn_net.SA_modules.2.mlps.0.layer0.conv.weight"] == (256, 259, 1, 1)
    assert shapes["rcnn_net.reg_layer.3.conv.weight"] == (46, 256, 1)


def test_the_small_one_is_small() -> None:
    assert parameters(PointRcnnNetwork(PointRcnnConfiguration.preset("small"))) < 1_000_000


def test_what_an_untrained_network_says(tiny: PointRcnnConfiguration) -> None:
    torch.manual_seed(0)
    network = PointRcnnNetwork(tiny).eval()
    points = torch.rand(2, 512, 3) * torch.tensor([16, 2, 20.0]) - torch.tensor([8, 0, 0.0])
    with torch.no_grad():
        output = network(points)
    assert output.points.logits.shape == (2, 512)
    assert output.points.codes.shape == (2, 512, 76)
    assert output.points.scores.median().item() == pytest.approx(0.01, abs=0.02)
    count = sum(len(proposals.boxes) for proposals in output.proposals)
    assert output.refinement.logits.shape == (count,)
    assert output.refinement.codes.shape == (count, 46)
    assert 0 < count <= 32


def test_each_scan_is_judged_by_itself(tiny: PointRcnnConfiguration) -> None:
    torch.manual_seed(0)
    network = PointRcnnNetwork(tiny).eval()
    points = torch.rand(2, 512, 3) * 15
    with torch.no_grad():
        both, second = network(points), network(points[1:])
    torch.testing.assert_close(both.points.logits[1:], second.points.logits)
    torch.testing.assert_close(both.proposals[1].boxes, second.proposals[0].boxes)
    refined = both.refinement.codes[len(both.proposals[0].boxes) :]
    torch.testing.assert_close(refined, second.refinement.codes, atol=1e-4, rtol=1e-4)
