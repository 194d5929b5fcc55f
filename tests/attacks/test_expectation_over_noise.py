"""Means over noisy copies: nothing changes without noise, and noise smooths what it ought to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Attack, Victim
from avsec_gym.attacks.expectation_over_noise import ExpectationOverNoise
from avsec_gym.attacks.loss_terms import LossTerms
from avsec_gym.attacks.perturbation import Perturbation, mi_fgsm, projected_pgd, thesis_pgd
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.registry import make
from tests.finds_nothing import FindsNothing

SIZE = (6, 10)
CARS = Boxes3D.empty()


class Waves(FindsNothing):
    """A loss of slopes with ripples: mean(slope * p) + height * mean(sin(frequency * p))."""

    name = "waves"

    def __init__(self, height: float = 0.0, frequency: float = 2.0) -> None:
        self.slope = torch.from_numpy(np.random.default_rng(2).normal(size=(2, 3, *SIZE)))
        self.height, self.frequency = height, frequency
        self.seen: list[Tensor] = []

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        pixels = torch.stack([batch.left, batch.right], dim=1).double()
        self.seen.append(pixels.detach())
        ripples = self.height * torch.sin(self.frequency * pixels)
        return {"class": (self.slope * pixels + ripples).sum()}


def frame() -> SensorFrame:
    projection = np.array([[120.0, 0, SIZE[1] / 2, 0], [0, 120, SIZE[0] / 2, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 65.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    images = np.random.default_rng(1).integers(60, 196, (2, *SIZE, 3), np.uint8)
    return SensorFrame("0", calibration, {2: images[0], 3: images[1]})


def pixels(of: SensorFrame) -> np.ndarray:
    return np.stack([of.image(2), of.image(3)]).transpose(0, 3, 1, 2).astype(float)


PLAIN = [
    thesis_pgd(),
    thesis_pgd(0.4, 3, shared=True),
    mi_fgsm(),
    projected_pgd(),
    thesis_pgd(terms=LossTerms.CLASS_ONLY),
]


@pytest.mark.parametrize("plain", PLAIN, ids=lambda attack: attack.name)
@pytest.mark.parametrize("copies", [1, 3])
def test_without_noise_it_is_the_plain_attack(plain: Perturbation, copies: int) -> None:
    victim = Victim(Waves(5.0), CARS)
    quiet = ExpectationOverNoise(**vars(plain), copies=copies, noise=0.0)
    assert quiet.budget == plain.budget
    for one, other in zip(
        quiet.iterates(frame(), victim, seed=4),
        plain.iterates(frame(), victim, seed=4),
        strict=True,
    ):
        np.testing.assert_array_equal(pixels(one), pixels(other))


def test_the_gradient_is_the_mean_over_the_copies_that_were_seen() -> None:
    """The closed form at each copy: slope + height * frequency * cos(frequency * pixel)."""
    detector, clean = Waves(5.0), frame()
    attack = ExpectationOverNoise(copies=6, noise=3.0)
    batch = batch_of_frames([clean])
    found = attack.gradient(batch, detector, [CARS], None, [3, 1])[:, 0]
    assert len(detector.seen) == 6
    exact = [
        detector.slope + 5.0 * detector.frequency * torch.cos(detector.frequency * seen[0])
        for seen in detector.seen
    ]
    np.testing.assert_allclose(found.numpy(), torch.stack(exact).mean(0).numpy(), atol=1e-3)
    noise = torch.stack(detector.seen)[:, 0] - torch.from_numpy(pixels(clean))
    assert float(noise.std()) == pytest.approx(3.0, rel=0.05)
    assert float(noise.mean()) == pytest.approx(0.0, abs=0.2)
    assert not torch.equal(noise[0, 0], noise[0, 1])


def test_ripples_average_out_and_the_slope_stays() -> None:
    """E cos(f (p + eta)) = cos(f p) exp(-(f sigma)^2 / 2): of these ripples nothing is left."""
    detector, clean = Waves(height=1.5), frame()
    victim, wanted = Victim(detector, CARS), np.sign(detector.slope.numpy())
    plain = pixels(thesis_pgd(steps=1).attack(clean, victim)) - pixels(clean)
    robust = pixels(ExpectationOverNoise(steps=1, copies=60).attack(clean, victim)) - pixels(clean)
    assert (plain == wanted).mean() < 0.8
    assert (robust == wanted).mean() > 0.85


def test_the_seed_decides_the_noise_and_fewer_steps_begin_more() -> None:
    victim, attack = Victim(Waves(5.0), CARS), ExpectationOverNoise(steps=3, copies=2)
    once, again = (pixels(attack.attack(frame(), victim, seed=[7, 1])) for _ in range(2))
    np.testing.assert_array_equal(once, again)
    assert (once != pixels(attack.attack(frame(), victim, seed=[7, 2]))).any()
    one, other = (pixels(attack.attack(frame(), victim, seed=n)) for n in (7, np.int64(7)))
    np.testing.assert_array_equal(one, other)
    for n, attacked in enumerate(attack.iterates(frame(), victim, seed=[7, 1]), 1):
        alone = replace(attack, steps=n).attack(frame(), victim, seed=[7, 1])
        np.testing.assert_array_equal(pixels(alone), pixels(attacked))


def test_steps_do_not_share_their_noise() -> None:
    detector = Waves()
    list(ExpectationOverNoise(steps=2, copies=2).iterates(frame(), Victim(detector, CARS)))
    noise = [seen.round(decimals=3) for seen in detector.seen]
    assert not any(torch.equal(noise[i], noise[j]) for i in range(4) for j in range(i))


def test_copies_are_images_that_a_sensor_can_deliver() -> None:
    detector = Waves()
    ExpectationOverNoise(steps=1, copies=4, noise=200.0).attack(frame(), Victim(detector, CARS))
    seen = torch.stack(detector.seen)
    assert float(seen.min()) == 0.0
    assert float(seen.max()) == 255.0


@pytest.mark.parametrize("wrong", [{"copies": 0}, {"copies": 1.5}, {"noise": -1}, {"noise": 256}])
def test_impossible_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        ExpectationOverNoise(**wrong)


NAMED = {"name": "expectation_over_noise", "copies": 2, "noise": 1.0, "steps": 1}


def test_results_of_other_terms_are_filed_apart_where_no_name_was_given() -> None:
    of_class = ExpectationOverNoise(terms=LossTerms.CLASS_ONLY)
    assert of_class.name == "expectation_over_noise class_only"
    assert replace(of_class, steps=3).name == of_class.name
    assert ExpectationOverNoise(terms=LossTerms.CLASS_ONLY, name="mine").name == "mine"


def test_it_has_a_name_in_the_registry() -> None:
    made = make("attack", NAMED)
    assert isinstance(made, Attack)
    assert made == ExpectationOverNoise(copies=2, noise=1.0, steps=1)


@pytest.mark.slow
def test_environments_take_the_name() -> None:
    asked = NAMED
    env = gym.make("avsec_gym:avsec/DetectorBenchmark-v0", detector="stereo_rcnn", attack=asked)
    assert env.spec is not None
    assert env.spec.kwargs["attack"] == asked
    env.close()
    with pytest.raises(ConfigurationError, match="needs a detector"):
        gym.make("avsec_gym:avsec/DetectorBenchmark-v0", attack=asked)
