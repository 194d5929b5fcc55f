"""The weights that a user gives to a network: a file, tensors, those of the package, or none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from torch import Tensor, nn

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import WHERE_FROM, load_weights, read_card
from avsec_gym.storage.regular_files import is_file

SHIPPED = "shipped"
"""Stands for the weights that come with the package."""

Weights = str | Path | Mapping[str, Tensor] | None
"""A file as `save_weights` writes it; a ``state_dict``; `SHIPPED`; None for random ones."""


def give_weights(network: nn.Module, weights: Weights, name: str) -> ModelCard | None:
    """Fill a network; it stands in evaluation mode then, its weights frozen.

    Args:
        network: The network to be filled.
        weights: See `Weights`.
        name: The name of network and preset, such as ``dsgn_small``: that of the package's file.

    Returns:
        The card of a file, if one is there.

    Raises:
        ConfigurationError: A ``state_dict`` of another network, or a file whose network did
            something else with the same weights, see `recorded`.
        DataError: The file is missing, damaged, or of another network.
    """
    if isinstance(weights, Mapping):
        try:
            network.load_state_dict(weights)
        except RuntimeError as error:
            raise ConfigurationError(f"weights of another network: {error}") from error
    network.eval().requires_grad_(False)
    if weights is None or isinstance(weights, Mapping):
        return None
    return load_weights(shipped_weights(name) if weights == SHIPPED else weights, network)


def card_of(weights: Weights, name: str) -> ModelCard | None:
    """The card of weights that are a file, before any network is filled.

    Args:
        weights: See `Weights`.
        name: The name as for `give_weights`.

    Raises:
        DataError: No such weights come with the package, or the card is none.
    """
    if weights is None or isinstance(weights, Mapping):
        return None
    return read_card(shipped_weights(name) if weights == SHIPPED else weights)


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
