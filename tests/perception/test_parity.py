"""Our networks agree with the original ones; the comparison is that of benchmarks/parity.py."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import pytest
import torch

_FILE = Path(__file__).parents[2] / "benchmarks" / "parity.py"
_SPECIFICATION = importlib.util.spec_from_file_location("parity_benchmark", _FILE)
parity = importlib.util.module_from_spec(_SPECIFICATION)
_SPECIFICATION.loader.exec_module(parity)

OUTPUTS = {
    "psmnet": 2,
    "dsgn": 4,
    "dsgn_12g": 4,
    "dsgn_12g_edges": 4,
    "stereo_rcnn": 9,
    "pixor": 2,
}
"""How many are compared."""


@pytest.mark.slow
@pytest.mark.parametrize("name", parity.NETWORKS)
def test_outputs_and_parameter_counts_are_the_originals(shared, name):
    with torch.no_grad():
        errors = parity.NETWORKS[name](shared / "parity")
    assert errors["parameters"] == 0
    assert len(errors) == 1 + OUTPUTS[name]
    assert max(errors.values()) <= 1e-3


def test_a_difference_fails_the_command(tmp_path, monkeypatch, capsys):
    (tmp_path / "README.md").touch()
    monkeypatch.setattr(parity, "NETWORKS", {"one": lambda _: {"a": 0.0, "b": 2e-3}})
    monkeypatch.setattr(sys, "argv", ["parity", str(tmp_path), "--json"])
    assert parity.main() == 1
    assert json.loads(capsys.readouterr().out) == {"one": {"a": 0.0, "b": 2e-3}}


def test_the_rule_knows_kinds_of_tensors():
    network = torch.nn.Sequential(torch.nn.Conv2d(3, 64, 3), torch.nn.BatchNorm2d(64))
    parity.fill_by_rule(network)
    values = network.state_dict()
    assert values["0.weight"].std() == pytest.approx((0.5 / 27) ** 0.5, rel=0.1)
    assert values["0.bias"].mean() == pytest.approx(0, abs=0.05)
    assert values["1.weight"].mean() == pytest.approx(1, abs=0.05)
    assert values["1.running_var"].min() >= 1
