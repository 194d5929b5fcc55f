"""YOLOv3: the layers as others count them, and the order of what they say."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.yolo.configuration import (
    DARKNET53,
    SMALL,
    YoloConfiguration,
)
from avsec_gym.perception.detectors.yolo.network import YoloNetwork, box_grid

COCO = tuple(f"class{i}" for i in range(80))
_TINY = replace(SMALL, stem_channels=8, stage_blocks=(1,) * 5, stage_channels=(16, 16, 32, 32, 32))


def test_parameters_of_the_published_network() -> None:
    """yolov3.weights of its authors: 248,007,048 bytes, a header of 20, then float32 only."""
    with torch.device("meta"):
        network = YoloNetwork(replace(DARKNET53, categories=COCO))
    assert sum(value.numel() for value in network.parameters()) == 61_949_149
    numbers = [value.numel() for value in network.state_dict().values() if value.ndim]
    assert 20 + 4 * sum(numbers) == 248_007_048


def test_darknet_53_has_52_convolutions_before_its_classifier() -> None:
    with torch.device("meta"):
        network = YoloNetwork(DARKNET53)
    parts = [*network.stem.modules(), *network.stages.modules()]
    assert sum(isinstance(module, torch.nn.Conv2d) for module in parts) == 52


def test_the_small_one_weighs_less_than_eight_megabytes_in_half_precision() -> None:
    with torch.device("meta"):
        state = YoloNetwork(SMALL).state_dict()
    assert 2 * sum(value.numel() for value in state.values()) < 8e6


def test_the_grid_by_plain_loops() -> None:
    shapes = [(8, 12), (4, 6), (2, 3)]
    cells, strides, priors = box_grid(shapes, SMALL)
    expected = [
        (column, row, 8 * 2**scale, *SMALL.priors[3 * scale + prior])
        for scale, (rows, columns) in enumerate(shapes)
        for row in range(rows)
        for column in range(columns)
        for prior in range(3)
    ]
    found = torch.cat((cells, strides, priors), 1)
    assert found.tolist() == [list(row) for row in expected]


def test_what_is_said_of_a_box_comes_from_its_cell() -> None:
    """With every output map replaced by its own column, logits are the grid's columns."""
    torch.manual_seed(0)
    network = YoloNetwork(_TINY).eval()
    for output in network.outputs:
        output[-1].register_forward_hook(  # type: ignore[index]
            lambda _module, _inputs, maps: torch.arange(maps.shape[3]).expand_as(maps).float()
        )
    found = network(torch.randn(2, 3, 64, 96))
    assert found.logits.shape == (2, 3 * (8 * 12 + 4 * 6 + 2 * 3), 6)
    assert torch.equal(found.logits[1, :, 4], found.cells[:, 0])


def test_objects_are_unlikely_at_first() -> None:
    torch.manual_seed(0)
    found = YoloNetwork(_TINY).eval()(torch.randn(1, 3, 64, 96))
    assert float(found.objectness.detach().sigmoid().mean()) == pytest.approx(0.01, rel=0.2)


def test_sizes_that_images_are_resized_to() -> None:
    assert DARKNET53.size_for(375, 1242) == (192, 608)
    assert DARKNET53.size_for(480, 640) == (448, 608)
    assert SMALL.size_for(375, 1242) == (192, 640)


@pytest.mark.parametrize(
    "change",
    [
        {"categories": ()},
        {"priors": ((1.0, 2.0),)},
        {"input_size": (100, 320)},
        {"prior_objectness": 0.0},
    ],
)
def test_impossible_configurations_are_refused(change: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError):
        replace(SMALL, **change)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="darknet53, small"):
        YoloConfiguration.preset("tiny")
