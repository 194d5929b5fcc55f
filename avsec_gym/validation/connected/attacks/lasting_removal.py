"""`LastingRemoval`: the same object is missing from one vehicle's scans, instant after instant."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from avsec_gym.argument_checks import label, number
from avsec_gym.attacks.attack import Seed
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.removed_object import DrawnRemoval, RemovedObject
from avsec_gym.validation.connected.attacks.seen_objects import seen_objects
from avsec_gym.validation.connected.recordings import RecordedInstant

_LONGEST_STEP = 10.0


@dataclass(frozen=True, eq=False)
class LastingRemoval:
    """An object that is removed from the victim's scans as long as the victim has points on it.

    It is followed by the number of its actor: without labels nothing is removed.

    Args:
        removal: What is drawn at the first instant, and how it is removed.
        step: Seconds between two instants of a drive.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    removal: RemovedObject = field(default_factory=RemovedObject)
    step: float = 0.1
    name: str = "lasting_removal"

    def __post_init__(self) -> None:
        number("step", self.step, 1e-3, _LONGEST_STEP)
        label("name", self.name)

    def attack(self, instant: RecordedInstant, seed: Seed = 0) -> AttackedInstant | None:
        """See `InstantAttack.attack`: the attack's first instant."""
        begun = self.begin(instant, seed)
        return None if begun is None else begun.attack(instant, 0.0)

    def begin(self, instant: RecordedInstant, seed: Seed = 0) -> RemovalUnderWay | None:
        """See `LastingAttack.begin`."""
        drawn = self.removal.drawn(instant, seed)
        if drawn is None or drawn.seen.actor is None:
            return None
        return RemovalUnderWay(self.removal, drawn)


@dataclass(frozen=True, eq=False)
class RemovalUnderWay:
    """A removal that has begun.

    Args:
        removal: The object that removes points.
        begun: What is removed, as the victim saw it at first.
    """

    removal: RemovedObject
    begun: DrawnRemoval

    def attack(self, instant: RecordedInstant, seconds: float) -> AttackedInstant | None:
        """See `AttackUnderWay.attack`; None where the victim has no point on the object."""
        actor = self.begun.seen.actor
        for seen in seen_objects(instant, self.begun.victim):
            if seen.actor == actor:
                return self.removal.remove(instant, replace(self.begun, seen=seen))
        return None
