"""The constants that hold where nothing was fitted."""

from __future__ import annotations

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.constants import THESIS_THETA, ConnectedConstants


def test_an_attack_is_as_likely_as_not_at_the_thesis_threshold() -> None:
    probability = ConnectedConstants().of_distance.probability
    below, at, above = probability([THESIS_THETA - 0.5, THESIS_THETA, THESIS_THETA + 0.5])
    assert at == 0.5
    assert below == pytest.approx(1 - above)
    assert above > 0.85


@pytest.mark.parametrize("bad", [{"epsilon": -0.1}, {"theta": -1.5}, {"theta": float("nan")}])
def test_distances_that_are_none(bad: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError, match="are distances"):
        ConnectedConstants(**bad)
