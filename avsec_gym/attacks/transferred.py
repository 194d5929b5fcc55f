"""An attack that knows one detector, on a car that has another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avsec_gym.attacks.attack import Attack, Budget, Seed, Victim
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.registry import Kind, made_part


class TransferredAttack:
    """An attack on pixels that is made for a detector which the attacker has, not for the car's.

    Args:
        attack: The attack, by name, as a dictionary, or an object.
        of: The detector whose gradients it takes, likewise.

    Raises:
        ConfigurationError: There is none of that name.

    Example:
        >>> attack = {"name": "thesis_pgd", "steps": 2}
        >>> TransferredAttack(attack, "oracle").name
        'thesis_pgd of oracle'
    """

    def __init__(self, attack: Any, of: Any) -> None:
        self._attack: Attack = made_part("attack", Kind.ATTACK, attack)
        self._detector: Detector = made_part("of", Kind.DETECTOR, of)
        self.name = f"{self._attack.name} of {self._detector.name}"

    @property
    def budget(self) -> Budget:
        """What it may change at most."""
        return self._attack.budget

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The attack, see `Attack`; of the victim, everything is known but the detector."""
        return self._attack.attack(frame, replace(victim, detector=self._detector), seed)
