"""ART's attacks run on stereo detectors, and ours are theirs where the settings coincide."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Attack, Victim
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.perturbation import fgsm, i_fgsm, mi_fgsm, thesis_pgd
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.registry import make

pytest.importorskip("avsec_gym.attacks.art_estimator")  # First: it guards ART's first import.

from art.attacks import evasion

from avsec_gym.attacks.art_estimator import (
    StereoDetectorEstimator,
    packed,
    targets,
    unpacked,
)
from avsec_gym.attacks.toolbox_attack import ToolboxAttack

CARS = Boxes3D(
    [[-3.0, 1.6, 10], [3, 1.65, 14]],
    [[1.5, 1.6, 4.0], [1.4, 1.7, 4.2]],
    [-1.2, 0.4],
    np.ones(2),
    np.full(2, "Car"),
    truncation=np.zeros(2),
    occlusion=np.zeros(2),
)


class Waves:
    """A detector that finds the cars, with a loss that climbs and falls with every pixel."""

    name = "waves"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return CARS

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        return [CARS] * len(batch)

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        phase = torch.arange(batch.left.numel()).reshape(batch.left.shape)
        swing = (1 + phase % 7) * torch.sin(batch.left / 9 + phase)
        drift = torch.cos(batch.right / 5 - 2 * phase) * len(truth[0])
        return {"left": swing.sum(), "right": drift.sum()}


def frame_of(seed: int = 1, size: tuple[int, int] = (12, 20)) -> SensorFrame:
    projection = np.array([[120.0, 0, size[1] / 2, 0], [0, 120, size[0] / 2, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 65.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    images = np.random.default_rng(seed).integers(0, 256, (2, *size, 3), np.uint8)
    return SensorFrame("0", calibration, {2: images[0], 3: images[1]})


def difference(one: SensorFrame, two: SensorFrame) -> float:
    return max(float(np.abs(one.image(c).astype(float) - two.image(c)).max()) for c in (2, 3))


def loss_of(frame: SensorFrame) -> float:
    return float(total_loss(Waves(), batch_of_frames([frame]), [CARS]))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [DsgnDetector, StereoRcnnDetector])
def test_the_thesis_attack_is_theirs_where_the_sum_of_steps_fits_into_the_ball(kind: Any) -> None:
    torch.manual_seed(0)
    victim, frame = Victim(kind("small"), CARS), frame_of(size=(96, 320))
    theirs = ToolboxAttack("ProjectedGradientDescent", 3.0, {"eps_step": 1.0, "max_iter": 3})
    ours = thesis_pgd(alpha=1.0, steps=3).attack(frame, victim)
    assert difference(ours, frame) == 3
    assert difference(ours, theirs.attack(frame, victim)) == 0


@pytest.mark.parametrize(
    ("ours", "method", "epsilon", "arguments"),
    [
        (thesis_pgd(1.0, 4), "ProjectedGradientDescent", 4.0, {"eps_step": 1.0, "max_iter": 4}),
        (thesis_pgd(1.0, 4), "ProjectedGradientDescent", 9.0, {"eps_step": 1.0, "max_iter": 4}),
        (thesis_pgd(0.4, 4), "ProjectedGradientDescent", 1.6, {"eps_step": 0.4, "max_iter": 4}),
        (fgsm(4.0), "FastGradientMethod", 4.0, {}),
        (i_fgsm(4.0, steps=9), "BasicIterativeMethod", 4.0, {"eps_step": 1.0, "max_iter": 9}),
        (
            mi_fgsm(4.0, steps=5, momentum=0.8),
            "MomentumIterativeMethod",
            4.0,
            {"eps_step": 0.8, "max_iter": 5, "decay": 0.8},
        ),
    ],
)
def test_every_preset_is_theirs(ours: Any, method: str, epsilon: float, arguments: Any) -> None:
    frame, victim = frame_of(), Victim(Waves(), CARS)
    theirs = ToolboxAttack(method, epsilon, arguments)
    assert isinstance(theirs, Attack)
    attacked = theirs.attack(frame, victim)
    # Where alpha is no whole number, they and we add in another order.
    assert difference(ours.attack(frame, victim), attacked) < 1e-4
    assert not theirs.budget.exceeded_by(frame, attacked)
    assert loss_of(attacked) > loss_of(frame) + 100


def test_other_norms_keep_the_budget_too() -> None:
    frame, victim = frame_of(), Victim(Waves(), CARS)
    attack = ToolboxAttack(
        "ProjectedGradientDescent", 60.0, {"norm": 2, "eps_step": 20.0, "max_iter": 5}
    )
    attacked = attack.attack(frame, victim)
    assert not attack.budget.exceeded_by(frame, attacked)
    assert np.linalg.norm(packed([attacked]) - packed([frame])) <= 60.001
    assert loss_of(attacked) > loss_of(frame)


def test_a_black_box_attack_only_asks_for_the_loss() -> None:
    frame = frame_of()
    estimator = StereoDetectorEstimator(Waves(), frame)
    np.random.seed(0)  # noqa: NPY002 - the generator that ART draws from.
    attack = evasion.SquareAttack(
        estimator,
        adv_criterion=lambda _, truth: np.zeros(len(truth), bool),
        loss=lambda x, truth: -estimator.compute_loss(x, truth),
        eps=4.0,
        max_iter=50,
        p_init=0.2,
        verbose=False,
    )
    attacked = unpacked(attack.generate(packed([frame]), targets([CARS]))[0], frame)
    assert loss_of(attacked) > loss_of(frame)
    assert difference(attacked, frame) <= 4.001


def test_each_pair_is_attacked_for_itself_and_detections_stand_in_for_targets() -> None:
    frames = [frame_of(1), frame_of(2)]
    estimator = StereoDetectorEstimator(Waves(), frames[0])
    attack = evasion.BasicIterativeMethod(
        estimator, eps=4.0, eps_step=1.0, max_iter=2, verbose=False
    )
    for attacked, frame in zip(attack.generate(packed(frames)), frames, strict=True):
        expected = thesis_pgd(steps=2).attack(frame, Victim(Waves(), CARS))
        assert difference(unpacked(attacked, frame), expected) == 0


def test_the_toolbox_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    attack = ToolboxAttack("ProjectedGradientDescent", 3.0, {"eps_step": 1.0, "max_iter": 2})
    attack.attack(frame_of(), Victim(Waves(), CARS))
    assert capfd.readouterr() == ("", "")


def test_every_pair_needs_a_truth_of_its_own() -> None:
    estimator = StereoDetectorEstimator(Waves(), frame_of())
    x = packed([frame_of(1), frame_of(2)])
    for function in (estimator.compute_loss, estimator.loss_gradient):
        with pytest.raises(ValueError, match="shorter"):
            function(x, targets([CARS]))


def test_the_gradient_is_the_slope_of_the_loss() -> None:
    frame = frame_of()
    estimator = StereoDetectorEstimator(Waves(), frame)
    x, y = packed([frame]), targets([CARS])
    assert x.shape == (1, *estimator.input_shape) == (1, 6, 12, 20)
    gradient = estimator.loss_gradient(x, y)
    for channel in (1, 4):
        ahead, behind = x.copy(), x.copy()
        ahead[0, channel, 5, 7] += 0.5
        behind[0, channel, 5, 7] -= 0.5
        slope = estimator.compute_loss(ahead, y) - estimator.compute_loss(behind, y)
        assert slope[0] == pytest.approx(gradient[0, channel, 5, 7], rel=0.02, abs=2e-3)


def test_packing_is_undone() -> None:
    frame = frame_of()
    again = unpacked(packed([frame])[0], frame)
    assert difference(frame, again) == 0


def test_seeds_hold_and_numpys_own_generator_stays() -> None:
    frame, victim = frame_of(), Victim(Waves(), CARS)
    attack = ToolboxAttack(
        "ProjectedGradientDescent", 8.0, {"eps_step": 2.0, "max_iter": 2, "random_eps": True}
    )
    np.random.seed(5)  # noqa: NPY002
    expected = np.random.random()  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    one, again, other = (attack.attack(frame, victim, seed) for seed in ([3, 1], [3, 1], 4))
    assert np.random.random() == expected  # noqa: NPY002
    assert difference(one, again) == 0
    assert difference(one, other) > 0


def test_what_cannot_run_says_so() -> None:
    frame, victim = frame_of(), Victim(Waves(), CARS)
    with pytest.raises(ConfigurationError, match="Strongest"):
        ToolboxAttack("StrongestAttack")
    with pytest.raises(ConfigurationError, match="asks for more than a loss"):
        ToolboxAttack("AutoProjectedGradientDescent")
    with pytest.raises(ConfigurationError, match="strength"):
        ToolboxAttack("FastGradientMethod", 4.0, {"strength": 3})
    for given in ({"eps": 8}, {"verbose": True}):
        with pytest.raises(ConfigurationError, match="has no argument"):
            ToolboxAttack(arguments=given)
    with pytest.raises(ConfigurationError, match="adv_criterion and loss"):
        make("attack", {"name": "art", "method": "SquareAttack"})
    with pytest.raises(ConfigurationError, match='Did you mean "max_iter"'):
        make("attack", {"name": "art", "arguments": {"max_itr": 3}})
    with pytest.raises(ConfigurationError, match="cannot be made"):
        ToolboxAttack("BasicIterativeMethod", arguments={"max_iter": -1}).attack(frame, victim)
    with pytest.raises(ConfigurationError, match="no `losses`"):
        StereoDetectorEstimator(Oracle(), frame)
    estimator = StereoDetectorEstimator(Waves(), frame)
    with pytest.raises(ConfigurationError, match="shape"):
        estimator.predict(np.zeros((1, 3, 12, 20), np.float32))
    with pytest.raises(ConfigurationError, match="avsec train"):
        estimator.fit(packed([frame]), targets([CARS]))


@pytest.mark.slow
def test_processes_with_a_new_home_may_import_it_at_once(tmp_path: Path) -> None:
    code = "import avsec_gym.attacks.art_estimator"
    environment = os.environ | {"HOME": str(tmp_path)}
    started = [
        subprocess.Popen([sys.executable, "-c", code], env=environment, stderr=subprocess.PIPE)
        for _ in range(3)
    ]
    for process in started:
        _, errors = process.communicate()
        assert process.returncode == 0, errors.decode()
    assert (tmp_path / ".art" / "config.json").is_file()


def test_without_the_toolbox_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "art.estimators", None)
    monkeypatch.delitem(sys.modules, "avsec_gym.attacks.art_estimator")
    monkeypatch.delattr("avsec_gym.attacks.art_estimator")
    with pytest.raises(ModuleNotFoundError, match=r"avsec-gym\[adversarial\]"):
        importlib.import_module("avsec_gym.attacks.art_estimator")
    with pytest.raises(ConfigurationError, match=r"avsec-gym\[adversarial\]"):
        ToolboxAttack()
