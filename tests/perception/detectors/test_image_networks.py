"""Faster R-CNN and YOLOv3 as detectors, narrow ones on painted pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors.faster_rcnn import configuration as faster_rcnn
from avsec_gym.perception.detectors.faster_rcnn.detector import FasterRcnnDetector
from avsec_gym.perception.detectors.image_detector import DifferentiableImageDetector
from avsec_gym.perception.detectors.yolo import configuration as yolo
from avsec_gym.perception.detectors.yolo.detector import YoloDetector
from avsec_gym.perception.nn.box_coding import overlaps
from avsec_gym.perception.nn.region_counts import ProposalCount, SampleCount

FASTER_RCNN = replace(
    faster_rcnn.SMALL,
    input_size=(64, 192),
    stem_channels=16,
    stage_blocks=(1, 1, 1, 1),
    stage_channels=(8, 8, 16, 16),
    pyramid_channels=24,
    anchor_sizes=(8, 16, 32, 64, 128),
    box_channels=64,
    training_proposals=ProposalCount(200, 40),
    test_proposals=ProposalCount(100, 20),
)
YOLO = replace(
    yolo.SMALL,
    input_size=(64, 192),
    stem_channels=8,
    stage_blocks=(1, 1, 1, 1, 1),
    stage_channels=(16, 32, 32, 64, 64),
)

Make = Callable[[], Any]


def _faster_rcnn() -> FasterRcnnDetector:
    torch.manual_seed(0)
    return FasterRcnnDetector(FASTER_RCNN, sample=SampleCount(64, 0.5, 24, 0.25))


def _yolo() -> YoloDetector:
    torch.manual_seed(0)
    return YoloDetector(YOLO)


both = pytest.mark.parametrize("make", [_faster_rcnn, _yolo])


def _frozen(detector: Any, images: torch.Tensor, truth: list[Boxes3D]) -> dict[str, Any]:
    """What makes the loss a smooth function of the pixels."""
    if isinstance(detector, YoloDetector):
        return {"targets": detector.targets(images, truth)}
    return {"sampling": detector.draw(images, truth)}


@both
def test_it_is_a_frozen_differentiable_detector(make: Make) -> None:
    detector = make()
    assert isinstance(detector, DifferentiableImageDetector)
    assert not detector.network.training
    assert not any(weight.requires_grad for weight in detector.network.parameters())
    with pytest.raises(ConfigurationError, match="tiny"):
        type(detector)("tiny")
    with pytest.raises(ConfigurationError, match="another network"):
        type(detector)(detector.configuration, weights={})


@both
def test_a_frame_is_its_cameras_images(make: Make, painted: Any) -> None:
    detector = make()
    detector.rule = replace(detector.rule, least_score=0.0)
    images, _ = painted(1, 2)
    arrays = [image.permute(1, 2, 0).byte().numpy() for image in images]
    calibration = Calibration(np.zeros((4, 3, 4)), np.eye(3), np.eye(4)[:3])
    frame = SensorFrame("0", calibration, dict(zip((2, 3), arrays, strict=True)))
    together = detector.detect_batch(torch.stack([image.byte().float() for image in images]))
    for camera, expected in zip((2, 3), together, strict=True):
        found = detector.detect(frame, camera)
        assert len(found) > 0
        assert (np.diff(found.score) <= 0).all()
        assert set(found.category) == {"Car"}
        np.testing.assert_allclose(found.score, expected.score, rtol=1e-4)
        np.testing.assert_allclose(found.box2d, expected.box2d, atol=0.01)
    np.testing.assert_array_equal(detector.detect(frame).score, detector.detect(frame, 2).score)


@both
def test_boxes_are_in_the_images_own_pixels(make: Make, painted: Any) -> None:
    """Twice as wide, three times as high: each pixel repeated, reduced to what it was."""
    detector = make()
    detector.rule = replace(detector.rule, least_score=0.0)
    images, _ = painted(1)
    large = images.repeat_interleave(3, 2).repeat_interleave(2, 3)
    one, other = detector.detect_batch(images)[0], detector.detect_batch(large)[0]
    assert other.box2d is not None
    assert (other.box2d >= 0).all()
    assert (other.box2d <= [383, 191, 383, 191]).all()
    assert other.box2d[:, 2].max() > 192
    # Anti-aliasing blurs a little, so the pixels do not come back exactly.
    np.testing.assert_allclose(other.score.max(), one.score.max(), rtol=0.2)


@both
def test_the_gradient_reaches_every_pixel(make: Make, painted: Any) -> None:
    detector = make()
    images, truth = painted(1)
    images.requires_grad_()
    sum(detector.losses(images, truth).values()).backward()
    assert (images.grad != 0).any(dim=1).float().mean() >= 0.99
    assert all(weight.grad is None for weight in detector.network.parameters())


@both
def test_losses_repeat_and_an_empty_street_has_one(make: Make, painted: Any) -> None:
    detector = make()
    images, truth = painted(1, 2)
    first, second = (sum(detector.losses(images, truth).values()) for _ in range(2))
    assert first == second
    frozen = detector.losses(images, truth, **_frozen(detector, images, truth))
    assert sum(frozen.values()) == first
    empty = detector.losses(images.requires_grad_(), [truth[0], Boxes3D.empty()])
    sum(empty.values()).backward()
    assert torch.isfinite(images.grad).all()


@both
@pytest.mark.usefixtures("smooth_activations")
def test_directional_derivatives_agree_with_finite_differences(make: Make, painted: Any) -> None:
    detector = make()
    detector.network.double()
    images, truth = painted(1)
    images = images.double().requires_grad_()
    frozen = _frozen(detector, images, truth)
    sum(detector.losses(images, truth, **frozen).values()).backward()
    way = torch.randn(images.shape, generator=torch.Generator().manual_seed(0)).double()
    with torch.no_grad():
        ahead, behind = (
            sum(detector.losses(images + step * way, truth, **frozen).values())
            for step in (1e-5, -1e-5)
        )
    slope = float((way * images.grad).sum())
    assert float((ahead - behind) / 2e-5) == pytest.approx(slope, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "steps"), [(_faster_rcnn, 200), (_yolo, 60)])
def test_two_pictures_can_be_learned_by_heart(make: Make, steps: int, painted: Any) -> None:
    detector = make()
    images, truth = painted(1, 2)
    weights = list(detector.network.requires_grad_(True).train().parameters())
    optimiser = torch.optim.AdamW(weights, 3e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 3e-3, steps)
    for _ in range(steps):
        optimiser.zero_grad()
        sum(detector.losses(images, truth).values()).backward()
        torch.nn.utils.clip_grad_norm_(weights, 10)
        optimiser.step()
        schedule.step()
    detector.network.eval()
    for found, true in zip(detector.detect_batch(images), truth, strict=True):
        shared = overlaps(torch.tensor(found.box2d[:2]), torch.tensor(true.box2d))
        assert (shared.amax(1) > 0.7).all()
        assert (shared.amax(0) > 0.7).all()
        assert (found.score[:2] > 0.5).all()
        assert (found.score[2:] < 0.5).all()
