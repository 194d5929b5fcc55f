"""Keys and size of the original, and where it sees."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.network import PixorNetwork


def test_keys_and_shapes_are_the_originals(shared: Path) -> None:
    state = PixorNetwork(PixorConfiguration.preset("default")).state_dict()
    ours = [f"{name} {tuple(value.shape)}" for name, value in state.items()]
    assert sorted(ours) == sorted((shared / "parity/pixor_keys.txt").read_text().splitlines())


def test_the_small_one_is_small_and_has_the_same_parts() -> None:
    small, default = (
        PixorNetwork(PixorConfiguration.preset(name)) for name in ("small", "default")
    )
    assert sum(value.numel() for value in small.parameters()) < 400_000
    assert small.state_dict().keys() < default.state_dict().keys()


def test_shapes_and_what_an_untrained_network_says(tiny: PixorConfiguration) -> None:
    torch.manual_seed(0)
    output = PixorNetwork(tiny).eval()(torch.rand(2, *tiny.region.shape))
    assert output.logits.shape == output.scores.shape == (2, 48, 56)
    assert output.values.shape == (2, 6, 48, 56)
    assert not output.values.any()
    assert torch.unique(output.scores).tolist() == pytest.approx([0, 0.01])


def test_nothing_is_found_outside_of_88_degrees() -> None:
    network = PixorNetwork(PixorConfiguration.preset("default"))
    in_view = network.get_buffer("in_view")
    # Ten metres ahead: 24 cells to the side are 43.8 degrees, 25 are 45.
    assert in_view[76:125, 25].all()
    assert not in_view[:76, 25].any()
    assert not in_view[125:, 25].any()
    assert "in_view" not in network.state_dict()
