"""Averages of parameters and of the statistics that belong to them, by hand."""

from __future__ import annotations

import torch
from torch import nn

from avsec_gym.perception.training.weight_average import WeightAverage


def test_statistics_are_averaged_with_the_weights_and_counts_are_taken() -> None:
    network = nn.Sequential(nn.Linear(2, 3), nn.BatchNorm1d(3))
    average = WeightAverage(network, decay=0.5)
    begun = {name: value.clone() for name, value in network.state_dict().items()}
    with torch.no_grad():
        for value in network.state_dict().values():
            value.add_(4)
    # Of many steps before, so that the decay is the given one.
    average.update(step=1000)
    for name, value in average.weights.items():
        share = 4 if name.endswith("num_batches_tracked") else 2
        torch.testing.assert_close(value, begun[name] + share)
    with average.applied():
        assert not network.training
        torch.testing.assert_close(network[1].running_mean, begun["1.running_mean"] + 2)
    assert network.training
    torch.testing.assert_close(network[1].running_mean, begun["1.running_mean"] + 4)


def test_the_first_weights_are_soon_forgotten() -> None:
    network = nn.Linear(1, 1, bias=False)
    average = WeightAverage(network, decay=0.999)
    begun = float(average.weights["weight"])
    with torch.no_grad():
        network.weight.add_(1)
    average.update(step=0)
    assert float(average.weights["weight"]) - begun == torch.tensor(0.9)
