"""A running average of a network's weights, steadier than the weights of any one step."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch
from torch import Tensor, nn

_Weights = dict[str, Tensor]


class WeightAverage:
    """Exponential average of the parameters and of the running statistics that go with them.

    What counts, such as a normalisation's batches, is taken as it is.

    Args:
        network: Averaged from its present weights on.
        decay: Share of the average that stays at each step; less in the first steps, so that
            the first weights are soon forgotten.
    """

    def __init__(self, network: nn.Module, decay: float) -> None:
        self._network, self._decay = network, decay
        self.weights: _Weights = {
            name: value.detach().clone() for name, value in network.state_dict().items()
        }
        self._averaged = [n for n, value in self.weights.items() if value.is_floating_point()]
        self._copied = [name for name in self.weights if name not in self._averaged]

    @torch.no_grad()
    def update(self, step: int) -> None:
        """Take the network's present weights in.

        Args:
            step: How many updates there were before.
        """
        now = self._network.state_dict()
        decay = min(self._decay, (1 + step) / (10 + step))
        torch._foreach_lerp_(
            [self.weights[name] for name in self._averaged],
            [now[name] for name in self._averaged],
            1.0 - decay,
        )
        for name in self._copied:
            self.weights[name].copy_(now[name])

    @contextmanager
    def applied(self) -> Iterator[None]:
        """The network has the average for its weights, in evaluation mode, and then its own."""
        own = {name: value.clone() for name, value in self._network.state_dict().items()}
        self._network.load_state_dict(self.weights)
        self._network.eval()
        try:
            yield
        finally:
            self._network.load_state_dict(own)
            self._network.train()
