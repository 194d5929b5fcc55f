"""A detector's training loss and its gradient at the pixels: what attacks by gradient climb."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import Tensor

from avsec_gym.attacks.loss_terms import LossTerms
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.detector import Detector, DifferentiableDetector
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.suggestions import unknown_name


def total_loss(
    detector: Detector,
    batch: StereoBatch,
    truths: Sequence[Boxes3D],
    disparity: Tensor | None = None,
    which: LossTerms = LossTerms.ALL,
) -> Tensor:
    """L, the sum of terms of the training loss; see `DifferentiableDetector.losses`.

    Args:
        detector: The detector O.
        batch: Images of B pairs.
        truths: Real objects b^true of each pair.
        disparity: Disparities of the left images, pixels, 0 where unknown, shape (B, H, W).
        which: The terms that are added up.

    Raises:
        ConfigurationError: The detector has no loss, or none of these terms.
    """
    terms = differentiable(detector).losses(batch, truths, disparity)
    return torch.stack(which.chosen(terms, detector.name)).sum()


def loss_gradient(
    detector: Detector,
    batch: StereoBatch,
    truths: Sequence[Boxes3D],
    disparity: Tensor | None = None,
    which: LossTerms = LossTerms.ALL,
) -> Tensor:
    """The gradient of L at the pixels of the left and the right images, shape (2, B, 3, H, W).

    The network stays as it is: its mode, and the gradients of its weights.  Arguments: see
    `total_loss`.

    Raises:
        ConfigurationError: The detector has no loss, none of these terms, or one that is no
            function of the pixels.
    """
    left, right = (view.detach().clone().requires_grad_() for view in (batch.left, batch.right))
    with torch.enable_grad():
        views = replace(batch, left=left, right=right)
        loss = total_loss(detector, views, truths, disparity, which)
    if not loss.requires_grad:
        raise ConfigurationError(
            f"the losses of {detector.name!r} are no function of the pixels: is its gradient off?"
        )
    # A detector that does not look at one of the views has no gradient there.
    return torch.stack(torch.autograd.grad(loss, (left, right), materialize_grads=True))


def term_gradients(
    detector: Detector, batch: StereoBatch, truths: Sequence[Boxes3D], names: Sequence[str]
) -> Tensor:
    """The gradient of each of some terms of L at the pixels, shape (K, 2, B, 3, H, W).

    Args:
        detector: The detector O.
        batch: Images of B pairs.
        truths: Real objects b^true of each pair.
        names: Names of K terms of the training loss.

    Raises:
        ConfigurationError: The detector has no loss, or lacks one of these terms.
    """
    left, right = (view.detach().clone().requires_grad_() for view in (batch.left, batch.right))
    with torch.enable_grad():
        terms = differentiable(detector).losses(replace(batch, left=left, right=right), truths)
    for name in names:
        if name not in terms:
            problem = f"the loss of {detector.name!r} has no term {name!r}"
            raise ConfigurationError(unknown_name(problem, name, terms))
    # A term that nothing in the images changes, such as one without objects, has no gradient.
    found = [
        torch.autograd.grad(
            terms[name], (left, right), retain_graph=True, allow_unused=True, materialize_grads=True
        )
        if terms[name].requires_grad
        else (torch.zeros_like(left), torch.zeros_like(right))
        for name in names
    ]
    return torch.stack([torch.stack(views) for views in found])


def differentiable(detector: Detector) -> DifferentiableDetector:
    """The same detector, if it has a loss to climb.

    Raises:
        ConfigurationError: It has none.
    """
    if not isinstance(detector, DifferentiableDetector):
        raise ConfigurationError(
            f"the detector {detector.name!r} has no `losses` whose gradient reaches the pixels: "
            "attack one that has, such as 'dsgn' or 'stereo_rcnn'"
        )
    return detector
