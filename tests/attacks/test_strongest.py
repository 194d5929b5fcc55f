"""The strongest of several attacks: by the detector's answers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.attacks.attack import Budget, Seed, Victim
from avsec_gym.attacks.strongest import StrongestAttack
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.rig import kitti_rig

FRAME = SensorFrame(
    "1", kitti_rig().calibration, {camera: np.full((8, 16, 3), 100, np.uint8) for camera in (2, 3)}
)
TRUTH = Boxes3D(
    np.array([[0.0, 1.6, 12.0]]), np.array([[1.5, 1.6, 4.0]]), np.array([0.0]), np.array([1.0]),
    np.array(["Car"]),
)  # fmt: skip


class Brighter:
    """Adds light, and keeps its seeds."""

    def __init__(self, change: float, area: int | None = None) -> None:
        self.name, self.change = f"brighter {change:g}", change
        self.budget = Budget(change, area)
        self.seeds: list[Seed] = []

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        self.seeds.append(seed)
        return frame.with_image(2, frame.image(2).astype(np.float32) + self.change)


class Answers:
    """Finds the car a metre farther away for each grey level that is added; it has no loss."""

    name = "answers"

    def __init__(self) -> None:
        self.queries = 0

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.queries += 1
        away = float(frame.image(2).mean()) - 100.0
        return replace(TRUTH, location=TRUTH.location + np.array([[0.0, 0.0, away]]))


class Lossy(Answers):
    """Its loss is highest where it finds the car at its place."""

    name = "lossy"

    def detect_batch(self, batch: Any) -> list[Boxes3D]:
        raise NotImplementedError

    def losses(self, batch: Any, truth: Any, disparity: Any = None) -> dict[str, torch.Tensor]:
        return {"loss": -(batch.left.mean() - 100.0).abs()}


def brightness(attack: StrongestAttack, detector: Any, seed: Seed = 0) -> float:
    return float(attack.attack(FRAME, Victim(detector, TRUTH), seed).image(2).mean())


@pytest.mark.parametrize("made", [Answers, Lossy])
def test_the_answers_decide_whether_there_is_a_loss_or_not(made: type[Answers]) -> None:
    assert isinstance(Lossy(), DifferentiableDetector)
    for changes in [(0.0, 1.0), (1.0, 0.0)]:
        detector = made()
        assert brightness(StrongestAttack([*map(Brighter, changes)]), detector) == 101.0
        assert detector.queries == 2


def test_an_object_that_is_gone_is_worse_than_one_that_is_found() -> None:
    class Dark(Answers):
        def detect(self, frame: SensorFrame) -> Boxes3D:
            return TRUTH if frame.image(2).mean() < 105 else Boxes3D.empty()

    assert brightness(StrongestAttack([Brighter(1.0), Brighter(8.0), Brighter(2.0)]), Dark()) == 108


def test_each_attack_draws_for_itself_and_the_first_of_equals_is_kept() -> None:
    same = Brighter(3.0)
    attack = StrongestAttack([same, same, Brighter(3.0, 10)])
    assert brightness(attack, Answers(), (7, 2)) == 103.0
    assert same.seeds == [[7, 2, 0], [7, 2, 1]]
    assert attack.budget == Budget(3.0, None)
    assert StrongestAttack([Brighter(3.0, 10), Brighter(1.0, 30)]).budget == Budget(3.0, 30)


def test_it_knows_a_white_box_if_one_of_them_does() -> None:
    noise = {"name": "random_noise", "strength": 2.0}
    assert StrongestAttack([noise, "fgsm"]).needs_gradient
    assert not StrongestAttack([noise]).needs_gradient
    transferred = {"name": "transferred", "attack": "fgsm", "of": "oracle"}
    assert not StrongestAttack([transferred]).needs_gradient


@pytest.mark.parametrize("attacks", [[], "fgsm", {"name": "fgsm"}, 3, ["fgsn"]])
def test_what_is_no_list_of_attacks_is_refused(attacks: Any) -> None:
    with pytest.raises(ConfigurationError, match=r"attacks|fgsn"):
        StrongestAttack(attacks)
