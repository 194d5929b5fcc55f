"""Perturbations that another detector's gradients span, by surrogates of closed form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from torch import Tensor

import avsec_gym  # noqa: F401
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.gradient_basis import TERMS, GradientBasis
from avsec_gym.envs.perturbation_attack import PerturbationAttackEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.registry import Kind, make
from tests.finds_nothing import FindsNothing

ID = "avsec/PerturbationAttack-v0"
SHIPPED = {"name": "dsgn", "weights": "shipped"}
BEHIND = {"name": "defended", "defence": "jpeg"}
UNDER = {"name": "attacked", "attack": "random_noise"}
"""Lack the detector within."""


class Surrogate(FindsNothing):
    """Losses whose gradients are known: by column, by row, by colour, and none."""

    name = "surrogate"

    def __init__(self) -> None:
        self.asked = 0

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        self.asked += 1
        height, width = batch.left.shape[-2:]
        columns = torch.linspace(-1.0, 1.0, width)
        rows = torch.linspace(-5.0, 5.0, height)[:, None]
        return {
            "columns": (batch.left * columns).sum() - (batch.right * columns).sum(),
            "rows": (batch.left * rows).sum(),
            "red": 3.0 * batch.left[:, 0].sum() + batch.right[:, 0].sum(),
            "nothing": torch.zeros(()),
        }


class WithWeights(Surrogate):
    """One that has a network."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        torch.manual_seed(seed)
        self.network = torch.nn.Linear(2, 2)


class Judged:
    """A black box: it keeps what it sees, and its losses must not be asked."""

    name = "judged"

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return Boxes3D.empty()

    def losses(self, *_: Any) -> dict[str, Tensor]:
        raise AssertionError("the attacker looked into the judged detector")


def changes(judged: Judged) -> list[np.ndarray]:
    """What the last query changed in the left and the right image."""
    clean, attacked = judged.frames[0], judged.frames[-1]
    return [np.subtract(attacked.image(c), clean.image(c), dtype=int) for c in (2, 3)]


def played(quick: dict[str, Any], action: Sequence[float], **given: Any) -> tuple[Any, Judged, Any]:
    judged = Judged()
    env = gym.make(ID, **quick | {"detector": judged}, epsilon=5, **given)
    env.reset(seed=0, options={"scenario": "000000", "intention": "straight"})
    return env, judged, env.step(np.array(action, np.float32))[-1]


def test_a_pattern_is_the_sign_of_the_sum_of_the_gradients(quick: dict[str, Any]) -> None:
    """Of gradients that are made equally large."""
    given = {"surrogate": Surrogate(), "terms": ["columns", "rows", "red"], "shared": False}
    left, right = (0.5, -1.0, 0.25), (1.0, 0.0, 0.0)
    _, judged, info = played(quick, (*left, *right), **given)
    height, width = judged.frames[0].image(2).shape[:2]
    column = np.linspace(-1.0, 1.0, width)[None, :, None] * np.ones((height, 1, 3))
    row = np.linspace(-5.0, 5.0, height)[:, None, None] * np.ones((1, width, 3))
    red = np.ones((height, width, 1)) * (3.0, 0.0, 0.0)
    mean = [np.abs(column).mean(), np.abs(row).mean() / 2, (3.0 + 1.0) / 3 / 2]
    total = sum(c * g / m for c, g, m in zip(left, (column, row, red), mean, strict=True))
    expected = 5 * np.sign(total), -5 * np.sign(column)
    for change, wanted in zip(changes(judged), expected, strict=True):
        assert (change == wanted).mean() > 0.99
    assert info["change"] == 5


def test_both_images_get_one_pattern_where_it_is_shared(quick: dict[str, Any]) -> None:
    given = {"surrogate": Surrogate(), "terms": ["columns", "red"]}
    env, judged, _ = played(quick, (0.0, 1.0), **given)
    assert env.action_space.shape == (2,)
    left, right = changes(judged)
    np.testing.assert_array_equal(left, right)
    assert (left[..., 0] == 5).all()
    assert not left[..., 1:].any()


def test_no_change_exceeds_the_budget(quick: dict[str, Any]) -> None:
    env, judged, _ = played(quick, (0.0, 0.0), surrogate=Surrogate(), terms=["columns", "rows"])
    assert not any(change.any() for change in changes(judged))
    for action in np.random.default_rng(0).uniform(-1, 1, (6, 2)).astype(np.float32):
        env.reset(seed=0, options={"scenario": "000000", "intention": "straight"})
        info = env.step(action)[-1]
        largest = max(np.abs(change).max() for change in changes(judged))
        assert largest == info["change"] <= np.rint(5 * np.abs(action).max())
        assert not env.unwrapped.budget.exceeded_by(judged.frames[0], judged.frames[-1])


def test_only_the_surrogate_is_asked_for_gradients_once_a_scene(quick: dict[str, Any]) -> None:
    """At the clean pixels: queries find out no further gradient."""
    surrogate = Surrogate()
    env, judged, _ = played(quick, (1.0,), surrogate=surrogate, terms=["rows"])
    for _ in range(3):
        env.step(np.array([-0.5], np.float32))
    assert surrogate.asked == 1
    assert len(judged.frames) == 5
    env.reset(seed=0, options={"scenario": "000001", "intention": "straight"})
    env.step(np.array([1.0], np.float32))
    assert surrogate.asked == 2


def test_a_term_without_a_gradient_changes_nothing(quick: dict[str, Any]) -> None:
    _, judged, _ = played(quick, (1.0,), surrogate=Surrogate(), terms=["nothing"])
    assert not any(change.any() for change in changes(judged))


@pytest.mark.slow
@pytest.mark.parametrize("name", TERMS)
def test_the_packages_detectors_have_these_terms_and_repeat(
    name: str, quick: dict[str, Any]
) -> None:
    """Twice the same attacked pixels, by networks made anew."""
    seen = []
    for _ in range(2):
        given = {"surrogate": {"name": name, "weights": "shipped"}, "terms": TERMS[name]}
        _, judged, info = played(quick, np.linspace(-1.0, 1.0, len(TERMS[name])), **given)
        assert info["change"] == 5
        seen.append(judged.frames[-1].image(2))
    np.testing.assert_array_equal(*seen)


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"surrogate": "dsgm"}, 'mean "dsgn"'),
        ({"surrogate": "dsgn"}, "the car's own detector"),
        ({"surrogate": {"name": "dsgn"}}, "the car's own detector"),
        ({"surrogate": "stereo_rcnn", "detector": {"name": "stereo_rcnn"}}, "own detector"),
        ({"surrogate": SHIPPED, "detector": "dsgn"}, "own detector"),
        ({"surrogate": "dsgn", "detector": {"name": "defended", "detector": "dsgn"}}, "own det"),
        (
            {
                "surrogate": "dsgn",
                "detector": {**UNDER, "detector": {**BEHIND, "detector": SHIPPED}},
            },
            "own detector",
        ),
        ({"surrogate": {**BEHIND, "detector": "dsgn"}, "terms": ["box"]}, "own detector"),
        ({"surrogate": "oracle"}, "terms names those"),
        ({"surrogate": "stereo_rcnn", "terms": "class"}, "a list of names"),
        ({"surrogate": "stereo_rcnn", "terms": []}, "a list of names"),
        ({"terms": ["class"]}, "terms are those of a surrogate"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_at_once(given: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigurationError, match=complaint):
        PerturbationAttackEnv(**given)


def test_the_live_detector_of_the_car_is_no_surrogate() -> None:
    judged = Judged()
    behind = {**BEHIND, "detector": judged}
    for detector in (judged, behind):
        with pytest.raises(ConfigurationError, match="own detector"):
            PerturbationAttackEnv(detector=detector, surrogate=judged, terms=["rows"])


def test_the_weights_of_the_car_are_no_surrogate_under_whatever_name(quick: dict[str, Any]) -> None:
    """Found where both are made, at the first reset."""
    car, copy, other = WithWeights(0), WithWeights(0), WithWeights(1)
    for detector in (car, {**BEHIND, "detector": car}):
        given = {**quick, "detector": detector, "terms": ["rows"]}
        with pytest.raises(ConfigurationError, match="own detector"):
            PerturbationAttackEnv(**given, surrogate=copy).game  # noqa: B018
        PerturbationAttackEnv(**given, surrogate=other).game  # noqa: B018


@pytest.mark.parametrize("weights", ["mine.safetensors", None])
def test_other_weights_of_the_same_network_are_another_detector(weights: str | None) -> None:
    other = {"name": "dsgn", "weights": weights}
    assert PerturbationAttackEnv(surrogate=other).action_space.shape == (3,)


def test_a_surrogate_without_a_loss_or_the_term_is_refused(quick: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match=r"no term 'rws'.*mean \"rows\""):
        played(quick, (1.0,), surrogate=Surrogate(), terms=["rws"])
    with pytest.raises(ConfigurationError, match="has no `losses`"):
        played(quick, (1.0,), surrogate=make(Kind.DETECTOR, "oracle"), terms=["class"])


def test_arguments_are_plain_json() -> None:
    """And nothing is loaded before it is asked for."""
    spec = gym.make(ID, surrogate="stereo_rcnn").spec
    assert spec is not None
    env = gym.make(gym.envs.registration.EnvSpec.from_json(spec.to_json()))
    assert env.action_space.shape == (6,)
    assert env.observation_space.shape == (119 + 6,)
    assert isinstance(env.unwrapped.basis, GradientBasis)  # type: ignore[attr-defined]
