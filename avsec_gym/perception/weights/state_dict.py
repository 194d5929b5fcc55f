"""Does a collection of named tensors fit a network?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import torch
from torch import Tensor, nn

from avsec_gym.errors import DataError

LARGEST = 1e12
"""Greatest magnitude of a weight; a damaged bit of an exponent leads beyond it."""
_NAMED = 4
_COUNTER = "num_batches_tracked"
_VARIANCE = "running_var"
_COUNTING = (torch.int64, torch.int32)


def fit_state(
    state: Mapping[str, Tensor], network: nn.Module, path: str | Path
) -> dict[str, Tensor]:
    """The tensors for `load_state_dict`, in the network's own types.

    Counters of batches, which old checkpoints lack and no result depends on, may be missing.

    Args:
        state: The state that a file holds.
        network: The network that they are for.
        path: The path of the file, for messages.

    Raises:
        DataError: A tensor is missing, unexpected, of another shape or kind of numbers, not
            finite, beyond `LARGEST`, or a variance below 0; which ones.
    """
    # Counters that a checkpoint lacks are the network's own; tensors beyond the wanted ones stay.
    wanted = network.state_dict()
    state = {
        name: value.cpu() if name.endswith(_COUNTER) and name not in state else state[name]
        for name, value in wanted.items()
        if name in state or name.endswith(_COUNTER)
    } | {name: value for name, value in state.items() if name not in wanted}
    # Names and shapes first, all problems in one message.
    missing = [name for name in wanted if name not in state]
    unexpected = sorted(name for name in state if name not in wanted)
    other = [
        f"{name} {tuple(state[name].shape)} instead of {tuple(value.shape)}"
        for name, value in wanted.items()
        if name in state and state[name].shape != value.shape
    ]
    problems = [
        f"{len(names)} {what}: {_some(names)}"
        for what, names in (
            ("missing", missing),
            ("unexpected", unexpected),
            ("of another shape", other),
        )
        if names
    ]
    if problems:
        raise DataError(
            f"These are the weights of another network ({'; '.join(problems)}).",
            path=path,
            remedy="Choose the network and the configuration that they were trained for.",
        )
    # Then kinds of numbers and their values, tensor by tensor.
    fitted = {}
    for name, value in wanted.items():
        if _kind(state[name]) != _kind(value):
            raise DataError(
                f"The weight {name} holds numbers of the type {_type(state[name])}, the network's "
                f"are {_type(value)}.",
                path=path,
                remedy="Weights are floating-point numbers; quantised ones cannot be taken.",
            )
        fitted[name] = state[name].to(value.dtype)
        # After the cast: a double may be beyond what a float holds.
        if value.is_floating_point() and (problem := _problem(name, fitted[name])):
            raise DataError(
                f"The weight {name} holds a value that is {problem}.",
                path=path,
                remedy="The file is damaged, or its training diverged.",
            )
    return fitted


def problem_of_values(values: Tensor) -> str:
    """What a trained network's floating-point numbers cannot be; empty if they are sound."""
    if not values.isfinite().all():
        return "not finite"
    if values.numel() and (largest := values.abs().max().item()) > LARGEST:
        return f"{largest:.2g}, more than any network learns"
    return ""


def _problem(name: str, values: Tensor) -> str:
    """What these cannot be; batch normalisation divides by the root of the variance."""
    if name.endswith(_VARIANCE) and values.numel() and values.min() < 0:
        return "below 0, which no variance is"
    return problem_of_values(values)


def _kind(value: Tensor) -> str:
    """What is exchanged for each other without a loss of meaning: floats of all sizes, integers."""
    if value.is_floating_point():
        return "float"
    return "integer" if value.dtype in _COUNTING else _type(value)


def _type(value: Tensor) -> str:
    return str(value.dtype).removeprefix("torch.")


def _some(names: Iterable[str]) -> str:
    names = list(names)
    return ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
