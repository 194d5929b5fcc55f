"""`NetworkDetector`: what all detectors by a network hold: configuration, network, calibration."""

from __future__ import annotations

from typing import Generic, TypeVar

from torch import nn

from avsec_gym.perception.detectors.score_calibration import ScoreCalibration
from avsec_gym.perception.weights.given import Weights, give_weights
from avsec_gym.perception.weights.model_card import ModelCard

Configuration = TypeVar("Configuration")
Network = TypeVar("Network", bound=nn.Module)


class NetworkDetector(Generic[Configuration, Network]):
    """A network that was given its weights.

    Its `network` stands in evaluation mode and its weights are frozen; training thaws it.  Scores
    are made probabilities by its `calibration`, that of the card of weights.

    Args:
        configuration: Configuration of the network.
        network: Network to be given its weights, in place.
        weights: The weights, see `give_weights`.
        preset: Name of the preset, whose weights ``shipped`` stands for.

    Raises:
        ConfigurationError: The weights are those of another configuration.
        DataError: Their file is missing or damaged.
    """

    name: str

    def __init__(
        self, configuration: Configuration, network: Network, weights: Weights, preset: str
    ) -> None:
        self.configuration = configuration
        self.network = network
        self.card: ModelCard | None = give_weights(network, weights, f"{self.name}_{preset}")
        self.calibration = ScoreCalibration.of_card(self.card)
