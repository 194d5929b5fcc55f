"""Checkpoints that the authors of the original repositories publish, read without trusting them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from torch import Tensor, nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.state_dict import fit_state
from avsec_gym.perception.weights.torch_files import read_torch_file
from avsec_gym.storage.inert_pickle import Unknown

_WRAPPERS = ("state_dict", "model")
_PARALLEL = "module."
_DEEPEST = 3
_REBUILT = "torch._utils._rebuild_"
"""What makes tensors: those that are not read, among them sparse and quantised ones."""


def load_published(path: str | Path, network: nn.Module) -> None:
    """Fill a network with a published checkpoint.

    Args:
        path: What ``torch.save`` wrote: a dictionary of tensors, or one that holds such a
            dictionary as ``state_dict`` or ``model``.  Nothing in it is executed.
        network: The network that it is for.

    Raises:
        DataError: It cannot be read, holds something else than tensors and plain values, or is of
            another network; what is missing or unexpected is named.
    """
    network.load_state_dict(fit_state(published_state(path), network, path))


def published_state(path: str | Path) -> dict[str, Tensor]:
    """The tensors of a published checkpoint, by the names in the network.

    Raises:
        DataError: As of `load_published`.
    """
    content = read_torch_file(path, remedy="Download it again; it may be cut off.")
    state = _unwrapped(content, path)
    if not state:
        raise DataError(
            "There is no dictionary of tensors in this file.",
            path=path,
            remedy=f"It may stand under {' or '.join(map(repr, _WRAPPERS))}.",
        )
    named = {name.removeprefix(_PARALLEL): value for name, value in state.items()}
    if len(named) < len(state):
        twice = next(name for name in named if name in state and _PARALLEL + name in state)
        raise DataError(
            f"The weight {twice} is there twice, with {_PARALLEL!r} before its name and without.",
            path=path,
            remedy="Leave one of the two in the dictionary.",
        )
    return named


def _unwrapped(content: Any, path: str | Path) -> dict[str, Tensor]:
    """The dictionary of tensors, perhaps within others; empty if there is none."""
    for _ in range(_DEEPEST):
        inner = [content[name] for name in _WRAPPERS if name in content] if _is(content) else []
        content = next(filter(_is, inner), content)
    if not _is(content):
        return {}
    known = {name: value for name, value in content.items() if isinstance(value, Tensor)}
    for name, value in content.items():
        if isinstance(value, Unknown) and value.name.startswith(_REBUILT):
            raise DataError(
                f"The weight {name} is no plain tensor ({value.name.removeprefix(_REBUILT)}).",
                path=path,
                remedy="Sparse and quantised tensors cannot be taken: store dense ones in "
                "floating point.",
            )
    # Counters and settings may stand beside the tensors, and no layer is one of them.
    others = [value for name, value in content.items() if name not in known]
    plain = all(isinstance(value, (int, float, str, Unknown, type(None))) for value in others)
    return known if plain and all(isinstance(name, str) for name in known) else {}


def _is(content: Any) -> bool:
    return isinstance(content, dict)
