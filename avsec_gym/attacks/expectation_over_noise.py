"""Perturbations that outlast noise: each step follows the mean gradient of noisy copies of a pair.

Expectation over transformation (Athalye et al., "Synthesizing robust adversarial examples", ICML
2018), the transformation being a sensor's noise::

    g_n = 1/k sum_j grad L(O(I_n + eta_j), b^true),   eta_j ~ N(0, sigma^2)

A gradient at the pixels alone may follow a dent of the loss that the next exposure does not have,
or one that a defence by noise has made; the mean over copies keeps what they have in common
(Athalye, Carlini and Wagner, "Obfuscated gradients give a false sense of security", ICML 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from avsec_gym.argument_checks import keep_checked, number, whole_number
from avsec_gym.attacks.argument_domains import COPIES, NOISES
from avsec_gym.attacks.perturbation import Perturbation, name_with_terms
from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.stereo_batch import StereoBatch

_NAME = "expectation_over_noise"


@dataclass(frozen=True)
class ExpectationOverNoise(Perturbation):
    """A `Perturbation`, each step of which takes as many gradients as there are copies.

    The seed decides the noise; the steps before a step, and the copies before a copy, have the same
    noise however many follow.

    Args:
        alpha: Length of a step; see `Perturbation` for the arguments up to `terms`.
        name: Name of the attack in results; the usual one gets the terms, if they are not all.
        copies: Number of noisy copies of the pair, k.
        noise: Standard deviation of the noise of every channel of every pixel of both views, grey
            levels; what leaves the range of pixels is cut off, as by a sensor.  0: every copy is
            the pair itself.

    Raises:
        ConfigurationError: A number is out of range.
    """

    name: str = _NAME
    copies: int = 8
    noise: float = 4.0

    def __post_init__(self) -> None:
        super().__post_init__()
        named = name_with_terms(_NAME, self.terms)
        checked = {
            "name": named if self.name == _NAME else self.name,
            "copies": whole_number("copies", self.copies, 1, COPIES),
            "noise": number("noise", self.noise, *NOISES),
        }
        keep_checked(self, checked)

    def gradient(
        self,
        batch: StereoBatch,
        detector: Detector,
        truths: Sequence[Boxes3D],
        disparity: Tensor | None,
        seed: Sequence[int],
    ) -> Tensor:
        """The mean of the gradients at the copies; see `Perturbation.gradient`."""
        draw = np.random.default_rng(seed)
        plain = super().gradient
        total = torch.zeros(2, *batch.left.shape).to(batch.left)
        # One copy at a time: memory stays that of a single gradient.
        for _ in range(self.copies):
            left, right = (_noisy(view, self.noise, draw) for view in (batch.left, batch.right))
            copy = replace(batch, left=left, right=right)
            total += plain(copy, detector, truths, disparity, seed)
        return total / self.copies


def _noisy(images: Tensor, noise: float, draw: np.random.Generator) -> Tensor:
    eta = torch.from_numpy(draw.standard_normal(tuple(images.shape), np.float32))
    return (images.detach() + noise * eta.to(images)).clamp(0, 255)
