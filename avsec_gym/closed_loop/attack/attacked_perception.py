"""The perception of a car that is under attack while it drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from avsec_gym.closed_loop.attack.drive_attack import DriveAttack
from avsec_gym.closed_loop.perception import DrivePerception
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.pipeline import Perception


class AttackedPerception:
    """A `DrivePerception` between whose world and whose beliefs an attack stands.

    Args:
        make: Function that makes the perception without the attack, when it is first needed.
        attack: The attack.
    """

    def __init__(self, make: Callable[[], DrivePerception], attack: DriveAttack) -> None:
        self._make, self._attack = make, attack
        self._perception: DrivePerception | None = None
        self.alarm = False
        """Whether a validator raised an alarm about the last frame that it judged."""
        self.around: Surroundings
        """The truth around the car at the last frame that it perceived."""

    @property
    def unattacked(self) -> DrivePerception:
        """The same perception without the attack."""
        if self._perception is None:
            self._perception = self._make()
        return self._perception

    @property
    def frame_by_frame(self) -> bool:
        """The attribute of the perception without the attack; attacks see all frames by `act`."""
        return bool(getattr(self.unattacked, "frame_by_frame", False))

    def begin(self, seed: int) -> None:
        """Forget the last drive, and the attack on it."""
        self._attack.begin()
        self.unattacked.begin(seed)

    def perceive(self, surroundings: Surroundings) -> Perception:
        """What the car believes under the attack."""
        self.around = seen = surroundings
        read = surroundings.frame
        if read is not None and self._attack.sensors:
            seen = replace(seen, frame=lambda: self._attack.tampered(read(), surroundings))
        perception = self.unattacked.perceive(seen)
        self.alarm = perception.validation is not None and perception.validation.alarm
        return self._attack.believed(perception, surroundings)
