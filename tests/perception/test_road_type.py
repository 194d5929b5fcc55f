"""The driving-constraint selector."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.road_type import (
    DrivingConstraintSelector,
    RoadTypeConfiguration,
    RoadTypeNetwork,
)
from avsec_gym.rig import kitti_rig
from avsec_gym.road_type import RoadType

CALIBRATION = kitti_rig().calibration


def frame(**levels: int) -> SensorFrame:
    images = {
        {"left": 2, "right": 3}[name]: np.full((375, 1242, 3), level, np.uint8)
        for name, level in levels.items()
    }
    return SensorFrame("0", CALIBRATION, images)


def test_network_is_the_thesis_five_convolutions_joined_by_pooling_and_one_layer() -> None:
    network = RoadTypeNetwork(RoadTypeConfiguration())
    kinds = [type(module) for module in network.modules()]
    assert [kinds.count(kind) for kind in (nn.Conv2d, nn.MaxPool2d, nn.Linear, nn.Dropout)] == [
        5,
        4,
        1,
        1,
    ]
    evidence = network(torch.rand(3, 3, 96, 320) * 255)
    assert evidence.shape == (3, 2)
    assert (evidence >= 0).all()


def test_both_images_count_and_one_is_enough() -> None:
    torch.manual_seed(0)
    selector = DrivingConstraintSelector(weights=None)
    with torch.no_grad():
        selector.network.decision.weight.mul_(20.0)  # Let untrained evidence differ.
    left, right, both, alike = (
        selector.highway_probability(image)
        for image in (
            frame(left=40),
            frame(right=220),
            frame(left=40, right=220),
            frame(left=40, right=40),
        )
    )
    assert left != right
    assert min(left, right) < both < max(left, right)
    assert alike == pytest.approx(left, abs=1e-6)
    with pytest.raises(DataError, match="camera 2"):
        selector.select(frame())


def test_the_likelier_type_is_selected_and_a_street_in_doubt() -> None:
    selector = DrivingConstraintSelector(weights=None)
    decision = selector.network.decision
    for evidence, expected in (
        ((3.0, 1.0), RoadType.STREET),
        ((1.0, 3.0), RoadType.HIGHWAY),
        ((-1.0, -2.0), RoadType.STREET),  # None at all: both are cut off at 0.
    ):
        with torch.no_grad():
            decision.weight.zero_()
            decision.bias.copy_(torch.tensor(evidence))
        assert selector.select(frame(left=90)) is expected


def test_refuses_what_cannot_be() -> None:
    with pytest.raises(ConfigurationError, match="known: small"):
        DrivingConstraintSelector("vgg16")
    with pytest.raises(ConfigurationError, match="another network"):
        DrivingConstraintSelector(weights={})
    for wrong in ({"channels": (8, 8)}, {"input_size": (100, 320)}, {"dropout": 1.0}):
        with pytest.raises(ConfigurationError):
            replace(RoadTypeConfiguration(), **wrong)


def test_shipped_weights_give_a_road_type_for_a_real_frame(shared: Path) -> None:
    from avsec_gym.kitti.dataset import KittiObject

    real = KittiObject(shared / "kitti" / "object").frame("000107")
    assert DrivingConstraintSelector().select(real) is RoadType.STREET
