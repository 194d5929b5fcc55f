"""Attacks that climb the class alone: against finite differences, and on both networks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.expectation_over_noise import ExpectationOverNoise
from avsec_gym.attacks.loss_gradient import loss_gradient, total_loss
from avsec_gym.attacks.loss_terms import CLASS_TERMS, LossTerms
from avsec_gym.attacks.perturbation import (
    Perturbation,
    fgsm,
    i_fgsm,
    mi_fgsm,
    projected_pgd,
    thesis_pgd,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.registry import make
from tests.finds_nothing import FindsNothing

CARS = Boxes3D(
    [[-3.0, 1.6, 10], [3, 1.65, 14]],
    [[1.5, 1.6, 4.0], [1.4, 1.7, 4.2]],
    [-1.2, 0.4],
    np.ones(2),
    np.full(2, "Car"),
    truncation=np.zeros(2),
    occlusion=np.zeros(2),
)


def noise_frame(height: int, width: int) -> SensorFrame:
    projection = np.array([[120.0, 0, width / 2, 0], [0, 120, height / 2, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 65.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    images = np.random.default_rng(1).integers(30, 225, (2, height, width, 3), np.uint8)
    return SensorFrame("0", calibration, {2: images[0], 3: images[1]})


class TwoTerms(FindsNothing):
    """A smooth loss of a class and one of boxes, which pull in different directions."""

    name = "two_terms"

    def __init__(self, *, has_class: bool = True) -> None:
        random = np.random.default_rng(3)
        self.slope, self.frequency = (
            torch.from_numpy(random.normal(size=(2, 3, 4, 6))) for _ in range(2)
        )
        self.class_name = "class" if has_class else "objectness"

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        pixels = torch.stack([batch.left, batch.right], dim=1).double()
        return {
            "box": (self.slope * pixels).sum(),
            self.class_name: torch.sin(self.frequency * pixels / 20).sum(),
        }


def by_differences(detector: Any, batch: StereoBatch, step: float) -> np.ndarray:
    """The slope of the class' term at each pixel, shape (2, 1, 3, H, W)."""
    views = torch.stack([batch.left, batch.right]).double()
    slopes = np.zeros(tuple(views.shape))
    for place in np.ndindex(*views.shape):
        values = []
        for sign in (1, -1):
            moved = views.clone()
            moved[place] += sign * step
            terms = detector.losses(replace(batch, left=moved[0], right=moved[1]), [CARS])
            values.append(float(terms["class"]))
        slopes[place] = (values[0] - values[1]) / (2 * step)
    return slopes


def test_the_gradient_of_the_class_is_that_of_finite_differences() -> None:
    detector, batch = TwoTerms(), batch_of_frames([noise_frame(4, 6)])
    found = loss_gradient(detector, batch, [CARS], which=LossTerms.CLASS_ONLY).numpy()
    np.testing.assert_allclose(found, by_differences(detector, batch, 0.01), atol=1e-4)
    every = loss_gradient(detector, batch, [CARS]).numpy()
    np.testing.assert_allclose(every - found, detector.slope.numpy()[:, None], atol=1e-5)


def test_a_step_follows_the_class_alone() -> None:
    frame, detector = noise_frame(4, 6), TwoTerms()
    slopes = by_differences(detector, batch_of_frames([frame]), 0.01)[:, 0].transpose(0, 2, 3, 1)
    climbed = thesis_pgd(1.0, 1, terms=LossTerms.CLASS_ONLY).attack(frame, Victim(detector, CARS))
    moved = np.stack([climbed.image(2), climbed.image(3)]) - [frame.image(2), frame.image(3)]
    np.testing.assert_array_equal(moved, np.sign(slopes))
    plain = thesis_pgd(1.0, 1).attack(frame, Victim(detector, CARS))
    assert (plain.image(2) != climbed.image(2)).any()


@pytest.mark.parametrize(
    "preset", [thesis_pgd, fgsm, i_fgsm, mi_fgsm, projected_pgd, ExpectationOverNoise]
)
def test_every_preset_takes_the_terms_and_is_filed_apart(preset: Any) -> None:
    plain, of_class = preset(), preset(terms=LossTerms.CLASS_ONLY)
    assert of_class == replace(plain, name=f"{plain.name} class_only", terms=LossTerms.CLASS_ONLY)
    assert plain.terms is LossTerms.ALL
    by_word = make("attack", {"name": plain.name, "terms": "class_only"})
    assert by_word == of_class
    assert by_word.terms is LossTerms.CLASS_ONLY


def test_other_terms_and_losses_without_a_class_are_refused() -> None:
    for asked in (lambda: Perturbation(terms="class"), lambda: fgsm(terms="class")):  # type: ignore[arg-type]
        with pytest.raises(ConfigurationError, match="no terms 'class'"):
            asked()
    victim = Victim(TwoTerms(has_class=False), CARS)
    with pytest.raises(ConfigurationError, match=r"box, objectness.*terms='all'"):
        thesis_pgd(terms=LossTerms.CLASS_ONLY).attack(noise_frame(4, 6), victim)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "names"),
    [(DsgnDetector, {"classification"}), (StereoRcnnDetector, {"rpn_class", "class"})],
)
def test_the_networks_classes_are_climbed_and_nothing_else(kind: Any, names: set[str]) -> None:
    torch.manual_seed(0)
    detector, batch = kind("small"), batch_of_frames([noise_frame(96, 320)])
    terms = detector.losses(batch, [CARS])
    assert names == CLASS_TERMS & set(terms)
    only = float(total_loss(detector, batch, [CARS], which=LossTerms.CLASS_ONLY).detach())
    assert only == pytest.approx(sum(float(terms[name].detach()) for name in names), rel=1e-5)
    found = loss_gradient(detector, batch, [CARS], which=LossTerms.CLASS_ONLY)
    every = loss_gradient(detector, batch, [CARS])
    similarity = torch.nn.functional.cosine_similarity(found.flatten(), every.flatten(), dim=0)
    assert found.abs().max() > 0
    assert similarity < 0.999
    *_, steps = Perturbation(1.0, steps=2, terms=LossTerms.CLASS_ONLY).perturbed(
        batch, detector, [CARS]
    )
    raised = float(total_loss(detector, steps, [CARS], which=LossTerms.CLASS_ONLY).detach())
    assert raised > only
