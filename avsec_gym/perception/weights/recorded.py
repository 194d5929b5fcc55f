"""What a card states of its network that the shapes of its tensors do not.

The same weights fit a network whichever way it enlarges its maps, and answer with other numbers:
PSMNet's published ones are 1.2 px off on KITTI where 0.3 is theirs.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.errors import ConfigurationError, DataError

if TYPE_CHECKING:
    from torch import nn

    from avsec_gym.perception.weights.model_card import ModelCard

CORNERS = "aligned_corners"
"""The name of such settings in every configuration: whether the centres of the outermost cells stay
where they are when a map is enlarged."""


def check_recorded(path: Path, card: ModelCard, network: nn.Module) -> None:
    """Compare how the network enlarges its maps with how the one of the weights did.

    Args:
        path: The path of the weights.
        card: The card of the weights.
        network: The network to be filled; one without a `configuration` is taken as it is.

    Raises:
        ConfigurationError: The network does it in another way.
        DataError: A published checkpoint was imported before this was recorded.
    """
    configuration = getattr(network, "configuration", None)
    if not is_dataclass(configuration) or isinstance(configuration, type):
        return
    recorded = dict(_corners(card.configuration))
    for name, value in _corners(asdict(configuration)):
        if name in recorded and recorded[name] != value:
            raise ConfigurationError(
                f"the weights {path} belong to a network with {name}={recorded[name]}, this one"
                f" has {name}={value}: they would fit, and answer wrongly"
            )
        if name not in recorded and card.source is not None:
            raise DataError(
                f"The card does not record {name}, which published weights depend on.",
                path=path,
                remedy="Import the checkpoint again with `avsec weights import`.",
            )


def recorded_corners(card: ModelCard | None, name: str, default: bool) -> bool:
    """A setting as a card has it, by its dotted name; the default where there is no card.

    Raises:
        DataError: The card holds something else than true or false there.
    """
    found = dict(_corners({} if card is None else card.configuration)).get(name, default)
    if not isinstance(found, bool):
        raise DataError(
            f"The weights' card has {name}: {found!r}, which is neither true nor false.",
            remedy="Import or train the weights again.",
        )
    return found


def is_recorded(configuration: Any, recorded: Mapping[str, Any]) -> bool:
    """Whether a card's configuration is this dataclass; fields that came later are not in cards."""
    known = json.loads(json.dumps(asdict(configuration)))
    same = [known[name] == value for name, value in recorded.items() if name in known]
    return bool(same) and all(same)


def _corners(configuration: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Such settings of a configuration and of all in it, by dotted names."""
    for name, value in configuration.items():
        if name == CORNERS:
            yield above + name, value
        elif isinstance(value, Mapping):
            yield from _corners(value, f"{above}{name}.")
