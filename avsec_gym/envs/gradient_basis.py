"""Patterns of few numbers that another detector's gradients span: what fools one may fool another.

A black-box attacker that owns some detector, its surrogate, searches among sums of the surrogate's
gradients instead of among all images (Papernot et al., "Practical black-box attacks against
machine learning", AsiaCCS 2017; with a query budget: Cheng et al., "Improving black-box adversarial
attacks with a transfer-based prior", NeurIPS 2019).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import shown
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.registry import Kind, check, made_part

TERMS = {
    "dsgn": ("classification", "box", "centerness"),
    "stereo_rcnn": ("rpn_class", "rpn_box", "class", "box", "dimensions", "keypoints"),
}
"""Terms of the training losses of the package's detectors that need nothing but labels."""


class GradientBasis:
    """Gradients of the terms of a surrogate's training loss at a scene's clean pixels.

    Args:
        surrogate: The detector that the attacker owns: a name, a dictionary or a live one.  It is
            made when it is first asked.
        terms: The terms by name, one gradient each; None: those of `TERMS`.

    Raises:
        ConfigurationError: There is no such detector, or its terms are to be named.
    """

    def __init__(self, surrogate: Any, terms: Sequence[str] | None = None) -> None:
        check(Kind.DETECTOR, surrogate)
        self._named = surrogate
        name = surrogate.get("name") if isinstance(surrogate, Mapping) else surrogate
        known = TERMS.get(name) if isinstance(name, str) else None
        given = known if terms is None else terms
        if given is None:
            raise ConfigurationError(
                f"terms names those of the loss of {shown(surrogate)}: for instance, give"
                ' terms=["classification"]'
            )
        if isinstance(given, str) or not given or not all(isinstance(x, str) for x in given):
            raise ConfigurationError(
                "terms is a list of names of terms of the surrogate's loss, such as"
                f' ["classification"], got {shown(given)}'
            )
        self.terms = tuple(given)
        self._last: tuple[str, NDArray[np.float32]] | None = None

    @property
    def size(self) -> int:
        """Coefficients of a pattern."""
        return len(self.terms)

    @cached_property
    def surrogate(self) -> Detector:
        """The detector whose gradients they are."""
        with one_thread():
            detector: Detector = made_part("surrogate", Kind.DETECTOR, self._named)
        return detector

    def images(self, frame: SensorFrame, truth: Boxes3D) -> NDArray[np.float32]:
        """The gradients, each with a mean size of 1 over both views, or 0 everywhere.

        Those of the last frame are kept.

        Args:
            frame: The clean frame.
            truth: The real objects.

        Returns:
            Shape (2, terms, H, W, 3): of the left and of the right image.

        Raises:
            ConfigurationError: The surrogate has no loss to climb, or none of these terms.
        """
        if self._last is None or self._last[0] != frame.id:
            from avsec_gym.attacks.loss_gradient import term_gradients
            from avsec_gym.perception.stereo_batch import batch_of_frames

            with one_thread():
                found = term_gradients(
                    self.surrogate, batch_of_frames([frame]), [truth], self.terms
                )
            gradients = found[:, :, 0].permute(1, 0, 3, 4, 2).float().cpu().numpy()
            mean = np.abs(gradients).mean(axis=(0, 2, 3, 4), keepdims=True)
            scaled = np.divide(gradients, mean, out=np.zeros_like(gradients), where=mean > 0)
            self._last = frame.id, scaled
        return self._last[1]

    def pattern(self, coefficients: Floats, images: NDArray[np.float32]) -> NDArray[np.int8]:
        """The sign of the sum of the gradients.

        Args:
            coefficients: One for each term, shape (terms,).
            images: The gradients at one image, shape (terms, H, W, 3).

        Returns:
            -1 or 1, and 0 where the sum is 0, shape (H, W, 3).
        """
        # einsum adds up in one order whatever the number of threads.
        return np.sign(np.einsum("k,khwc->hwc", coefficients, images)).astype(np.int8)
