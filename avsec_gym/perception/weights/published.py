"""Checkpoints that the authors of the original repositories publish, read without trusting them."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.state_dict import fit_state

_WRAPPERS = ("state_dict", "model")
_PARALLEL = "module."


def load_published(path: str | Path, network: nn.Module) -> None:
    """Fill a network with a published checkpoint.

    Args:
        path: What ``torch.save`` wrote: a dictionary of tensors, or one that holds such a
            dictionary as ``state_dict`` or ``model``.  Nothing in it is executed.
        network: That it is for.

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
    try:
        with warnings.catch_warnings():
            # Of formats that torch may not know in full: it then refuses them by itself.
            warnings.simplefilter("ignore")
            content = torch.load(path, map_location="cpu", weights_only=True)
    except FileNotFoundError as error:
        raise DataError("There is no such file.", path=path) from error
    except pickle.UnpicklingError as error:
        raise DataError(
            "The file holds more than tensors and plain values, or is no checkpoint.",
            path=path,
            remedy="Code in checkpoints is never run.  If you trust it, load it with torch "
            "yourself and save its state_dict alone.",
        ) from error
    except (OSError, RuntimeError, ValueError, EOFError) as error:
        problem = str(error).partition("\n")[0]
        raise DataError(
            f"The checkpoint cannot be read ({problem}).", path=path, remedy="Download it again."
        ) from error
    state = _unwrapped(content)
    if not state:
        raise DataError(
            "There is no dictionary of tensors in this file.",
            path=path,
            remedy=f"It may stand under {' or '.join(map(repr, _WRAPPERS))}.",
        )
    return {name.removeprefix(_PARALLEL): value for name, value in state.items()}


def _unwrapped(content: Any) -> dict[str, Tensor]:
    if not isinstance(content, Mapping):
        return {}
    for name in _WRAPPERS:
        if isinstance(content.get(name), Mapping):
            return _unwrapped(content[name])
    return dict(content) if all(isinstance(value, Tensor) for value in content.values()) else {}
