"""Numbers of the original, and numbers that do not fit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.pointrcnn.configuration import (
    PointRcnnConfiguration,
    PointView,
    ProposalRule,
)


def test_the_default_is_as_published() -> None:
    default = PointRcnnConfiguration.preset("default")
    assert default.view == PointView((-40, 40), (-1, 3), (0, 70.4), 16384, far=40)
    assert [level.count for level in default.levels] == [4096, 1024, 256, 64]
    assert [level.radii for level in default.levels] == [(0.1, 0.5), (0.5, 1), (1, 2), (2, 4)]
    assert (default.proposals.before, default.proposals.after) == (9000, 100)
    assert default.training_proposals == ProposalRule(9000, 512, 0.85)
    assert default.refinement.points == 512
    assert default.sampling.regions == 64


def test_what_does_not_fit_is_refused() -> None:
    small = PointRcnnConfiguration.preset("small")
    with pytest.raises(ConfigurationError, match=r"nothing from 3\.0 to 3\.0"):
        PointView(side=(3.0, 3.0))
    with pytest.raises(ConfigurationError, match="4 levels down and 3"):
        replace(small, propagation=small.propagation[1:])
    with pytest.raises(ConfigurationError, match="become fewer"):
        replace(small, levels=small.levels[::-1])
    with pytest.raises(ConfigurationError, match="one of all points"):
        replace(small, refinement=replace(small.refinement, levels=small.levels[:1]))
    with pytest.raises(ConfigurationError, match="proposals are 1 or more"):
        ProposalRule(after=0)
    with pytest.raises(ConfigurationError, match="default, small"):
        PointRcnnConfiguration.preset("large")
