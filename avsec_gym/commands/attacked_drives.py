"""Attacks on the instants of drives in turn: those that last go on where they began."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from avsec_gym.validation.connected.attacks.attacked_instant import (
        AttackedInstant,
        AttackUnderWay,
        InstantAttack,
    )
    from avsec_gym.validation.connected.recordings import RecordedInstant


@dataclass(frozen=True)
class _Begun:
    """An attack on a drive, and the number of the instant at which it began."""

    attack: AttackUnderWay
    number: int


class AttackedDrives:
    """Attacks each instant of a source in turn.

    Every instant has to be shown, also one whose result is known: an attack that lasts begins at
    the first instant of its drive that offers a place, whether or not a run is resumed later.

    Args:
        attack: The attack.
        seed: Its seed; that of an instant, or of a drive under an attack that lasts, adds the
            number of the (first) instant.
    """

    def __init__(self, attack: InstantAttack, seed: int) -> None:
        self._attack, self._seed = attack, seed
        self._drive: str | None = None
        self._begun: _Begun | None = None

    def show(self, instant: RecordedInstant, number: int, drive: str) -> None:
        """Look at the next instant.

        Args:
            instant: The instant as it was recorded.
            number: Its number in the source.
            drive: Name of its drive.
        """
        from avsec_gym.validation.connected.attacks.attacked_instant import LastingAttack

        if drive != self._drive:
            self._drive, self._begun = drive, None
        if self._begun is None and isinstance(self._attack, LastingAttack):
            begun = self._attack.begin(instant, (self._seed, number))
            self._begun = None if begun is None else _Begun(begun, number)

    def attacked(self, instant: RecordedInstant, number: int) -> AttackedInstant | None:
        """The instant that was shown last, attacked; None where it offers nothing to attack.

        Args:
            instant: The instant as it was recorded.
            number: Its number in the source.
        """
        from avsec_gym.validation.connected.attacks.attacked_instant import LastingAttack

        if not isinstance(self._attack, LastingAttack):
            return self._attack.attack(instant, (self._seed, number))
        if self._begun is None:
            return None
        seconds = (number - self._begun.number) * self._attack.step
        return self._begun.attack.attack(instant, seconds)
