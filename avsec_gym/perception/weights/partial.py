"""Weights of a relative: whatever has the same name and shape is taken to begin a training with."""

from __future__ import annotations

import os
from pathlib import Path

from torch import nn

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.state_dict import fit_state
from avsec_gym.perception.weights.store import load_weights, read_weights

_NAMED = 6


def load_what_fits(path: str | Path, network: nn.Module) -> tuple[ModelCard | None, str]:
    """Fill a network with the weights of a file as far as they fit; the others stay.

    The scales of a normalisation are taken whichever numbers it normalises over.

    Args:
        path: The file, as `save_weights` writes it.
        network: The network that is given the weights, in place.

    Returns:
        The card of the file, if there is one, and in words what fitted, empty where all did.

    Raises:
        ConfigurationError: All fit, and the network does something else with them.
        DataError: The file is missing or damaged, or nothing of it fits.
    """
    state, card = read_weights(path)
    wanted = network.state_dict()
    fitting = {
        name: value
        for name, value in state.items()
        if name in wanted and value.shape == wanted[name].shape
    }
    if len(fitting) == len(state) == len(wanted):
        return load_weights(path, network), ""
    if not any(value.ndim > 1 for value in fitting.values()):
        raise DataError(
            "Nothing of these weights fits this network.",
            path=path,
            remedy="Begin with weights of a network that shares layers with it.",
        )
    network.load_state_dict(fit_state({**wanted, **fitting}, network, path))
    taken, numbers = (sum(wanted[name].numel() for name in names) for names in (fitting, wanted))
    random = sorted({name.split(".")[0] for name in wanted if name not in fitting})
    named = ", ".join(random[:_NAMED]) + (", ..." if len(random) > _NAMED else "")
    return card, (
        f"{os.fspath(path)}: {len(fitting)} of {len(wanted)} tensors fit, {taken:,} of {numbers:,}"
        f" numbers; random, at least in part: {named}"
    )
