"""The task of the driving-constraint selector: road types of the procedural world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.road_type import ROAD_TYPES, DrivingConstraintSelector, reduced_image
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.crop_variation import relit_alike, shifted
from avsec_gym.perception.training.scene_frames import SceneFrame, split_by_scene
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_assets import training_suite
from avsec_gym.progress import Progress

_MARGIN = 8
_VALIDATION_BATCH = 32


@dataclass(frozen=True, eq=False)
class RoadTypeBatch:
    """Images with the truth.

    Args:
        images: Grey levels, shape (N, 3, H, W).
        road_type: Numbers of `ROAD_TYPES`, shape (N,).
        weight: The weight of each image in the loss, shape (N,).
    """

    images: Tensor
    road_type: Tensor
    weight: Tensor

    def to(self, device: torch.device | str) -> RoadTypeBatch:
        """The batch on another device."""
        return RoadTypeBatch(
            self.images.to(device), self.road_type.to(device), self.weight.to(device)
        )


@dataclass(frozen=True, eq=False)
class RoadTypeSamples:
    """Reduced left images, with a margin where they are learned from.

    Args:
        images: The images, shape (N, H, W, 3).
        road_type: Numbers of `ROAD_TYPES`, shape (N,).
    """

    images: NDArray[np.uint8]
    road_type: NDArray[np.int64]


class RoadTypeTask:
    """A `Task`.

    Args:
        selector: The selector, whose network is trained in place.
        training: The images to learn from, with a margin of 8 pixels.
        validation: The samples to validate with, which are not learned from.
        augmentation: The augmentation of training samples; zoom is not used.
        data: JSON-able: what the samples are.
    """

    name = "road_type"
    leading_metric = "balanced_accuracy"

    def __init__(
        self,
        selector: DrivingConstraintSelector,
        training: RoadTypeSamples,
        validation: RoadTypeSamples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self.network: nn.Module = selector.network.requires_grad_(True)
        self.trained = self.network
        self._selector, self._augmentation, self._data = selector, augmentation, data
        self._training, self._validation = training, validation
        shares = np.bincount(training.road_type, minlength=len(ROAD_TYPES)) / len(training.images)
        self._weights = 0.5 / np.maximum(shares, 1e-3)

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training.images)

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> RoadTypeBatch:
        """See `Task`."""
        images = np.stack([self._varied(index, randomness) for index in indices])
        truth = self._training.road_type[list(indices)]
        return RoadTypeBatch(
            _tensor(images),
            torch.from_numpy(truth),
            torch.from_numpy(self._weights[truth]).float(),
        )

    def losses(self, batch: RoadTypeBatch) -> dict[str, Tensor]:
        """See `Task`: cross-entropy, in which both road types weigh the same."""
        evidence = self.network(batch.images)
        entropy = functional.cross_entropy(evidence, batch.road_type, reduction="none")
        return {"entropy": (batch.weight * entropy).mean()}

    def validate(self) -> dict[str, float]:
        """See `Task`."""
        device = next(self.network.parameters()).device
        samples, found = self._validation, []
        for start in range(0, len(samples.images), _VALIDATION_BATCH):
            images = _tensor(samples.images[start : start + _VALIDATION_BATCH].astype(np.float32))
            with torch.no_grad():
                evidence = self.network(images.to(device))
            found.append((evidence[:, 1] > evidence[:, 0]).cpu().numpy())
        right = np.concatenate(found) == samples.road_type
        by_truth = [right[samples.road_type == number] for number in range(len(ROAD_TYPES))]
        return {
            "accuracy": float(right.mean()),
            "balanced_accuracy": float(np.mean([part.mean() for part in by_truth if len(part)])),
        }

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._selector.configuration),
            "augmentation": asdict(self._augmentation),
            "data": self._data,
        }

    def _varied(self, index: int, randomness: np.random.Generator) -> NDArray[np.float32]:
        down, right = (int(value) for value in randomness.integers(2 * _MARGIN + 1, size=2))
        images = shifted([self._training.images[index]], _MARGIN, down, right)
        if randomness.uniform() < self._augmentation.flip:
            images = [images[0][:, ::-1]]
        return relit_alike(images, self._augmentation.photometric, randomness)[0]


def road_type_task(options: TaskOptions) -> RoadTypeTask:
    """The driving-constraint selector; see `make_task`."""
    torch.manual_seed(options.seed)
    selector = DrivingConstraintSelector(options.preset, weights=None)
    options.begin(selector.network)
    split = split_by_scene(options.data or (training_suite("mixed"),), options.validation)
    size = selector.configuration.input_size
    larger = (size[0] + 2 * _MARGIN, size[1] + 2 * _MARGIN)
    training = _read(split.training, larger, options.on_progress)
    validation = _read(split.validation, size, options.on_progress)
    return RoadTypeTask(selector, training, validation, options.augmentation, split.description())


def _read(
    frames: Sequence[SceneFrame],
    size: tuple[int, int],
    on_progress: Progress | None,
) -> RoadTypeSamples:
    """Small enough to be read anew by each training."""
    images, numbers = [], []
    for done, frame in enumerate(frames, start=1):
        images.append(reduced_image(frame.frame().image(2), size))
        numbers.append(ROAD_TYPES.index(frame.road_type))
        if on_progress is not None:
            on_progress(done, len(frames))
    return RoadTypeSamples(np.stack(images), np.array(numbers))


def _tensor(images: NDArray[np.float32]) -> Tensor:
    return torch.from_numpy(images).permute(0, 3, 1, 2).contiguous()
