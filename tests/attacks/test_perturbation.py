"""Perturbations against losses whose gradients are known in closed form, and real networks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Attack, Victim, quantised
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.attacks.perturbation import (
    Perturbation,
    fgsm,
    i_fgsm,
    mi_fgsm,
    pgd,
    projected_pgd,
    thesis_pgd,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
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
ALL = [
    thesis_pgd(),
    thesis_pgd(0.4, 3),
    thesis_pgd(2.0, 2, epsilon=0.5),
    fgsm(),
    i_fgsm(),
    mi_fgsm(),
    projected_pgd(),
]


class Slopes(FindsNothing):
    """A detector with loss sum(slope * pixel + bend / 2 * pixel^2), both views alike."""

    name = "slopes"

    def __init__(self, slope: np.ndarray, bend: np.ndarray | float = 0.0) -> None:
        self.slope = torch.from_numpy(slope)
        self.bend = torch.as_tensor(bend)
        self.seen: list[Tensor | None] = []

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        self.seen.append(disparity)
        images = torch.stack([batch.left, batch.right], dim=1).double()
        return {
            "slope": (self.slope * images).sum(),
            "bend": (self.bend / 2 * images**2).sum(),
        }


def noise_frame(size: tuple[int, int] = (6, 10), low: int = 30, high: int = 225) -> SensorFrame:
    projection = np.array([[120.0, 0, size[1] / 2, 0], [0, 120, size[0] / 2, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 65.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    images = np.random.default_rng(1).integers(low, high, (2, *size, 3), np.uint8)
    return SensorFrame("0", calibration, {2: images[0], 3: images[1]})


def views(frame: SensorFrame) -> np.ndarray:
    """Both images, shape (2, 3, H, W)."""
    return np.stack([frame.image(2), frame.image(3)]).transpose(0, 3, 1, 2).astype(float)


def random_slopes(bend: bool = False) -> Slopes:
    random = np.random.default_rng(2)
    slope = random.normal(size=(2, 3, 6, 10))
    # Bent about grey, a pixel's gradient may change its sign on the way.
    bends = random.normal(size=slope.shape) * bend
    return Slopes(slope - 128.0 * bends, bends)


def victim_of(detector: Any) -> Victim:
    return Victim(detector, CARS)


@pytest.mark.parametrize("alpha", [0.4, 1.0])
def test_the_iterates_of_a_linear_loss_are_known(alpha: float) -> None:
    frame, detector = noise_frame(low=0, high=256), random_slopes()
    iterates = list(thesis_pgd(alpha, steps=4).iterates(frame, victim_of(detector)))
    assert len(iterates) == len(detector.seen) == 4
    for n, attacked in enumerate(iterates, 1):
        expected = (views(frame) + n * alpha * np.sign(detector.slope.numpy())).clip(0, 255)
        np.testing.assert_allclose(views(attacked), expected, atol=1e-4)
        assert attacked.image(2).dtype == np.float32


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.name)
@pytest.mark.parametrize(("level", "sign"), [(255, 1.0), (0, -1.0)])
def test_no_image_is_brighter_than_white_or_darker_than_black(
    attack: Perturbation, level: int, sign: float
) -> None:
    frame = noise_frame(low=level, high=level + 1)
    detector = Slopes(np.full((2, 3, 6, 10), sign))
    for attacked in attack.iterates(frame, victim_of(detector)):
        assert views(attacked).min() >= 0.0
        assert views(attacked).max() <= 255.0
    assert views(attacked).mean() == pytest.approx(level, abs=1e-4) or attack.random_start


def test_a_bare_pgd_names_both_forms() -> None:
    with pytest.raises(ConfigurationError, match=r"thesis_pgd.*projected_pgd"):
        pgd(alpha=1.0, steps=4)


def test_the_change_is_projected_at_each_step_and_the_thesis_form_is_not() -> None:
    frame, detector = noise_frame(), random_slopes()
    projected = projected_pgd(2.0, alpha=0.75, steps=4, random_start=False)
    unprojected = thesis_pgd(0.75, 4, epsilon=2.0)
    sizes = [
        [
            np.abs(views(attacked) - views(frame)).max()
            for attacked in attack.iterates(frame, victim_of(detector))
        ]
        for attack in (projected, unprojected)
    ]
    assert sizes == [[0.75, 1.5, 2.0, 2.0], [0.75, 1.5, 2.25, 3.0]]


def test_epsilon_bounds_a_step_and_not_the_sum() -> None:
    frame, detector = noise_frame(), random_slopes()
    attacked = Perturbation(alpha=1.0, epsilon=0.25, steps=3).attack(frame, victim_of(detector))
    change = views(attacked) - views(frame)
    np.testing.assert_array_equal(change, 0.75 * np.sign(detector.slope.numpy()))


def test_one_delta_for_both_views_follows_the_sum_of_their_slopes() -> None:
    frame, detector = noise_frame(), random_slopes()
    left, right = views(thesis_pgd(shared=True).attack(frame, victim_of(detector))) - views(frame)
    np.testing.assert_array_equal(left, 4 * np.sign(detector.slope.numpy().sum(axis=0)))
    np.testing.assert_array_equal(right, left)
    start = projected_pgd(shared=True, steps=1).attack(frame, victim_of(detector), seed=3)
    left, right = views(start) - views(frame)
    np.testing.assert_allclose(right, left, atol=1e-4)


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.name)
def test_presets_are_attacks_that_keep_their_budget_and_raise_the_loss(
    attack: Perturbation,
) -> None:
    frame, detector = noise_frame(), random_slopes(bend=True)
    assert isinstance(attack, Attack)
    attacked = attack.attack(frame, victim_of(detector), seed=5)
    assert not attack.budget.exceeded_by(frame, attacked)
    assert replace(attack.budget, change=attack.budget.change * 0.9).exceeded_by(frame, attacked)
    before, after = (
        float(total_loss(detector, batch_of_frames([f]), [CARS])) for f in (frame, attacked)
    )
    noisy = RandomNoise(attack.budget.change).attack(frame, victim_of(detector), seed=5)
    by_noise = float(total_loss(detector, batch_of_frames([noisy]), [CARS]))
    assert after - before > 3 * abs(by_noise - before)


def test_budgets() -> None:
    assert [attack.budget.change for attack in ALL] == pytest.approx([4, 1.2, 1, 4, 4, 4, 4])
    assert projected_pgd(alpha=0.5, steps=2).budget.change == 4
    assert i_fgsm(alpha=0.5, steps=2).budget.change == 1


@pytest.mark.parametrize(("epsilon", "steps"), [(0.5, 1), (4.0, 5), (16.0, 20), (32.0, 36)])
def test_i_fgsm_takes_as_many_steps_as_its_paper(epsilon: float, steps: int) -> None:
    """min(epsilon + 4, 1.25 epsilon): the two meet at 16."""
    assert i_fgsm(epsilon).steps == steps


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.name)
def test_fewer_steps_are_the_start_of_more(attack: Perturbation) -> None:
    frame, victim = noise_frame(), victim_of(random_slopes(bend=True))
    iterates = list(attack.iterates(frame, victim, seed=[7, 1]))
    assert len(iterates) == attack.steps
    for n, attacked in enumerate(iterates, 1):
        alone = replace(attack, steps=n).attack(frame, victim, seed=[7, 1])
        np.testing.assert_array_equal(views(alone), views(attacked))


def test_the_seed_decides_where_a_random_start_is() -> None:
    frame, victim = noise_frame(), victim_of(random_slopes())
    attack = projected_pgd(alpha=1e-6, steps=1)  # Too short to leave the start.
    one, again, other = (views(attack.attack(frame, victim, seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert (one != other).all()
    start = one - views(frame)
    assert -4.001 <= start.min() < -3.9
    assert 3.9 < start.max() <= 4.001
    assert start.std() == pytest.approx(4 / np.sqrt(3), rel=0.1)
    assert (start[0] != start[1]).all()


def test_whole_grey_levels_swallow_a_small_step() -> None:
    frame, detector = noise_frame(), random_slopes()
    one, two = (
        views(quantised(attacked)) - views(frame)
        for attacked in thesis_pgd(0.4, steps=2).iterates(frame, victim_of(detector))
    )
    assert not one.any()
    np.testing.assert_array_equal(two, np.sign(detector.slope.numpy()))


def test_momentum_is_the_papers() -> None:
    """Dong et al., algorithm 1, in NumPy: g = mu g + J / |J|_1, x = x + alpha sign(g)."""
    frame, detector = noise_frame(low=80, high=176), random_slopes(bend=True)
    slope, bend = detector.slope.numpy(), detector.bend.numpy()
    x, g = views(frame), np.zeros((2, 3, 6, 10))
    for attacked in mi_fgsm(epsilon=40.0, steps=8, momentum=0.9).iterates(
        frame, victim_of(detector)
    ):
        gradient = slope + bend * x
        g = 0.9 * g + gradient / np.abs(gradient).sum()
        x = x + 5.0 * np.sign(g)
        np.testing.assert_allclose(views(attacked), x, atol=1e-3)
    plain = views(thesis_pgd(5.0, 8).attack(frame, victim_of(detector)))
    assert (plain != views(attacked)).mean() > 0.01


def test_each_pair_of_a_batch_has_its_own_momentum() -> None:
    frame, detector = noise_frame(), random_slopes(bend=True)
    # The gradient of the second pair is much larger: with a common norm nothing is left of it.
    batch = batch_of_frames([frame, noise_frame(low=200, high=201)])
    *_, together = mi_fgsm().perturbed(batch, detector, [CARS, CARS])
    *_, alone = mi_fgsm().perturbed(batch_of_frames([frame]), detector, [CARS])
    np.testing.assert_array_equal(together.left[0], alone.left[0])
    np.testing.assert_array_equal(together.right[0], alone.right[0])


def test_the_projected_form_stays_in_the_ball() -> None:
    frame, victim = noise_frame(low=0, high=256), victim_of(random_slopes())
    for seed in range(3):
        for attacked in projected_pgd(2.0, alpha=1.5, steps=5).iterates(frame, victim, seed):
            assert np.abs(views(attacked) - views(frame)).max() <= 2.0 + 1e-4
            assert views(attacked).min() >= 0
            assert views(attacked).max() <= 255
    free = Perturbation(1.5, 2.0, 5).attack(frame, victim)
    assert np.abs(views(free) - views(frame)).max() == 7.5


def test_the_disparity_reaches_the_loss() -> None:
    frame, detector = noise_frame(), random_slopes()
    disparity = np.full((6, 10), 7.0, np.float32)
    thesis_pgd(steps=1).attack(frame, Victim(detector, CARS, disparity=disparity))
    assert detector.seen[0] is not None
    assert detector.seen[0].shape == (1, 6, 10)
    with pytest.raises(ConfigurationError, match="disparity"):
        thesis_pgd().attack(frame, Victim(detector, CARS, disparity=disparity[:3]))


def test_what_has_no_loss_cannot_be_climbed() -> None:
    frame = noise_frame()
    with pytest.raises(ConfigurationError, match="'oracle' has no `losses`"):
        thesis_pgd().attack(frame, victim_of(Oracle()))
    blind = random_slopes()
    blind.losses = torch.no_grad()(blind.losses)  # type: ignore[method-assign]
    with pytest.raises(ConfigurationError, match="no function of the pixels"):
        thesis_pgd().attack(frame, victim_of(blind))


@pytest.mark.parametrize(
    "make",
    [
        lambda: thesis_pgd(0.0),
        lambda: thesis_pgd(float("nan")),
        lambda: thesis_pgd(steps=0),
        lambda: thesis_pgd(epsilon=-1.0),
        lambda: mi_fgsm(steps=0),
        lambda: mi_fgsm(momentum=-0.1),
        lambda: Perturbation(projected=True),
        lambda: Perturbation(epsilon=4.0, random_start=True),
    ],
)
def test_impossible_settings_are_refused(make: Callable[[], Perturbation]) -> None:
    with pytest.raises(ConfigurationError):
        make()


@pytest.mark.slow
@pytest.mark.parametrize("kind", [DsgnDetector, StereoRcnnDetector])
def test_networks_are_attacked_and_left_as_they_are(kind: Any) -> None:
    torch.manual_seed(0)
    detector, frame = kind("small"), noise_frame((96, 320))
    detector.network.requires_grad_(True)
    weights = [weight.clone() for weight in detector.network.parameters()]
    attacked = thesis_pgd(steps=2).attack(frame, victim_of(detector))
    assert not detector.network.training
    for weight, before in zip(detector.network.parameters(), weights, strict=True):
        assert weight.grad is None
        assert torch.equal(weight, before)
    noisy = RandomNoise(2.0).attack(frame, victim_of(detector))
    with torch.no_grad():
        before, after, by_noise = (
            float(total_loss(detector, batch_of_frames([f]), [CARS]))
            for f in (frame, attacked, noisy)
        )
    assert after > before
    assert after - before > 3 * abs(by_noise - before)


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (thesis_pgd(), Perturbation(1.0, None, 4, name="thesis_pgd")),
        (fgsm(), Perturbation(4.0, 4.0, 1, name="fgsm")),
        # Kurakin et al.: min(epsilon + 4, 1.25 epsilon) steps of one grey level.
        (i_fgsm(), Perturbation(1.0, 4.0, 5, projected=True, name="i_fgsm")),
        (i_fgsm(20.0), Perturbation(1.0, 20.0, 24, projected=True, name="i_fgsm")),
        # Dong et al.: alpha is epsilon / N, and the momentum 1.
        (mi_fgsm(), Perturbation(1.0, 4.0, 4, 1.0, projected=True, name="mi_fgsm")),
        (mi_fgsm(8.0, 10), Perturbation(0.8, 8.0, 10, 1.0, projected=True, name="mi_fgsm")),
        # Madry et al.: 7 steps of a quarter of epsilon, from anywhere in the ball.
        (
            projected_pgd(8.0),
            Perturbation(2.0, 8.0, 7, 0.0, True, True, False, name="projected_pgd"),
        ),
    ],
    ids=lambda each: each.name if isinstance(each, Perturbation) else "",
)
def test_named_attacks_are_those_of_their_papers(
    made: Perturbation, expected: Perturbation
) -> None:
    assert made == expected
