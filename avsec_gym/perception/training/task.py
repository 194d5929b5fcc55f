"""What the trainer asks of a task: a network, batches of its samples, losses, a validation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
import torch
from torch import Tensor, nn

B = TypeVar("B")
B_co = TypeVar("B_co", covariant=True)


class Prepared(Protocol[B_co]):
    """A batch that was made ahead of its step."""

    def to(self, device: torch.device | str) -> B_co:
        """What a task's losses take, on a device."""
        ...


class Task(Protocol[B]):
    """Something to be learned; see `avsec_gym.perception.training.tasks` for those there are."""

    name: str
    network: nn.Module
    """What is wanted; moved to the device, trained in place."""
    trained: nn.Module
    """All that is learned: the network, or a module of the network and of weights of losses."""
    leading_metric: str
    """The metric of `validate` by which the best weights are chosen; larger is better."""

    @property
    def samples(self) -> int:
        """How many there are to train on."""
        ...

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> Prepared[B]:
        """Training samples, augmented; called in threads, so it changes nothing.

        Where it is not a method of the task, but an object of its own, it is sent to processes, too
        (see `batches`).

        Args:
            indices: The indices of the samples, from 0 to ``samples - 1``.
            randomness: The randomness of the augmentation: the same gives the same batch.
        """
        ...

    def losses(self, batch: B) -> dict[str, Tensor]:
        """The terms whose sum is minimised, scalars; draws from torch's global generator only."""
        ...

    def validate(self) -> dict[str, float]:
        """Metrics of the network as it is, on samples that it is not trained on."""
        ...

    def description(self) -> dict[str, Any]:
        """JSON-able: the network's configuration, the data, the augmentation."""
        ...
