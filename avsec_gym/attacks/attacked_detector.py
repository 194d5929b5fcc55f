"""A detector that looks through an attack: what it sees can be written, scored and driven by."""

from __future__ import annotations

from typing import Any

from avsec_gym.argument_checks import seed_number
from avsec_gym.attacks.attack import Victim, quantised
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import read_labels
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.registry import Kind, kind_of, made_part


class AttackedDetector:
    """Any detector, on frames that any attack has tampered with.

    Args:
        detector: The detector, by name, as a dictionary, or an object.
        attack: The attack, by name likewise: an optical one, or one on what detectors see.
        seed: Seed of the attack, beside the frame's number.

    Raises:
        ConfigurationError: There is none of that name, or what a plug-in makes is none.

    Example:
        >>> AttackedDetector("oracle", {"name": "facula", "camera": 2}).name
        'oracle under facula'
    """

    def __init__(self, detector: Any, attack: Any, seed: int = 0) -> None:
        self._detector: Detector = made_part("detector", Kind.DETECTOR, detector)
        self._attack = made_part("attack", attack_kind(attack), attack)
        self._seed = seed_number("seed", seed)
        self.name = f"{self._detector.name} under {self._attack.name}"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """What the detector sees; images have whole grey levels, as a camera's have.

        Raises:
            DataError: The frame lacks what the detector needs, or labels that the attack needs.
        """
        number = int("".join(filter(str.isdecimal, frame.id)) or 0)
        seed = (self._seed, number)
        if isinstance(self._attack, OpticalAttack):
            return self._detector.detect(self._attack.attack(frame, seed).frame)
        victim = Victim(self._detector, _labels(frame))
        return self._detector.detect(quantised(self._attack.attack(frame, victim, seed)))


def attack_kind(attack: Any) -> Kind:
    """Whether what is given by name, or as a dictionary, is an optical attack or another one.

    Raises:
        ConfigurationError: It has the name of neither.
    """
    return kind_of(attack, (Kind.ATTACK, Kind.OPTICAL_ATTACK))


def _labels(frame: SensorFrame) -> Boxes3D:
    if frame.origin is None:
        raise DataError(
            f"Frame {frame.id} does not come from a folder: an attack on a detector asks for"
            " labels.",
            remedy="Open it with KittiObject(root).frame(id).",
        )
    return read_labels(frame.origin / "label_2" / f"{frame.id}.txt")
