"""The weights that a user gives to a network: a file, tensors, those of the package, or none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from torch import Tensor, nn

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import WHERE_FROM, load_weights, read_card
from avsec_gym.storage.regular_files import is_file

SHIPPED = "shipped"
"""Stands for the weights that come with the package."""

_LONGEST = 500
"""Letters of the message of torch about weights that do not fit that are repeated."""
Weights = str | Path | Mapping[str, Tensor] | None
"""A file as `save_weights` writes it; a ``state_dict``; `SHIPPED`; None for random ones."""


def check_weights(weights: Any, name: str) -> None:
    """Refuse what cannot be weights, before a network is made for them.

    Args:
        weights: What the user gave; see `Weights`.
        name: The name as for `give_weights`.

    Raises:
        ConfigurationError: It is something else.
        DataError: There is no such file, or none comes with the package.
    """
    if isinstance(weights, str | Path):
        path = shipped_weights(name) if weights == SHIPPED else Path(weights)
        if not is_file(path):
            raise DataError("There are no weights here.", path=path, remedy=WHERE_FROM)
        return
    tensors = isinstance(weights, Mapping) and all(
        isinstance(key, str) and isinstance(value, Tensor) for key, value in weights.items()
    )
    if weights is not None and not tensors:
        raise ConfigurationError(
            f"weights takes a file, {SHIPPED!r}, a dictionary of tensors, or None, got "
            f"{shown(weights)}"
        )


def give_weights(network: nn.Module, weights: Weights, name: str) -> ModelCard | None:
    """Fill a network; it stands in evaluation mode then, its weights frozen.

    Args:
        network: The network to be filled.
        weights: The weights, see `Weights`.
        name: The name of network and preset, such as ``dsgn_small``: that of the package's file.

    Returns:
        The card of a file, if one is there.

    Raises:
        ConfigurationError: A ``state_dict`` of another network, or a file whose network did
            something else with the same weights, see `recorded`.
        DataError: The file is missing, damaged, or of another network.
    """
    check_weights(weights, name)
    if isinstance(weights, Mapping):
        try:
            network.load_state_dict(weights)
        except RuntimeError as error:
            problem = " ".join(str(error).split())[:_LONGEST]
            raise ConfigurationError(f"weights of another network: {problem}") from error
    network.eval().requires_grad_(False)
    if weights is None or isinstance(weights, Mapping):
        return None
    return load_weights(shipped_weights(name) if weights == SHIPPED else weights, network)


def card_of(weights: Weights, name: str) -> ModelCard | None:
    """The card of weights that are a file, before any network is filled.

    Args:
        weights: The weights, see `Weights`.
        name: The name as for `give_weights`.

    Raises:
        DataError: No such weights come with the package, or the card is none.
    """
    check_weights(weights, name)
    if weights is None or isinstance(weights, Mapping):
        return None
    return read_card(shipped_weights(name) if weights == SHIPPED else weights)


def names_of_shipped_weights() -> list[str]:
    """The names that `shipped_weights` takes, sorted."""
    return sorted(path.stem for path in Path(__file__).parent.glob("*.safetensors"))


def shipped_weights(name: str) -> Path:
    """The package's file of weights.

    Raises:
        DataError: None come with the package for this network and preset.
    """
    path = Path(__file__).parent / f"{name}.safetensors"
    if not is_file(path):
        raise DataError(
            f"No weights of {name} come with the package.",
            path=path,
            remedy=WHERE_FROM + " Then name the file: weights=FILE.",
        )
    return path
