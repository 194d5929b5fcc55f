"""Detectors behind defences: what they are given, and the gradient of who knows the defence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.loss_gradient import loss_gradient
from avsec_gym.attacks.perturbation import fgsm
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.defences.bit_depth import BitDepth
from avsec_gym.perception.defences.defended_detector import defended_detector
from avsec_gym.perception.detectors.detector import DifferentiableDetector, network_name
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.registry import make
from avsec_gym.rig import kitti_rig

NOISE = {"name": "gaussian_noise", "strength": 10}


class Brightness:
    """One box, as far as the images are bright; the loss is half the sum of squared pixels."""

    name = "brightness"

    def __init__(self) -> None:
        self.seen: list[np.ndarray] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return self.detect_batch(batch_of_frames([frame]))[0]

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        found = []
        for left, right in zip(batch.left, batch.right, strict=True):
            self.seen.append(torch.stack([left, right]).numpy().copy())
            far = float(left.mean() + 2 * right.mean())
            found.append(
                Boxes3D([[0, 1.6, far]], [[1.5, 1.7, 4.2]], [np.pi / 2], [0.9], np.array(["Car"]))
            )
        return found

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        return {"left": (batch.left**2).sum() / 2, "right": (batch.right**2).sum() / 2}


@pytest.fixture(scope="module")
def frame() -> SensorFrame:
    images = np.random.default_rng(2).integers(0, 256, (2, 24, 40, 3), np.uint8)
    return SensorFrame("7", kitti_rig().calibration, {2: images[0], 3: images[1]})


def test_both_images_are_defended_and_nothing_else(frame: SensorFrame) -> None:
    inner = Brightness()
    detector = defended_detector(inner, {"name": "bit_depth", "bits": 2})
    detector.detect(frame)
    random = np.random.default_rng(0)
    for seen, camera in zip(inner.seen[0], (2, 3), strict=True):
        expected = BitDepth(2).defend(frame.image(camera), random)
        assert (seen.transpose(1, 2, 0) == expected).all()
    assert detector.name == "brightness behind bit_depth"


@pytest.mark.parametrize("copies", [1, 3])
def test_a_frame_and_a_batch_give_the_same_boxes_again_and_again(
    frame: SensorFrame, copies: int
) -> None:
    detector = defended_detector(Brightness(), NOISE, copies)
    assert isinstance(detector, DifferentiableDetector)
    once = detector.detect(frame).location
    assert (detector.detect(frame).location == once).all()
    batch = batch_of_frames([frame, frame])
    assert all((each.location == once).all() for each in detector.detect_batch(batch))
    other = defended_detector(Brightness(), NOISE, copies, seed=1).detect(frame).location
    assert (other != once).any()


def test_the_copies_differ_and_the_median_lies_between(frame: SensorFrame) -> None:
    inner = Brightness()
    far = defended_detector(inner, NOISE, 5).detect(frame).location[0, 2]
    means = [float(left.mean() + 2 * right.mean()) for left, right in inner.seen]
    assert len(set(means)) == 5
    assert far == pytest.approx(np.median(means))


def test_the_gradient_passes_as_if_the_defence_were_none(frame: SensorFrame) -> None:
    detector = defended_detector(Brightness(), {"name": "bit_depth", "bits": 2})
    batch = batch_of_frames([frame])
    gradient = loss_gradient(detector, batch, [Boxes3D.empty()])
    random = np.random.default_rng(0)
    for each, camera in zip(gradient, (2, 3), strict=True):
        # Of half a square the slope is the defended pixel itself.
        expected = BitDepth(2).defend(frame.image(camera), random)
        assert (each[0].permute(1, 2, 0).numpy() == expected).all()


def test_the_loss_of_several_copies_is_the_mean(frame: SensorFrame) -> None:
    batch, none = batch_of_frames([frame]), [Boxes3D.empty()]
    inner = Brightness()
    defended_detector(inner, NOISE, 4).detect(frame)
    expected = np.mean([(left.astype(float) ** 2).sum() / 2 for left, _ in inner.seen])
    several = defended_detector(Brightness(), NOISE, 4)
    assert isinstance(several, DifferentiableDetector)
    assert several.losses(batch, none)["left"].item() == pytest.approx(expected, rel=1e-4)


def test_a_perturbation_knows_the_defence(frame: SensorFrame) -> None:
    # Bright pixels get brighter by the gradient behind the defence, two bits of which hide none.
    detector = defended_detector(Brightness(), {"name": "bit_depth", "bits": 6})
    attack = fgsm()
    attacked = attack.attack(frame, Victim(detector, Boxes3D.empty()))
    assert (attacked.image(2).astype(float) >= frame.image(2)).all()
    assert (attacked.image(2).astype(float) > frame.image(2)).mean() > 0.8


def test_without_a_loss_there_is_none(frame: SensorFrame) -> None:
    detector = defended_detector(Oracle(), "jpeg")
    assert not isinstance(detector, DifferentiableDetector)
    assert detector.network is None
    assert not detector.image_only
    assert network_name(detector) == "oracle"
    assert defended_detector({"name": "single_image", "detector": "yolo"}, "jpeg").image_only


@pytest.mark.parametrize(
    "wrong",
    [
        {"detector": "oracl"},
        {"detector": "oracle", "defence": "jpg"},
        {"detector": "oracle", "defence": {"name": "jpeg", "qualty": 3}},
        {"detector": "oracle", "copies": 0},
        {"detector": "oracle", "seed": -1},
        {"detector": {"name": "single_image", "detector": "yolo"}, "copies": 3},
        {"detector": "oracle", "defence": Oracle()},
        {},
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_seen(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError):
        make("detector", {"name": "defended", **wrong})
