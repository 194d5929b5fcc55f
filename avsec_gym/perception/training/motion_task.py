"""The task of the moving-object classifier, judged on scenes that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.motion.classifier import (
    MovingObjectClassifier,
    ObjectCrops,
    crop_batch,
)
from avsec_gym.perception.motion.network import CropBatch
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.crop_variation import relit_alike, shifted
from avsec_gym.perception.training.motion_samples import (
    GAPS,
    MotionSamples,
    prepare_motion_samples,
)
from avsec_gym.perception.training.scene_frames import split_by_scene
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_assets import training_suite

_ALONE, _LATEST = 0.2, 0.25
"""Shares of samples that are learned without a neighbour, and with the latest one."""
_VALIDATION_BATCH = 64


@dataclass(frozen=True, eq=False)
class MotionBatch:
    """Crops with the truth.

    Args:
        crops: The crops of N objects.
        moving: 1 or 0, shape (N,).
        weight: The weight of each object in the loss, shape (N,).
    """

    crops: CropBatch
    moving: Tensor
    weight: Tensor

    def to(self, device: torch.device | str) -> MotionBatch:
        """The batch on another device."""
        return MotionBatch(self.crops.to(device), self.moving.to(device), self.weight.to(device))


class MotionTask:
    """A `Task`.

    Args:
        classifier: The classifier, whose network is trained in place.
        training: Objects to learn from.
        validation: Objects of other scenes.
        augmentation: The augmentation of training samples; zoom is not used.
        data: JSON-able: what the samples are.
    """

    name = "motion"
    leading_metric = "balanced_accuracy"

    def __init__(
        self,
        classifier: MovingObjectClassifier,
        training: MotionSamples,
        validation: MotionSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self.network: nn.Module = classifier.network.requires_grad_(True)
        self.trained = self.network
        self._classifier, self._augmentation, self._data = classifier, augmentation, data
        self._training, self._validation = training, validation
        shares = np.array([(~training.moving).mean(), training.moving.mean()])
        self._weights = 0.5 / np.maximum(shares, 1e-3)

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> MotionBatch:
        """See `Task`."""
        parts = [self._varied(index, randomness) for index in indices]
        moving = self._training.moving[list(indices)]
        known = np.array([before is not None for _, before in parts])
        now = _tensor([now for now, _ in parts])
        before = _tensor(
            [np.stack([now, now]) if before is None else before for now, before in parts]
        )
        return MotionBatch(
            CropBatch(now, before, torch.from_numpy(known)),
            torch.from_numpy(moving).float(),
            torch.from_numpy(self._weights[moving.astype(int)]).float(),
        )

    def losses(self, batch: MotionBatch) -> dict[str, Tensor]:
        """See `Task`: cross-entropy, in which both answers weigh the same."""
        logits = self.network(batch.crops)
        return {
            "entropy": functional.binary_cross_entropy_with_logits(
                logits, batch.moving, batch.weight
            )
        }

    def validate(self) -> dict[str, float]:
        """See `Task`: with the neighbour, where there is one, and without."""
        samples = self._validation
        metrics: dict[str, float] = {}
        for name, gap in (("", 0), ("single_", None)):
            said = self.probabilities(samples, gap) >= self._classifier.threshold
            judged = np.ones(len(samples), bool) if gap is None else samples.known[:, gap]
            right, truths = (said == samples.moving)[judged], samples.moving[judged]
            by_truth = [right[truths == truth] for truth in (False, True)]
            metrics |= {
                f"{name}accuracy": float(right.mean()),
                f"{name}balanced_accuracy": float(
                    np.mean([part.mean() for part in by_truth if len(part)])
                ),
            }
        return metrics

    def probabilities(self, samples: MotionSamples, gap: int | None) -> NDArray[np.float64]:
        """The classifier's results for samples' true boxes, shape (N,).

        Args:
            samples: N objects.
            gap: Number of the neighbour; None for single crops.
        """
        found = np.zeros(len(samples))
        middle = samples.margin
        use = np.zeros(len(samples), bool) if gap is None else samples.known[:, gap]
        device = next(self.network.parameters()).device
        for value in (False, True):
            same = np.flatnonzero(use == value)
            for start in range(0, len(same), _VALIDATION_BATCH):
                index = same[start : start + _VALIDATION_BATCH]
                images = [samples.now[index, 0]]
                if value:
                    images.append(samples.before[index, 0, gap])
                cut = [
                    np.asarray(image, np.uint8) for image in shifted(images, middle, middle, middle)
                ]
                batch = crop_batch(ObjectCrops(cut[0], cut[1] if value else None)).to(device)
                with torch.no_grad():
                    found[index] = torch.sigmoid(self.network(batch)).double().cpu().numpy()
        return found

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._classifier.configuration),
            "augmentation": asdict(self._augmentation),
            "data": self._data,
        }

    def _varied(
        self, index: int, randomness: np.random.Generator
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """An object's two crops, the second None where it is to be judged by the first alone."""
        samples, limits = self._training, self._augmentation
        variant = int(randomness.integers(samples.now.shape[1]))
        draw, flip = randomness.uniform(size=2)
        gap = GAPS - 1 if draw > 1 - _LATEST else 0
        images = [samples.now[index, variant]]
        if draw > _ALONE and samples.known[index, gap] and samples.before.shape[2]:
            images.append(samples.before[index, variant, gap])
        down, right = randomness.integers(2 * samples.margin + 1, size=2)
        cut = shifted(images, samples.margin, int(down), int(right))
        if flip < limits.flip:
            cut = [image[..., ::-1, :] for image in cut]
        relit = relit_alike(cut, limits.photometric, randomness)
        return relit[0], relit[1] if len(relit) > 1 else None


def motion_task(options: TaskOptions) -> MotionTask:
    """The moving-object classifier; see `make_task`."""
    torch.manual_seed(options.seed)
    classifier = MovingObjectClassifier(options.preset, weights=None)
    options.begin(classifier.network)
    split = split_by_scene(options.data or (training_suite("raw"),), options.validation)
    training, validation = (
        prepare_motion_samples(
            frames, classifier.configuration, options.cache, on_progress=options.on_progress
        )
        for frames in (split.training, split.validation)
    )
    data = split.description() | {
        "objects": {"training": len(training), "validation": len(validation)},
        "moving": {
            "training": int(training.moving.sum()),
            "validation": int(validation.moving.sum()),
        },
    }
    return MotionTask(classifier, training, validation, options.augmentation, data)


def _tensor(images: Sequence[NDArray[np.float32]]) -> Tensor:
    return torch.from_numpy(np.stack(images)).movedim(-1, -3).contiguous()
