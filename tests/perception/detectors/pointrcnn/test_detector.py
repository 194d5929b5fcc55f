"""The detector from points to boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.box_overlap import box_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.detector import (
    PointRcnnDecodingRule,
    PointRcnnDetector,
)
from avsec_gym.perception.detectors.pointrcnn.losses import pointrcnn_losses
from avsec_gym.perception.detectors.pointrcnn.points_input import points_in_view, sampled_points

MakeScene = Callable[[int], Any]


@pytest.fixture
def detector(tiny: PointRcnnConfiguration) -> PointRcnnDetector:
    torch.manual_seed(0)
    return PointRcnnDetector(tiny, rule=PointRcnnDecodingRule(0.0))


def test_is_a_frozen_detector(detector: PointRcnnDetector) -> None:
    assert isinstance(detector, Detector)
    assert detector.name == "pointrcnn"
    assert not detector.network.training
    assert not any(weight.requires_grad for weight in detector.network.parameters())


def test_boxes_are_sorted_seen_and_the_same_again(
    detector: PointRcnnDetector, scene: MakeScene
) -> None:
    frame = scene(0).frame
    for find in (detector.detect, detector.propose):
        boxes = find(frame)
        assert len(boxes) > 0
        assert (np.diff(boxes.score) <= 0).all()
        assert boxes.box2d is not None
        assert (boxes.box2d[:, 2:] > boxes.box2d[:, :2]).all()
        assert (boxes.box2d >= 0).all()
        assert (boxes.box2d <= [399, 119, 399, 119]).all()
        np.testing.assert_array_equal(boxes.location, find(frame).location)
    proposed, found = detector.both_stages(frame)
    np.testing.assert_array_equal(found.location, detector.detect(frame).location)
    np.testing.assert_array_equal(proposed.location, detector.propose(frame).location)
    assert len(proposed) > len(found)


def test_what_overlaps_a_surer_box_or_is_unsure_is_left_out(
    detector: PointRcnnDetector, scene: MakeScene
) -> None:
    frame = scene(0).frame
    found = detector.detect(frame)
    shared = _overlaps(found, found) - np.eye(len(found))
    assert shared.max() <= 0.1
    detector.rule = PointRcnnDecodingRule(float(np.median(found.score)))
    fewer = detector.detect(frame)
    assert len(fewer) == (found.score > np.median(found.score)).sum()


def test_frames_without_points_are_named(detector: PointRcnnDetector, scene: MakeScene) -> None:
    frame = scene(0).frame
    with pytest.raises(DataError, match="Frame 000042 has no LiDAR scan"):
        detector.detect(replace(frame, scan=None))
    with pytest.raises(DataError, match="frame 000042 is in view"):
        detector.propose(frame.with_points(np.zeros((0, 4), np.float32)))


def test_weights_by_name_file_and_state(detector: PointRcnnDetector, tmp_path: Any) -> None:
    same = PointRcnnDetector(detector.configuration, detector.network.state_dict())
    for name, value in detector.network.state_dict().items():
        assert torch.equal(value, same.network.state_dict()[name])
    with pytest.raises(ConfigurationError, match="another network"):
        PointRcnnDetector("small", detector.network.state_dict())
    with pytest.raises(DataError, match="avsec train"):
        make_detector({"name": "pointrcnn", "weights": str(tmp_path / "none.safetensors")})
    with pytest.raises(ConfigurationError, match="are shares"):
        PointRcnnDecodingRule(least_score=1.0)


@pytest.mark.slow
def test_learns_scenes_by_heart(tiny: PointRcnnConfiguration, scene: MakeScene) -> None:
    torch.manual_seed(0)
    randomness = np.random.default_rng(0)
    detector, scenes = PointRcnnDetector(tiny), [scene(1), scene(2)]
    network = detector.network.train().requires_grad_(True)
    optimiser = torch.optim.Adam(network.parameters(), 4e-3)
    objects = [torch.from_numpy(example.rows).float() for example in scenes]
    seen = [points_in_view(example.frame, tiny.view) for example in scenes]
    steps = 500
    for step in range(steps):
        optimiser.param_groups[0]["lr"] = 4e-3 * min(1.0, 2 - 2 * step / steps)
        points = [torch.from_numpy(sampled_points(cloud, tiny.view, randomness)) for cloud in seen]
        optimiser.zero_grad()
        sum(pointrcnn_losses(network, torch.stack(points), objects).values()).backward()
        optimiser.step()
    network.eval().requires_grad_(False)
    proposals, overlaps, turns, sure = [], [], [], 0
    for example in scenes:
        proposed, found = detector.both_stages(example.frame)
        proposals += list(_overlaps(example.boxes, proposed).max(axis=1))
        found = found[found.score > 0.5]
        sure += len(found)
        shared = _overlaps(example.boxes, found)
        overlaps += list(shared.max(axis=1))
        turns += list(found.rotation_y[shared.argmax(axis=1)] - example.boxes.rotation_y)
    # Processors round differently, and 500 steps make that another training.  Of eight seeds seven
    # found all six cars and nothing else, one missed one; the least mean overlap of proposals was
    # 0.6, the least overlap of a found car 0.6.  Untrained networks find nothing.
    known = np.array(overlaps) > 0.4
    assert np.mean(proposals) > 0.5
    assert known.sum() >= 4
    assert known.sum() <= sure <= 8
    assert np.mean(np.array(overlaps)[known]) > 0.5
    assert np.cos(np.array(turns)[known]).min() > 0.9


def _overlaps(one: Boxes3D, two: Boxes3D) -> Floats:
    parts = ("location", "dimensions", "rotation_y")
    return box_iou(*(getattr(boxes, part) for boxes in (one, two) for part in parts))
