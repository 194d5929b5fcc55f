"""Weights as files: safetensors, and beside them a card that states where they come from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import torch
from safetensors.torch import save
from torch import Tensor, nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.recorded import check_recorded
from avsec_gym.perception.weights.state_dict import fit_state
from avsec_gym.perception.weights.tensor_files import read_tensors
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folders import named
from avsec_gym.storage.json_fields import read_fields
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import write_text

WHERE_FROM = "Train them with `avsec train`, or take published ones with `avsec weights import`."
_AGAIN = "Fetch or train the weights again."


def save_weights(path: str | Path, network: nn.Module, card: ModelCard) -> ModelCard:
    """Write a network's weights, and the card beside them (same name, ``.json``).

    Args:
        path: A ``.safetensors`` file, written over.
        network: The network whose weights are stored.
        card: The card, whose `storage` (``float16`` or ``float32``) is that of all floating-point
            numbers; size and hash are filled in.

    Returns:
        The card as written.

    Raises:
        DataError: A weight does not fit into the storage, or the place cannot be written.
    """
    path = Path(path)
    kind = getattr(torch, card.storage)
    stored = {name: _stored(name, value, kind, path) for name, value in _state(network).items()}
    content = save(stored, metadata={"network": card.network})
    facts = asdict(card) | {
        "parameters": sum(value.numel() for value in network.parameters()),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    write_bytes(path, content, overwrite=True)
    return write_card(path, ModelCard(**facts))


def write_card(path: str | Path, card: ModelCard) -> ModelCard:
    """Write a card beside a file of weights, over the one that is there."""
    write_text(card_path(named(path)), json.dumps(asdict(card), indent=1) + "\n", overwrite=True)
    return card


def load_weights(path: str | Path, network: nn.Module) -> ModelCard | None:
    """Fill a network with the weights of a file, as float32 or whatever the network has.

    Args:
        path: The file, as `save_weights` writes it.
        network: A network of the configuration that the weights are for.

    Returns:
        The card, if one is there.

    Raises:
        ConfigurationError: The network does something else with them, see `recorded`.
        DataError: The file is missing, damaged, not the one of its card, or of another network;
            what is missing, unexpected or of another shape is named.
    """
    path = Path(path)
    state, card = read_weights(path)
    if card is not None:
        check_recorded(path, card, network)
    network.load_state_dict(fit_state(state, network, path))
    return card


def read_weights(path: str | Path) -> tuple[dict[str, Tensor], ModelCard | None]:
    """The tensors of a file, and its card, if one is there.

    Raises:
        DataError: The file is missing, damaged, or not the one of its card.
    """
    path = Path(path)
    if not is_there(path):
        raise DataError("There are no weights here.", path=path, remedy=WHERE_FROM)
    state, content = read_tensors(path, remedy=_AGAIN)
    card = read_card(path)
    if card is not None and card.sha256 != hashlib.sha256(content).hexdigest():
        raise DataError("The file is not the one of its card.", path=path, remedy=_AGAIN)
    return state, card


def read_card(path: str | Path) -> ModelCard | None:
    """The card beside a file of weights; None where there is none.

    Raises:
        DataError: It is not one.
    """
    place = card_path(Path(path))
    if not is_there(place):
        return None
    return read_fields(ModelCard, place, remedy=_AGAIN)


def card_path(path: Path) -> Path:
    """Where the card of a file of weights is."""
    return path.with_suffix(".json")


def _state(network: nn.Module) -> Mapping[str, Tensor]:
    return {name: value.detach().cpu() for name, value in network.state_dict().items()}


def _stored(name: str, value: Tensor, kind: torch.dtype, path: Path) -> Tensor:
    if not value.is_floating_point():
        return value.contiguous()
    result = value.to(kind).contiguous()
    if not torch.isfinite(result).all():
        raise DataError(
            f"The weight {name} is not finite, or beyond {kind}.",
            path=path,
            remedy="Store float32, or train again.",
        )
    return result
