"""The strongest of several attacks on one frame, as AutoAttack joins its own (Croce, Hein 2020)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from avsec_gym.attacks.attack import Attack, Budget, Seed, Victim, quantised
from avsec_gym.attacks.seed_numbers import seed_numbers
from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.registry import Kind, made_part


class StrongestAttack:
    """Tries several attacks on pixels, and keeps the frame that harms the victim's detector most.

    An attack that is listed twice begins anew: each draws for itself.  The harm is how badly the
    detector's answer to the frame in whole grey levels fits the truth, which takes a query for each
    attack and nothing else.  A training loss does not measure it: terms that change no detection
    count as much as those that make a car vanish.

    Args:
        attacks: The attacks, one or more, each by name, as a dictionary, or an object.

    Raises:
        ConfigurationError: There is none of that name, or none at all.

    Example:
        >>> StrongestAttack(["fgsm", "projected_pgd"]).name
        'strongest of fgsm, projected_pgd'
    """

    def __init__(self, attacks: Sequence[Any]) -> None:
        if isinstance(attacks, str) or not isinstance(attacks, Sequence) or not attacks:
            raise ConfigurationError(
                "attacks takes a list of attacks, one or more, such as"
                ' ["projected_pgd", "projected_pgd"]'
            )
        self._attacks: list[Attack] = [made_part("attacks", Kind.ATTACK, each) for each in attacks]
        names = dict.fromkeys(attack.name for attack in self._attacks)
        self.name = f"strongest of {', '.join(names)}"

    @property
    def budget(self) -> Budget:
        """What the widest of them may change."""
        budgets = [attack.budget for attack in self._attacks]
        areas = [each.area for each in budgets if each.area is not None]
        area = max(areas) if len(areas) == len(budgets) else None
        return Budget(max(each.change for each in budgets), area)

    @property
    def needs_gradient(self) -> bool:
        """Whether one of them climbs the victim's own loss."""
        return any(getattr(attack, "needs_gradient", False) for attack in self._attacks)

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The frame of the attack that harms most, the first of equals; see `Attack.attack`."""
        best, least = frame, np.inf
        for number, attack in enumerate(self._attacks):
            attacked = attack.attack(frame, victim, [*seed_numbers(seed), number])
            fit = _fit(victim.detector.detect(quantised(attacked)), victim.truth)
            if fit < least:
                best, least = attacked, fit
        return best


def _fit(found: Boxes3D, truth: Boxes3D) -> float:
    """Sum over the true objects of the best overlap from above times score, less that of ghosts."""
    if not len(found):
        return 0.0
    scores = np.clip(found.score, 0.0, None)
    if not len(truth):
        return -float(scores.sum())
    overlap = rectangle_iou(
        *(
            ground_rectangles(boxes.location, boxes.dimensions, boxes.rotation_y)
            for boxes in (truth, found)
        )
    )
    missed = 1.0 - overlap.max(axis=0)
    return float((overlap * scores).max(axis=1).sum() - (missed * scores).sum())
