"""What is said of sensors goes with the alarm, whatever the probabilities are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.state_posterior import (
    Decoding,
    SensorStatus,
    StatePosterior,
    state_vectors,
)

SOUND, ATTACKED, OPEN = SensorStatus.SOUND, SensorStatus.ATTACKED, SensorStatus.CANNOT_TELL


def decoding(probabilities: dict[int, float], *, alarm: bool, familiar: bool = True) -> Decoding:
    """Of one frame with four sensors; the clean state has what is left."""
    each = np.zeros(16)
    each[list(probabilities)] = list(probabilities.values())
    each[0] += 1 - each.sum()
    return Decoding(StatePosterior(each[None]), np.array([alarm]), np.array([familiar]))


@given(
    st.lists(st.integers(-300, 0), min_size=16, max_size=16),
    st.booleans(),
    st.booleans(),
    st.sampled_from([None, 0.51, 0.7, 0.95, 1.0]),
)
def test_alarm_and_statuses_never_contradict_each_other(
    powers: list[int], alarm: bool, familiar: bool, certainty: float | None
) -> None:
    each = 10.0 ** np.array(powers)
    found = decoding(dict(enumerate(each / each.sum())), alarm=alarm, familiar=familiar)
    said = found.statuses(certainty)[0]
    if not familiar:
        assert said == [OPEN] * 4
    elif alarm:
        assert said != [SOUND] * 4
        assert found.states.any()
    else:
        assert ATTACKED not in said
        assert not found.states.any()


def test_an_alarm_that_the_probabilities_do_not_bear_out_leaves_the_statuses_open() -> None:
    # The hardest clean frames were easier still, so that a thousandth raises the alarm.
    faint = decoding({0b0010: 8e-4, 0b0100: 2e-4}, alarm=True)
    assert faint.statuses() == [[SOUND, OPEN, OPEN, SOUND]]
    # And harder ones keep it down: then no sensor is named, and none cleared that may be attacked.
    strong = {0b0010: 0.98}
    assert decoding(strong, alarm=True).statuses() == [[SOUND, ATTACKED, SOUND, SOUND]]
    assert decoding(strong, alarm=False).statuses() == [[SOUND, OPEN, SOUND, SOUND]]


def test_without_a_certainty_the_most_probable_state_is_said() -> None:
    likely = {0b0011: 0.3, 0b0100: 0.25}
    assert decoding(likely, alarm=True).statuses(None) == [[ATTACKED, ATTACKED, SOUND, SOUND]]
    assert decoding(likely, alarm=False).statuses(None) == [[SOUND] * 4]
    assert decoding(likely, alarm=True, familiar=False).statuses(None) == [[OPEN] * 4]


def test_given_an_attack_by_hand() -> None:
    posterior = StatePosterior(np.r_[0.9, 0.06, 0.03, 0.01, np.zeros(4)][None])
    np.testing.assert_allclose(posterior.given_attack, [[0.7, 0.4, 0.0]])
    np.testing.assert_allclose(posterior.sensors, posterior.probabilities @ state_vectors(3))


@pytest.mark.parametrize("certainty", [0.5, 1.01, float("nan")])
def test_a_certainty_that_is_none(certainty: float) -> None:
    with pytest.raises(ConfigurationError, match="certainty"):
        decoding({1: 0.5}, alarm=True).statuses(certainty)
