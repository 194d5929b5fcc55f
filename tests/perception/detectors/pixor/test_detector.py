"""The detector from points to boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats, bird_eye_iou
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.pixor.bird_eye_input import bird_eye_input
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.detector import PixorDetector
from avsec_gym.perception.detectors.pixor.losses import pixor_losses
from avsec_gym.perception.detectors.pixor.targets import PixorTargets, cell_targets

MakeScene = Callable[[int], Any]


def test_is_a_frozen_detector(tiny: PixorConfiguration) -> None:
    detector = PixorDetector(tiny)
    assert isinstance(detector, Detector)
    assert detector.name == "pixor"
    assert not detector.network.training
    assert not any(weight.requires_grad for weight in detector.network.parameters())


def test_frames_without_points_are_named(tiny: PixorConfiguration, scene: MakeScene) -> None:
    detector, frame = PixorDetector(tiny), scene(0).frame
    with pytest.raises(DataError, match="Frame 000042 has no LiDAR scan"):
        detector.detect(replace(frame, scan=None))
    with pytest.raises(DataError, match="frame 000042 has no points"):
        detector.detect(frame.with_points(np.zeros((0, 4), np.float32)))


def test_weights_by_name_file_and_state(tiny: PixorConfiguration, tmp_path: Any) -> None:
    detector = PixorDetector(tiny)
    same = PixorDetector(tiny, detector.network.state_dict())
    for name, value in detector.network.state_dict().items():
        assert torch.equal(value, same.network.state_dict()[name])
    with pytest.raises(ConfigurationError, match="another network"):
        PixorDetector("small", detector.network.state_dict())
    with pytest.raises(DataError, match="avsec train"):
        make_detector({"name": "pixor", "weights": str(tmp_path / "none.safetensors")})


@pytest.mark.slow
def test_learns_a_scene_by_heart(tiny: PixorConfiguration, scene: MakeScene) -> None:
    torch.manual_seed(0)
    detector, scenes = PixorDetector(tiny), [scene(1), scene(2)]
    inputs = [bird_eye_input(example.frame.points, tiny.region) for example in scenes]
    scans = torch.from_numpy(np.stack(inputs))
    targets = PixorTargets.concatenate(
        [cell_targets(example.rectangles, tiny) for example in scenes]
    )
    network = detector.network.train().requires_grad_(True)
    optimiser = torch.optim.Adam(network.parameters(), 1e-2)
    for _ in range(60):
        optimiser.zero_grad()
        sum(pixor_losses(network(scans), targets, tiny).values()).backward()
        optimiser.step()
    network.eval()
    for example in scenes:
        found = detector.detect(example.frame)
        sure = found[found.score > 0.3]
        assert len(sure) == len(example.boxes) == 3
        overlaps = bird_eye_iou(
            example.boxes.poses, _sizes(example.boxes), sure.poses, _sizes(sure)
        )
        assert (overlaps.max(axis=1) > 0.7).all()
        headings = sure.rotation_y[overlaps.argmax(axis=1)]
        assert np.cos(headings - example.boxes.rotation_y).min() > 0.95
        assert sure.location[:, 1] == pytest.approx(1.62, abs=0.1)
        assert found.box2d is not None
        assert (np.diff(found.score) <= 0).all()


def _sizes(boxes: Any) -> Floats:
    return np.stack([boxes.length, boxes.width], axis=1)
