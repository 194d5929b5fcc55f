"""First weights of layers whose inputs' scale matters."""

from __future__ import annotations

import math

from torch import nn


def normal_weights(layer: nn.Module, deviation: float | None) -> None:
    """Weights of a given standard deviation, or of He's for their number of inputs."""
    if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d | nn.Linear):
        transposed = isinstance(layer, nn.ConvTranspose2d)
        inputs = len(layer.weight) if transposed else layer.weight[0].numel()
        nn.init.normal_(layer.weight, 0, math.sqrt(2 / inputs) if deviation is None else deviation)
        if layer.bias is not None:
            nn.init.zeros_(layer.bias)
