"""What the car is shown under an attack, one frame after the other: the looks of a cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from avsec_gym.attacks.attack import Victim, quantised
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.attacks.perturbation import Perturbation
from avsec_gym.experiments.chapter5.settings import (
    STEPS,
    specific,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True, eq=False)
class CellLook:
    """A frame that the car is shown, and the settings of its results."""

    frame: SensorFrame
    attack: str
    strength: float = 0.0
    intentions: tuple[Intention, ...] = tuple(Intention)
    """The intentions of the episodes that follow."""
    seen_as: str = ""
    """Attack in the setting of detections, if it is not `attack`: a specific one has intentions."""
    place: PatchPlace | None = None
    """Place of a patch."""
    ghost_width: float | None = None
    """Width of the ghosts that the patch was trained towards, see `ghost_box`."""
    whole_levels: bool = False
    attacked: SensorFrame | None = None
    """The frame that the attack began with; None: the clean one."""


def perturbed_looks(
    attack: str, alpha: float, before: SensorFrame, victim: Victim
) -> Iterator[CellLook]:
    """Every n, as the attack leaves the pixels, and as a camera would deliver them."""
    iterates = Perturbation(alpha, steps=STEPS).iterates(before, victim)
    for n, frame in enumerate(iterates, start=1):
        yield CellLook(frame, attack, n, attacked=before)
        if not alpha.is_integer():  # Steps of whole levels leave nothing to round.
            yield CellLook(quantised(frame), attack, n, whole_levels=True)


def patched_looks(
    attack: str, patch: PatchAttack, clean: SensorFrame, victim: Victim, seed: tuple[int, int]
) -> Iterator[CellLook]:
    """One look for all intentions, or for each its own; a printed patch has whole levels anyway.

    Args:
        attack: The attack in the setting of results.
        patch: The attack itself.
        clean: The frame without an attack.
        victim: The detector, and what the attack knows of the scene.
        seed: The seed of what is drawn.
    """
    if patch.placement == "random":
        place = patch.placed(clean, victim, seed)
        frame = quantised(patch.attack(clean, victim, seed))
        yield CellLook(frame, attack, place=place, ghost_width=patch.ghost_width)
        return
    for number, intention in enumerate(Intention):
        aimed = replace(victim, intention=intention)
        place = patch.placed(clean, aimed, (*seed, number))
        frame = quantised(patch.attack(clean, aimed, (*seed, number)))
        yield CellLook(
            frame,
            attack,
            intentions=(intention,),
            seen_as=specific(attack, intention),
            place=place,
            ghost_width=patch.ghost_width,
        )
