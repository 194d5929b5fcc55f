"""`NetworkDetector`: what all detectors by a network hold: configuration, network, calibration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from torch import nn

from avsec_gym.perception.detectors.score_calibration import ScoreCalibration
from avsec_gym.perception.weights.given import Weights, check_weights, give_weights
from avsec_gym.perception.weights.model_card import ModelCard

Configuration = TypeVar("Configuration")
Network = TypeVar("Network", bound=nn.Module)


class NetworkDetector(Generic[Configuration, Network]):
    """A network that was given its weights.

    Its `network` stands in evaluation mode and its weights are frozen; training thaws it.  Scores
    are made probabilities by its `calibration`, that of the card of weights.

    Args:
        configuration: Configuration of the network.
        network: The network's class, which makes one of a configuration.
        weights: The weights, see `give_weights`.
        preset: Name of the preset, whose weights ``shipped`` stands for.

    Raises:
        ConfigurationError: The weights are those of another configuration.
        DataError: Their file is missing or damaged.
    """

    name: str

    def __init__(
        self,
        configuration: Configuration,
        network: Callable[[Configuration], Network],
        weights: Weights,
        preset: str,
    ) -> None:
        name = f"{self.name}_{preset}"
        # Before seconds are spent on a network.
        check_weights(weights, name)
        self.configuration = configuration
        self.network = network(configuration)
        self.card: ModelCard | None = give_weights(self.network, weights, name)
        self.calibration = ScoreCalibration.of_card(self.card)
