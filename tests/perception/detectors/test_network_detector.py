"""What all detectors by a network hold, and what state their networks are in."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from torch import nn

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.detectors.score_calibration import ScoreCalibration
from avsec_gym.registry import Kind, make


class LineDetector(NetworkDetector[str, nn.Linear]):
    name = "line"


def line(_: str) -> nn.Linear:
    return nn.Linear(2, 1).train()


def test_weights_are_given_and_frozen() -> None:
    weights = {"weight": torch.full((1, 2), 3.0), "bias": torch.zeros(1)}
    detector = LineDetector("straight", line, weights, "small")
    assert detector.configuration == "straight"
    assert detector.network.weight.tolist() == [[3.0, 3.0]]
    assert not detector.network.training
    assert not any(parameter.requires_grad for parameter in detector.network.parameters())
    assert detector.card is None
    assert detector.calibration == ScoreCalibration()


def test_weights_of_another_network_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="another network"):
        LineDetector("straight", line, {"weight": torch.zeros(1, 3)}, "small")
    with pytest.raises(DataError, match=r"none\.safetensors"):
        LineDetector("straight", line, tmp_path / "none.safetensors", "small")
    with pytest.raises(DataError, match="line_tiny"):
        LineDetector("straight", line, "shipped", "tiny")


def test_no_network_is_made_for_weights_that_are_none() -> None:
    def network(_: str) -> nn.Linear:
        raise AssertionError("it took its time")

    with pytest.raises(ConfigurationError, match="weights takes a file"):
        LineDetector("straight", network, 3, "small")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *((Kind.DETECTOR, name) for name in ("dsgn", "stereo_rcnn", "pixor", "pointrcnn")),
        *((Kind.IMAGE_DETECTOR, name) for name in ("faster_rcnn", "yolo")),
    ],
)
def test_every_detector_by_a_network_has_its_shipped_calibration(kind: Kind, name: str) -> None:
    detector = make(kind, name)
    assert isinstance(detector, NetworkDetector)
    assert detector.card is not None
    assert detector.calibration == ScoreCalibration.of_card(detector.card) != ScoreCalibration()
