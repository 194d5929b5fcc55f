"""The strongest of several attacks on one frame, as AutoAttack joins its own (Croce, Hein 2020)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from avsec_gym.attacks.attack import Attack, Budget, Seed, Victim, quantised
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.registry import Kind, made_part


class StrongestAttack:
    """Tries several attacks on pixels, and keeps the frame that harms the victim's detector most.

    An attack that is listed twice begins anew: each draws for itself.  The harm is the detector's
    training loss on the frame in whole grey levels; of a detector without a loss it is how badly
    its answer fits the truth, which takes a query for each attack and nothing else.

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
        best, most = frame, -np.inf
        for number, attack in enumerate(self._attacks):
            attacked = attack.attack(frame, victim, [*np.atleast_1d(seed).tolist(), number])
            if (harm := _harm(attacked, victim)) > most:
                best, most = attacked, harm
        return best


def _harm(frame: SensorFrame, victim: Victim) -> float:
    """How badly the victim's detector does on an attacked frame as a camera delivers it."""
    seen = quantised(frame)
    if not isinstance(victim.detector, DifferentiableDetector):
        return -_fit(victim.detector.detect(seen), victim.truth)
    disparity = None if victim.disparity is None else torch.from_numpy(victim.disparity)[None]
    with torch.no_grad():
        loss = total_loss(victim.detector, batch_of_frames([seen]), [victim.truth], disparity)
    return float(torch.nan_to_num(loss, nan=-torch.inf))


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
