"""Counts that cannot be."""

from __future__ import annotations

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.region_counts import ProposalCount, SampleCount


def test_impossible_counts_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="sample"):
        SampleCount(regions=0)
    with pytest.raises(ConfigurationError, match="sample"):
        SampleCount(true_anchors=1.5)
    with pytest.raises(ConfigurationError, match="suppression"):
        ProposalCount(10, 20)
