"""The edition of a preset that given weights were trained for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from avsec_gym.perception.presets import PresetConfiguration, chosen_configuration
from avsec_gym.perception.weights.given import Weights, card_of
from avsec_gym.perception.weights.model_card import ModelCard

P = TypeVar("P", bound=PresetConfiguration)


def chosen_edition(
    kind: type[P],
    given: P | str,
    weights: Weights,
    detector: str,
    edition: Callable[[str, ModelCard | None], P],
) -> tuple[P, str]:
    """A configuration and its preset, of a preset the edition that the weights were trained for.

    Args:
        kind: Class of the configuration.
        given: A configuration, which counts as a variation of ``small``; or a preset's name.
        weights: The weights that the network is to have.
        detector: Name of the detector or depth estimator, with which its weights' names begin.
        edition: The edition of a preset, by its name and the card of the weights.

    Raises:
        ConfigurationError: No preset has the name, or it is something else; or these are no
            weights.
        DataError: The weights' file is missing or damaged.
    """
    if not isinstance(given, str):
        return chosen_configuration(kind, given)
    # A name that no preset has is refused before any file is looked for.
    kind.preset(given)
    return edition(given, card_of(weights, f"{detector}_{given}")), given
