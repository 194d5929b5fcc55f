"""Configurations of networks by the names of their presets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, Self, TypeVar

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError


class PresetConfiguration(Protocol):
    """A network's configuration that has presets."""

    @classmethod
    def preset(cls, name: str) -> Self:
        """The preset of a name."""
        ...


C = TypeVar("C")
P = TypeVar("P", bound=PresetConfiguration)


def preset_named(network: str, name: str, presets: Mapping[str, C]) -> C:
    """The preset of a name.

    Args:
        network: Name of the network, for the message.
        name: Name of the preset.
        presets: Presets by their names.

    Raises:
        ConfigurationError: No preset has the name.

    Example:
        >>> preset_named("PIXOR", "small", {"small": 1})
        1
    """
    if name not in presets:
        raise ConfigurationError(
            f"no {network} is called {shown(name)}; there are {', '.join(sorted(presets))}"
        )
    return presets[name]


def chosen_configuration(kind: type[P], given: P | str) -> tuple[P, str]:
    """A configuration, and the preset whose weights the package ships for it.

    Args:
        kind: Class of the configuration.
        given: A configuration, which counts as a variation of ``small``; or a preset's name.

    Raises:
        ConfigurationError: No preset has the name, or it is something else.
    """
    if isinstance(given, str):
        return kind.preset(given), given
    return checked_configuration(kind, given), "small"


def checked_configuration(kind: type[P], given: Any) -> P:
    """A configuration that is given as such.

    Raises:
        ConfigurationError: It is something else.
    """
    if isinstance(given, kind):
        return given
    raise ConfigurationError(
        f"configuration takes the name of a preset, or a {kind.__name__}, got {shown(given)}"
    )
