"""Does a collection of named tensors fit a network?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from torch import Tensor, nn

from avsec_gym.errors import DataError

_NAMED = 4
_COUNTER = "num_batches_tracked"


def fit_state(
    state: Mapping[str, Tensor], network: nn.Module, path: str | Path
) -> dict[str, Tensor]:
    """The tensors for `load_state_dict`, in the network's own types.

    Counters of batches, which old checkpoints lack and no result depends on, may be missing.

    Args:
        state: From a file.
        network: That they are for.
        path: Of the file, for messages.

    Raises:
        DataError: A tensor is missing, unexpected, of another shape, or not finite; which ones.
    """
    wanted = network.state_dict()
    state = {
        name: value.cpu() if name.endswith(_COUNTER) and name not in state else state[name]
        for name, value in wanted.items()
        if name in state or name.endswith(_COUNTER)
    } | {name: value for name, value in state.items() if name not in wanted}
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
    for name, value in state.items():
        if value.is_floating_point() and not value.isfinite().all():
            raise DataError(
                f"The weight {name} holds a value that is not finite.",
                path=path,
                remedy="The file is damaged, or its training diverged.",
            )
    return {name: state[name].to(value.dtype) for name, value in wanted.items()}


def _some(names: Iterable[str]) -> str:
    names = list(names)
    return ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
