"""Attacks that know one detector, on a car with another."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.attack import Budget, Seed, Victim
from avsec_gym.attacks.transferred import TransferredAttack
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig


class Detector:
    """A detector that is asked for nothing."""

    def __init__(self, name: str) -> None:
        self.name = name

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return Boxes3D.empty()


class Recorder:
    """An attack that keeps what it was given."""

    name = "recorder"
    budget = Budget(2.0)

    def __init__(self) -> None:
        self.given: list[tuple[Victim, Seed]] = []

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        self.given.append((victim, seed))
        return frame


def test_the_attack_is_made_for_the_detector_that_the_attacker_has() -> None:
    attack, known, judged = Recorder(), Detector("known"), Detector("judged")
    transferred = TransferredAttack(attack, known)
    assert transferred.name == "recorder of known"
    assert transferred.budget == attack.budget
    frame = SensorFrame("1", kitti_rig().calibration, {2: np.zeros((4, 4, 3), np.uint8)})
    labels = Boxes3D.empty()
    assert transferred.attack(frame, Victim(judged, labels), (3, 4)) is frame
    [(victim, seed)] = attack.given
    assert victim.detector is known
    assert victim.truth is labels
    assert seed == (3, 4)


def test_what_there_is_not_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="attack"):
        TransferredAttack("no_such_attack", "oracle")
    with pytest.raises(ConfigurationError, match="of"):
        TransferredAttack("thesis_pgd", "no_such_detector")
