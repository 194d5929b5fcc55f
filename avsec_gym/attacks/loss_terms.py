"""Which terms of a detector's training loss an attack climbs: all of them, or those of the class.

The thesis' L is the whole training loss.  An attack that only wants objects to be overlooked, or
the background taken for one, need not move boxes as well: Xie et al. ("Adversarial examples for
semantic segmentation and object detection", ICCV 2017) climb class scores alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from torch import Tensor

from avsec_gym.argument_checks import one_of
from avsec_gym.errors import ConfigurationError

CLASS_TERMS = frozenset({"classification", "class", "rpn_class"})
"""Names of the terms that judge classes: ``classification`` is DSGN's, ``rpn_class`` and ``class``
are those of Stereo R-CNN's two stages.  A plug-in's detector names its own likewise."""


class LossTerms(StrEnum):
    """What L is the sum of."""

    ALL = "all"
    """Every term of the training loss, as in the thesis."""
    CLASS_ONLY = "class_only"
    """`CLASS_TERMS` alone: nothing of boxes, keypoints and depth."""

    @classmethod
    def named(cls, value: object) -> LossTerms:
        """One of them by its word.

        Raises:
            ConfigurationError: There is none of that name.

        Example:
            >>> LossTerms.named("class_only").name
            'CLASS_ONLY'
        """
        return cls(one_of("terms", value, [str(each) for each in cls]))

    def chosen(self, terms: Mapping[str, Tensor], detector: str) -> list[Tensor]:
        """The terms that L is the sum of.

        Args:
            terms: All terms of a detector's training loss by name, scalars.
            detector: The detector's name.

        Raises:
            ConfigurationError: The detector has no term of a class.
        """
        if self is LossTerms.ALL:
            return list(terms.values())
        found = [term for name, term in terms.items() if name in CLASS_TERMS]
        if not found:
            raise ConfigurationError(
                f"the loss of {detector!r} has the terms {', '.join(terms)} and none of"
                f" {', '.join(sorted(CLASS_TERMS))}: give terms='all'"
            )
        return found
