"""Scans that come again are clustered once."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Points
from avsec_gym.validation.connected.proposals import remembered
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.regions import Regions


def test_a_scan_is_known_by_its_points(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Points] = []

    class Counting:
        def __call__(self, points: Points) -> Regions:
            asked.append(points)
            return Regions.empty()

    monkeypatch.setattr(remembered, "ClusterProposer", Counting)
    scans = [np.random.default_rng(seed).random((600, 4), np.float32) for seed in range(3)]
    propose = RememberedProposals(2)
    first = propose(scans[0])
    assert propose(scans[0].copy()) is first
    # One point of many is another scan, even one that is not looked at for the key.
    changed = scans[0].copy()
    changed[1] += 1
    propose(changed)
    assert len(asked) == 2
    # The first of three is forgotten.
    propose(scans[1])
    propose(scans[0])
    assert len(asked) == 4


def test_a_number_that_cannot_be() -> None:
    with pytest.raises(ConfigurationError, match="most"):
        RememberedProposals(0)
