"""Trains a patch: the expected loss to ghost boxes b* is made small (thesis, equation 5.4).

    argmin over the patch of  E over images, places, disparities, rotations  L(O(I_l, I_r), b*)

One detector makes a white-box patch, several together the black-box patch of section 5.5.2; all
get the same optimiser, step size and epochs.  Losses of different detectors differ in scale, and
Stereo R-CNN's in its constants too (it may be negative), so that dividing by their values balances
nothing.  Instead each one's gradient is divided by its mean size in the steps so far.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict
from math import isfinite
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from avsec_gym import __version__
from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.loss_gradient import differentiable, total_loss
from avsec_gym.attacks.patch_configuration import PatchTraining
from avsec_gym.attacks.patch_files import Patch, PatchCard, save_patch
from avsec_gym.attacks.patch_ghosts import target_boxes
from avsec_gym.attacks.patch_pasting import paste
from avsec_gym.attacks.patch_placement import PatchPlace, random_place
from avsec_gym.attacks.patch_scenes import PatchScenes
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.training.checkpoint import (
    CHECKPOINT,
    Checkpoint,
    resume_optimizer,
    save_checkpoint,
    start_or_resume,
)
from avsec_gym.perception.training.curves import Curves, read_curves
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.progress import Progress
from avsec_gym.storage.folder_lock import locked_folder

PATCH = "patch.safetensors"
"""The patch in the folder of a training, its picture and card beside it."""

_CHECKPOINT_SECONDS = 60.0
_JUDGED = 40
"""Scenes at most that a finished patch is judged on."""
_LOG = logging.getLogger(__name__)


def train_patch(
    detectors: Sequence[DifferentiableDetector],
    scenes: PatchScenes,
    configuration: PatchTraining,
    folder: Path,
    *,
    resume: bool = False,
    on_progress: Progress | None = None,
    on_epoch: Callable[[int, dict[str, float]], None] | None = None,
) -> Patch:
    """Train a patch against one detector, or against several at once.

    On a CPU, a training that was stopped and resumed ends with the patch of one that was not, bit
    for bit.

    Args:
        detectors: Detectors with frozen weights.
        scenes: Frames and what is really there.
        configuration: Settings that the result depends on.
        folder: Folder for checkpoint, curves (curves.jsonl, curves.png), and the patch after each
            epoch.
        resume: Whether the training in the folder goes on, if there is one.
        on_progress: Function that gets the steps done and the steps in all, of this call; the last
            ones judge.
        on_epoch: Function that gets the epochs done and each detector's mean loss to b* in the last
            one.

    Returns:
        The patch as saved in the folder, with its card.

    Raises:
        ConfigurationError: No detector, two of one name, or one that has no loss.
        DataError: The folder holds a training and `resume` is false, or holds that of another
            patch, or another process is writing there; or a frame is broken.
    """
    with locked_folder(folder):
        run = _Run(_by_name(detectors), scenes, configuration, folder, resume)
        first, judged = run.state.step, min(len(scenes), _JUDGED)
        total = run.steps - first + judged
        saved = time.monotonic()
        with closing(run.curves):
            # Steps; a checkpoint now and then, and the patch and its curves after each epoch.
            while run.state.step < run.steps:
                run.step()
                if on_progress is not None:
                    on_progress(run.state.step - first, total)
                epoch, rest = divmod(run.state.step, run.epoch_steps)
                if rest == 0 or time.monotonic() - saved > _CHECKPOINT_SECONDS:
                    run.save()
                    saved = time.monotonic()
                if rest == 0:
                    run.keep()
                    run.curves.draw()
                    if on_epoch is not None:
                        on_epoch(epoch, run.mean_losses(epoch))
        # Losses at new places in frames of the training, for the card.
        losses = run.judged(
            judged, lambda done: on_progress and on_progress(total - judged + done, total)
        )
        return run.keep(losses)


class _Run:
    """The parts of a training that change."""

    def __init__(
        self,
        detectors: dict[str, DifferentiableDetector],
        scenes: PatchScenes,
        configuration: PatchTraining,
        folder: Path,
        resume: bool,
    ) -> None:
        self.detectors, self.scenes = detectors, scenes
        self.configuration, self.folder = configuration, folder
        self.epoch_steps = -(-len(scenes) // configuration.batch)
        self.steps = self.epoch_steps * configuration.epochs
        self.pixels = Patch.grey(configuration.radius).pixels.requires_grad_()
        self.optimizer = torch.optim.Adam([self.pixels], lr=configuration.step_size)
        self.sizes = dict.fromkeys(detectors, 0.0)
        """Mean absolute gradient of each detector in the steps so far."""
        self.state = self._begin(resume)
        self.curves = Curves(folder, self.state.step)
        self._since = time.monotonic()

    def _begin(self, resume: bool) -> Checkpoint:
        identity = {
            "detectors": {name: weights_hash(one) for name, one in self.detectors.items()},
            "data": self.scenes.description(),
            "training": asdict(self.configuration),
        }
        state = start_or_resume(self.folder, identity, resume=resume)
        if state.trained:
            pixels, sizes = (state.trained.get(name) for name in ("pixels", "gradient_sizes"))
            if not (
                isinstance(pixels, torch.Tensor)
                and (pixels.shape, pixels.dtype) == (self.pixels.shape, self.pixels.dtype)
                and bool(pixels.isfinite().all())
                and isinstance(sizes, dict)
                and set(sizes) == set(self.sizes)
                and all(isinstance(size, float) and isfinite(size) for size in sizes.values())
            ):
                raise DataError(
                    "This is no checkpoint of such a patch.",
                    path=self.folder / CHECKPOINT,
                    remedy="Remove it to begin anew.",
                )
            self.pixels.data.copy_(pixels)
            self.sizes = sizes
            resume_optimizer(state, self.optimizer, self.folder)
        return state

    def step(self) -> None:
        """Learn from some frames; all randomness follows from the seed and the step's number."""
        settings, step = self.configuration, self.state.step
        epoch, position = divmod(step, self.epoch_steps)
        order = np.random.default_rng([settings.seed, epoch]).permutation(len(self.scenes))
        chosen = order[position * settings.batch : (position + 1) * settings.batch]
        losses = dict.fromkeys(self.detectors, 0.0)
        gradients = {name: torch.zeros_like(self.pixels) for name in self.detectors}
        for number, index in enumerate(chosen.tolist()):
            # One at a time: frames may differ in size, and memory stays that of one.
            drawn = self._drawn(index, [settings.seed, step, number])
            for name, detector in self.detectors.items():
                loss, gradient = self._loss(detector, *drawn)
                gradients[name] += gradient / len(chosen)
                losses[name] += loss / len(chosen)
        self._descend(gradients)
        self.state.step = step + 1
        self.curves.add(self.state.step, "losses", losses)

    def _drawn(self, index: int, seed: Sequence[int]) -> tuple[SensorFrame, PatchPlace, Boxes3D]:
        """A frame, where the patch stands in it, and b*."""
        frame, truth = self.scenes[index]
        place = random_place(
            frame.calibration,
            frame.image(LEFT).shape[:2],
            seed,
            radius=self.configuration.radius,
            range=self.configuration.range,
            objects=truth,
        )
        real = truth if self.configuration.keep_real else None
        width = self.configuration.ghost_width
        return frame, place, target_boxes(place, frame.calibration, real, width)

    def _loss(
        self,
        detector: DifferentiableDetector,
        frame: SensorFrame,
        place: PatchPlace,
        target: Boxes3D,
    ) -> tuple[float, Tensor]:
        """L(O(I_l, I_r), b*), DSGN's term for disparities aside, and its gradient."""
        batch = paste(batch_of_frames([frame]), self.pixels, [place])
        loss = total_loss(detector, batch, [target])
        return float(loss.detach()), torch.autograd.grad(loss, self.pixels)[0]

    def _descend(self, gradients: dict[str, Tensor]) -> None:
        step = self.state.step
        total = torch.zeros_like(self.pixels)
        for name, gradient in gradients.items():
            if not torch.isfinite(gradient).all():
                _LOG.warning("step %d: the gradient of %s is not finite, left out", step, name)
                continue
            size = float(gradient.abs().mean())
            self.sizes[name] += (size - self.sizes[name]) / (step + 1)
            if self.sizes[name] > 0:
                total += gradient / self.sizes[name]
        self.pixels.grad = total
        for group in self.optimizer.param_groups:
            group["lr"] = self.configuration.step_size_at(step / self.steps)
        self.optimizer.step()
        self.pixels.data.clamp_(0, 255)

    def mean_losses(self, epoch: int) -> dict[str, float]:
        """The mean loss of each detector in an epoch, counted from 1."""
        last = epoch * self.epoch_steps
        rows = [
            row["losses"]
            for row in read_curves(self.folder)
            if last - self.epoch_steps < row["step"] <= last
        ]
        return {name: float(np.mean([row[name] for row in rows])) for name in self.detectors}

    def save(self) -> None:
        """Write a checkpoint."""
        now = time.monotonic()
        self.state.seconds += now - self._since
        self._since = now
        self.state.trained = {"pixels": self.pixels.detach(), "gradient_sizes": self.sizes}
        self.state.optimizer = self.optimizer.state_dict()
        self.state.finished = self.state.step == self.steps
        save_checkpoint(self.folder, self.state)

    def judged(
        self, count: int, on_progress: Callable[[int], object]
    ) -> dict[str, dict[str, float]]:
        """Mean losses to b* of plain grey and of the patch, by detector.

        Both at the same places in the first scenes: the places are new, the frames are those that
        the training had.
        """
        radius = self.configuration.radius
        patches = {"grey": Patch.grey(radius).pixels, "patch": self.pixels.detach().round()}
        losses = {name: dict.fromkeys(self.detectors, 0.0) for name in patches}
        for index in range(count):
            # Not [seed, index]: to numpy that is [seed, index, 0], a step's own seed.
            frame, place, target = self._drawn(index, [self.configuration.seed, index, 0, 1])
            for name, pixels in patches.items():
                batch = paste(batch_of_frames([frame]), pixels, [place])
                for victim, detector in self.detectors.items():
                    with torch.no_grad():
                        losses[name][victim] += float(total_loss(detector, batch, [target])) / count
            on_progress(index + 1)
        return losses

    def keep(self, losses: dict[str, dict[str, float]] | None = None) -> Patch:
        """Write the patch as it is now, with what it was judged by."""
        epochs = self.state.step // self.epoch_steps
        card = PatchCard(
            detectors=self.state.identity["detectors"],
            data=self.state.identity["data"],
            training=self.state.identity["training"],
            losses=losses or {},
            epochs=epochs,
            steps=self.state.step,
            minutes=round(self.state.seconds / 60, 1),
            versions={"avsec_gym": __version__, "torch": torch.__version__},
        )
        # Printers, and the picture beside it, know whole grey levels.
        patch = Patch(self.pixels.detach().round(), self.configuration.radius, card)
        return save_patch(self.folder / PATCH, patch)


def _by_name(
    detectors: Sequence[DifferentiableDetector],
) -> dict[str, DifferentiableDetector]:
    named = {detector.name: detector for detector in detectors}
    if not named or len(named) < len(detectors):
        raise ConfigurationError(
            "a patch is trained against one detector or several of different names, got "
            f"{[detector.name for detector in detectors]}"
        )
    return {name: differentiable(detector) for name, detector in named.items()}
