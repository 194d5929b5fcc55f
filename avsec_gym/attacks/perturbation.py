"""Perturbation attacks: small changes of every pixel that raise the detector's loss.

The thesis' form (section 5.2, equations 5.2 and 5.3) adds the clipped sign of the gradient::

    delta_n = Clip_eps{alpha * sign(grad L(O(I_l,n, I_r,n), b^true))},   I_n+1 = I_n + delta_n

Clip bounds one step, not the sum: with eps >= alpha it does nothing, and N steps change a pixel by
at most N * alpha.  The text adds one delta to both images; here each has its own unless `shared`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NoReturn

import numpy as np
import torch
from torch import Tensor

from avsec_gym.argument_checks import flag, keep_checked, label, number, whole_number
from avsec_gym.attacks.argument_domains import LEVELS, MOMENTA, STEPS
from avsec_gym.attacks.attack import Budget, Seed, Victim, with_pair
from avsec_gym.attacks.loss_gradient import loss_gradient
from avsec_gym.attacks.loss_terms import LossTerms
from avsec_gym.attacks.seed_numbers import seed_numbers
from avsec_gym.boxes import Boxes3D
from avsec_gym.built_in_parts import NO_ATTACKS
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames


@dataclass(frozen=True)
class Perturbation:
    """Steps along the sign of the loss' gradient, in grey levels of the camera's own pixels.

    Args:
        alpha: Length of a step.
        epsilon: Bound of a step, or of the whole change where `projected`; None: no bound.
        steps: Number of steps, N.
        momentum: Share of the past gradients' sum that is kept (mu of Dong et al., CVPR 2018);
            0: each step follows its own gradient.
        projected: Whether the change is put back into the L-infinity ball of epsilon at each step.
        random_start: Whether to begin anywhere in that ball instead of at its centre.
        shared: Whether both views get one and the same delta; its gradient is the sum of theirs.
        name: Name of the attack in results.
        terms: Which terms of the detector's training loss are climbed.

    Raises:
        ConfigurationError: A number is out of range, a projection has no epsilon, or there are no
            such terms.
    """

    alpha: float = 1.0
    epsilon: float | None = None
    steps: int = 4
    momentum: float = 0.0
    projected: bool = False
    random_start: bool = False
    shared: bool = False
    name: str = "thesis_pgd"
    terms: LossTerms = LossTerms.ALL
    needs_gradient: ClassVar[bool] = True

    def __post_init__(self) -> None:
        epsilon = self.epsilon
        checked: dict[str, object] = {
            "alpha": number("alpha", self.alpha, *LEVELS),
            "epsilon": None if epsilon is None else number("epsilon", epsilon, *LEVELS),
            "steps": whole_number("steps", self.steps, 1, STEPS),
            "momentum": number("momentum", self.momentum, *MOMENTA),
            "name": label("name", self.name),
            "terms": LossTerms.named(self.terms),
        }
        for name in ("projected", "random_start", "shared"):
            checked[name] = flag(name, getattr(self, name))
        keep_checked(self, checked)
        if (self.projected and self.epsilon is None) or (self.random_start and not self.projected):
            raise ConfigurationError(
                "projected=True needs the epsilon of its ball, and random_start=True a projection:"
                " for instance, give projected=True, epsilon=4"
            )

    @property
    def budget(self) -> Budget:
        """N * alpha, or epsilon; after n steps only, that of ``replace(attack, steps=n)``."""
        sum_of_steps = self.steps * min(self.alpha, self._bound)
        if not self.projected:
            return Budget(sum_of_steps)
        return Budget(self._bound if self.random_start else min(sum_of_steps, self._bound))

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The frame after the last step; see `Attack.attack`."""
        for attacked in self.iterates(frame, victim, seed):
            last = attacked
        return last

    def iterates(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> Iterator[SensorFrame]:
        """The frame after 1, 2, ... N steps, for one gradient each.

        Raises:
            ConfigurationError: The victim's detector has no loss to climb, or the disparity is not
                of this frame.
            DataError: An image is missing or broken.
        """
        batch = batch_of_frames([frame])
        disparity = None
        if victim.disparity is not None:
            if victim.disparity.shape != batch.size:
                raise ConfigurationError(
                    f"frame {frame.id} has {batch.size} pixels, the victim's disparity "
                    f"{victim.disparity.shape}"
                )
            disparity = torch.from_numpy(victim.disparity)[None]
        for attacked in self.perturbed(batch, victim.detector, [victim.truth], disparity, seed):
            yield with_pair(frame, attacked.left[0], attacked.right[0])

    def perturbed(
        self,
        batch: StereoBatch,
        detector: Detector,
        truths: Sequence[Boxes3D],
        disparity: Tensor | None = None,
        seed: Seed = 0,
    ) -> Iterator[StereoBatch]:
        """A batch after 1, 2, ... N steps.

        Pairs of one batch share the normalisers of the loss' terms: their pixels differ a little
        from those of the pairs alone.

        Args:
            batch: Images of B pairs at the camera's own resolution.
            detector: The detector O.
            truths: Real objects b^true of each pair.
            disparity: Disparities of the left images, pixels, 0 where unknown, shape (B, H, W).
            seed: Seed of the random start, and of what `gradient` draws.

        Raises:
            ConfigurationError: The detector has no loss to climb.
        """
        clean = torch.stack([batch.left, batch.right]).detach()
        images = self._started(clean, seed)
        velocity = torch.zeros_like(clean[:1])
        seeds = seed_numbers(seed)
        for step in range(self.steps):
            views = replace(batch, left=images[0], right=images[1])
            gradient = self.gradient(views, detector, truths, disparity, [*seeds, step + 1])
            if self.shared:
                gradient = gradient.sum(dim=0, keepdim=True)
            if self.momentum:
                velocity = gradient = self.momentum * velocity + _normalised(gradient)
            delta = (self.alpha * gradient.sign()).clamp(-self._bound, self._bound)
            images = self._allowed(images + delta, clean)
            yield replace(batch, left=images[0], right=images[1])

    def gradient(
        self,
        batch: StereoBatch,
        detector: Detector,
        truths: Sequence[Boxes3D],
        disparity: Tensor | None,
        seed: Sequence[int],
    ) -> Tensor:
        """The gradient that one step follows, shape (2, B, 3, H, W): that of L at the pixels.

        Args:
            batch: Images as the steps before left them; see `perturbed` for the other ones.
            detector: The detector O.
            truths: Real objects b^true of each pair.
            disparity: Disparities of the left images.
            seed: Seed of the step, for attacks that draw.
        """
        return loss_gradient(detector, batch, truths, disparity, self.terms)

    @property
    def _bound(self) -> float:
        return math.inf if self.epsilon is None else self.epsilon

    def _started(self, clean: Tensor, seed: Seed) -> Tensor:
        if not self.random_start:
            return clean
        shape = (1 if self.shared else 2, *clean.shape[1:])
        noise = np.random.default_rng(seed).uniform(-self._bound, self._bound, shape)
        return self._allowed(clean + torch.from_numpy(noise).to(clean), clean)

    def _allowed(self, images: Tensor, clean: Tensor) -> Tensor:
        if self.projected:
            images = clean + (images - clean).clamp(-self._bound, self._bound)
        return images.clamp(0, 255)


def thesis_pgd(
    alpha: float = 1.0,
    steps: int = 4,
    epsilon: float | None = None,
    shared: bool = False,
    terms: LossTerms = LossTerms.ALL,
) -> Perturbation:
    """The thesis' form of PGD, equations 5.2 and 5.3: the sum of the steps is not projected.

    In the thesis, alpha is 0.4 or 1 and n is 1 to 4.
    """
    name = name_with_terms("thesis_pgd", terms)
    return Perturbation(alpha, epsilon, steps, shared=shared, name=name, terms=terms)


def fgsm(
    epsilon: float = 4.0, shared: bool = False, terms: LossTerms = LossTerms.ALL
) -> Perturbation:
    """The fast gradient sign method: one step of epsilon (Goodfellow et al., ICLR 2015)."""
    epsilon = number("epsilon", epsilon, *LEVELS)
    name = name_with_terms("fgsm", terms)
    return Perturbation(epsilon, epsilon, 1, shared=shared, name=name, terms=terms)


def i_fgsm(
    epsilon: float = 4.0,
    alpha: float = 1.0,
    steps: int | None = None,
    shared: bool = False,
    terms: LossTerms = LossTerms.ALL,
) -> Perturbation:
    """The basic iterative method (Kurakin et al., ICLR 2017 workshop), clipped about the image.

    Without `steps`, as many as the paper takes of alpha 1: min(epsilon + 4, 1.25 epsilon).
    """
    epsilon = number("epsilon", epsilon, *LEVELS)
    if steps is None:
        steps = max(1, int(min(epsilon + 4, 1.25 * epsilon)))
    name = name_with_terms("i_fgsm", terms)
    return Perturbation(
        alpha, epsilon, steps, projected=True, shared=shared, name=name, terms=terms
    )


def mi_fgsm(
    epsilon: float = 4.0,
    steps: int = 4,
    momentum: float = 1.0,
    shared: bool = False,
    terms: LossTerms = LossTerms.ALL,
) -> Perturbation:
    """Momentum over gradients of L1 norm 1, alpha = epsilon / N (Dong et al., CVPR 2018)."""
    epsilon, steps = number("epsilon", epsilon, *LEVELS), whole_number("steps", steps, 1, STEPS)
    alpha = max(epsilon / steps, LEVELS[0])
    name = name_with_terms("mi_fgsm", terms)
    return Perturbation(
        alpha, epsilon, steps, momentum, projected=True, shared=shared, name=name, terms=terms
    )


def projected_pgd(
    epsilon: float = 4.0,
    alpha: float | None = None,
    steps: int = 7,
    random_start: bool = True,
    shared: bool = False,
    terms: LossTerms = LossTerms.ALL,
) -> Perturbation:
    """Projected gradient descent as the field knows it (Madry et al., ICLR 2018).

    After each step, the change is projected onto the L-infinity ball of epsilon and the image onto
    the range of pixels.  Without `alpha`, epsilon / 4: with 7 steps, the paper's proportions on
    CIFAR-10 (8, 2, 7).
    """
    epsilon = number("epsilon", epsilon, *LEVELS)
    alpha = max(epsilon / 4, LEVELS[0]) if alpha is None else alpha
    name = name_with_terms("projected_pgd", terms)
    return Perturbation(
        alpha, epsilon, steps, 0.0, True, random_start, shared, name=name, terms=terms
    )


def pgd(*_: object, **__: object) -> NoReturn:
    """Keeps its name free for one version: it was `thesis_pgd`, and will be `projected_pgd`.

    Raises:
        ConfigurationError: Always; it names both.
    """
    raise ConfigurationError(NO_ATTACKS["pgd"])


def name_with_terms(attack: str, terms: LossTerms) -> str:
    """The name in results: those of other terms than the thesis' are filed apart.

    Args:
        attack: The name of the attack that climbs all terms.
        terms: The terms that are climbed.

    Raises:
        ConfigurationError: There are no such terms.
    """
    which = LossTerms.named(terms)
    return attack if which is LossTerms.ALL else f"{attack} {which}"


def _normalised(gradient: Tensor) -> Tensor:
    """Divided by its L1 norm, for each pair: over both views, as they are one input."""
    norm = gradient.abs().sum(dim=(0, 2, 3, 4), keepdim=True)
    return gradient / norm.clamp(min=torch.finfo(norm.dtype).tiny)
