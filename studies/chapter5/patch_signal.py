"""What a patch has to learn from: the gradients of different places, pictures of cars, one place.

Run ``python -m studies.chapter5.patch_signal --world DIR --json FILE``.  A universal patch descends
along what the gradients of all places have in common, so their common share bounds how many places
a training takes.  Beside it: whether a detector takes a plain picture of a car for a car, and how
far a patch comes that is trained for one place alone.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor

from avsec_gym.attacks.attack import LEFT, with_pair
from avsec_gym.attacks.loss_gradient import differentiable, total_loss
from avsec_gym.attacks.patch_files import Patch
from avsec_gym.attacks.patch_ghosts import target_boxes
from avsec_gym.attacks.patch_pasting import paste
from avsec_gym.attacks.patch_placement import PatchPlace, random_place
from avsec_gym.attacks.patch_scenes import KittiScenes, PatchScenes
from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.weights.weights_hash import weights_hash
from studies.answer import answer

DETECTORS = ("dsgn", "stereo_rcnn")
NEAR = 2.0
"""Metres from above: a box at most so far from a ghost's middle answers to it."""
_TALLEST = 55.0
"""Pixels: cars that are seen at least so high are cut out as pictures."""
_ALONG = 0.2
"""Largest sine of the angle between such a car and the road."""


@dataclass(frozen=True)
class PatchEffect:
    """What a patch does at some places.

    Args:
        loss: Mean of the detector's loss to the ghosts alone.
        score: Mean of the highest score of a box that answers to the ghost, 0 without one.
        seen: Share of the places with such a box of a score of at least a half.
    """

    loss: float
    score: float
    seen: float


@dataclass(frozen=True)
class PatchSignal:
    """A detector's result.

    Args:
        weights: Hash of its weights; None if they are not known.
        common: Share of the mean squared gradient, each scaled to one mean size, that all places
            have in common, estimated without bias: it may come out below 0.
        places_to_learn: Number of places over which the common part outweighs the rest, the
            inverse of `common`; None where nothing is common.
        grey: Effect of a plain grey patch at the judged places.
        pictures: The effect of pictures of cars, each at all of the judged places.
        own_before: The effect of plain grey at the places that get a patch of their own.
        own_after: The effect of the patches that were trained there.
    """

    weights: str | None
    common: float
    places_to_learn: float | None
    grey: PatchEffect
    pictures: PatchEffect
    own_before: PatchEffect
    own_after: PatchEffect


@dataclass(frozen=True)
class PatchSignals:
    """The study: sizes, and a result for each detector."""

    frames: int
    gradients: int
    judged: int
    pictures: int
    own: int
    steps: int
    detectors: Mapping[str, PatchSignal]


@dataclass(frozen=True, eq=False)
class PatchedGhost:
    """A frame, a place for a patch, and the ghost that it is to show."""

    frame: SensorFrame
    place: PatchPlace
    ghost: Boxes3D

    def loss(self, detector: DifferentiableDetector, pixels: Tensor) -> Tensor:
        """The loss to the ghost alone."""
        batch = paste(batch_of_frames([self.frame]), pixels, [self.place])
        return total_loss(detector, batch, [self.ghost])

    def effect(self, detector: DifferentiableDetector, pixels: Tensor) -> PatchEffect:
        """The effect of a patch with these pixels."""
        with torch.no_grad():
            batch = paste(batch_of_frames([self.frame]), pixels, [self.place])
            loss = float(total_loss(detector, batch, [self.ghost]))
        found = detector.detect(with_pair(self.frame, batch.left[0], batch.right[0]))
        apart = np.linalg.norm((found.location - self.ghost.location)[:, ::2], axis=1)
        score = float(found.score[apart <= NEAR].max(initial=0.0))
        return PatchEffect(loss, score, float(score >= 0.5))


def run(options: argparse.Namespace) -> PatchSignals:
    """Measure both detectors.

    Raises:
        DataError: The frames show no car that could be cut out.
    """
    scenes = KittiScenes.of_split(KittiObject(options.world))
    pictures = [each for _, each in zip(range(options.pictures), _pictures(scenes), strict=False)]
    if not pictures:
        raise DataError(
            "No car is seen whole and large enough to be cut out as a picture.",
            path=options.world,
            remedy="`avsec world make` makes such frames; take more of them.",
        )
    found = {}
    with progress("patch signals") as shown:
        each = options.gradients + options.judged * (1 + len(pictures)) + options.own
        total, done = each * len(DETECTORS), 0

        def one_done() -> None:
            nonlocal done
            done += 1
            shown(done, total)

        for name in DETECTORS:
            detector = differentiable(make_detector(name))
            found[name] = _signal(detector, scenes, pictures, options, one_done)
    return PatchSignals(
        len(scenes), options.gradients, options.judged, len(pictures), options.own, options.steps,
        found,
    )  # fmt: skip


def _signal(
    detector: DifferentiableDetector,
    scenes: PatchScenes,
    pictures: Sequence[Tensor],
    options: argparse.Namespace,
    one_done: Callable[[], None],
) -> PatchSignal:
    grey = Patch.grey().pixels
    # What the gradients have in common.
    gradients = []
    for number in range(options.gradients):
        pixels = grey.clone().requires_grad_()
        loss = _placed(scenes, [options.seed, 0, number]).loss(detector, pixels)
        gradients.append(torch.autograd.grad(loss, pixels)[0])
        one_done()
    common = common_share(torch.stack(gradients))
    # What detectors make of plain pictures of cars.
    judged = [_placed(scenes, [options.seed, 1, number]) for number in range(options.judged)]
    effects = []
    for pixels in (grey, *pictures):
        for ghost in judged:
            effects.append(ghost.effect(detector, pixels))
            one_done()
    # A patch for one place alone.
    own = [_placed(scenes, [options.seed, 2, number]) for number in range(options.own)]
    after = []
    for ghost in own:
        after.append(ghost.effect(detector, _trained(detector, ghost, options.steps)))
        one_done()
    return PatchSignal(
        weights_hash(detector),
        common,
        1 / common if common > 0 else None,
        _mean(effects[: len(judged)]),
        _mean(effects[len(judged) :]),
        _mean([ghost.effect(detector, grey) for ghost in own]),
        _mean(after),
    )


def common_share(gradients: Tensor) -> float:
    """The share of the mean squared gradient that the true mean gradient has, without bias.

    Of n independent gradients, each scaled to a mean size of 1: the squared mean of all is larger
    than that of the true mean by 1/n of what they do not have in common.

    Args:
        gradients: The gradients at different places, shape (n, ...), n of 2 or more.

    Example:
        >>> common_share(torch.ones(5, 3))
        1.0
    """
    flat = gradients.flatten(1).double()
    flat = flat / flat.abs().mean(dim=1, keepdim=True).clamp_min(1e-30)
    n, share = len(flat), float((flat.mean(0) ** 2).sum() / (flat**2).sum(1).mean())
    return (n * share - 1) / (n - 1)


def _trained(detector: DifferentiableDetector, one: PatchedGhost, steps: int) -> Tensor:
    """The grey levels of a patch that is trained where it stands, by Adam as all patches are."""
    pixels = Patch.grey().pixels.requires_grad_()
    optimizer = torch.optim.Adam([pixels], lr=8.0)
    for _ in range(steps):
        pixels.grad = torch.autograd.grad(one.loss(detector, pixels), pixels)[0]
        optimizer.step()
        pixels.data.clamp_(0, 255)
    return pixels.detach()


def _placed(scenes: PatchScenes, seed: Sequence[int]) -> PatchedGhost:
    """A ghost somewhere, in some frame, where no real object could be taken for it."""
    random = np.random.default_rng(seed)
    while True:
        frame, truth = scenes[int(random.integers(len(scenes)))]
        size = frame.image(LEFT).shape[:2]
        drawn = [*seed, int(random.integers(2**31))]
        place = random_place(frame.calibration, size, drawn, objects=truth)
        ghost = target_boxes(place, frame.calibration)
        apart = np.linalg.norm((truth.location - ghost.location)[:, ::2], axis=1)
        if (apart > 2 * NEAR).all():
            return PatchedGhost(frame, place, ghost)


def _pictures(scenes: PatchScenes) -> Iterator[Tensor]:
    """Cars that drive along the road and are seen whole, cut out to the size of a patch."""
    side = Patch.grey().pixels.shape[-1]
    for number in range(len(scenes)):
        frame, truth = scenes[number]
        assert truth.box2d is not None
        assert truth.truncation is not None
        assert truth.occlusion is not None
        height = truth.box2d[:, 3] - truth.box2d[:, 1]
        along = np.abs(np.cos(truth.rotation_y)) < _ALONG
        whole = (truth.truncation == 0) & (truth.occlusion == 0) & (truth.category == "Car")
        for left, top, right, bottom in truth.box2d[whole & along & (height >= _TALLEST)].tolist():
            reach = max(right - left, bottom - top) / 2
            columns = np.linspace(-reach, reach, side) + (left + right) / 2
            rows = np.linspace(-reach, reach, side) + (top + bottom) / 2
            x, y = np.meshgrid(columns.astype(np.float32), rows.astype(np.float32))
            cut = cv2.remap(
                frame.image(LEFT), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
            yield torch.from_numpy(cut).permute(2, 0, 1).float()


def _mean(effects: Sequence[PatchEffect]) -> PatchEffect:
    return PatchEffect(
        *(
            float(np.mean([getattr(effect, name) for effect in effects]))
            for name in ("loss", "score", "seen")
        )
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--world", type=Path, required=True, help="frames in KITTI's layout")
    parser.add_argument("--gradients", type=int, default=48, help="places whose gradients count")
    parser.add_argument("--judged", type=int, default=24, help="places for grey and pictures")
    parser.add_argument("--pictures", type=int, default=6, help="of cars, at most")
    parser.add_argument("--own", type=int, default=8, help="places that get patches of their own")
    parser.add_argument("--steps", type=int, default=30, help="of such a patch's training")
    parser.add_argument("--seed", type=int, default=0, help="of frames and places")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
