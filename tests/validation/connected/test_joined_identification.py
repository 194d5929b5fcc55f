"""Beyond chapter 3's limit: what connected vehicles add to a car's own evidence."""

from __future__ import annotations

from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.connected.joined_identification import (
    StatusLikelihood,
    identify_with_neighbours,
    joined_posterior,
)
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.state_posterior import (
    Decoding,
    SensorStatus,
    StatePosterior,
    attack_prior,
    state_vectors,
)

_SLIP = 0.01
"""Chance that a triple is inconsistent without an attack, or consistent in spite of one."""
_NAMED, _CLEARED = 5.0, -5.0
"""Log-likelihood ratios of a LiDAR that others name, and of one that they find sound."""


def _triples(sensors: int) -> list[tuple[int, int, int]]:
    return list(combinations(range(sensors), 3))


def _inconsistent(state: np.ndarray) -> np.ndarray:
    """Of each triple of sensors whether one of its three is attacked."""
    return np.array([state[list(triple)].any() for triple in _triples(len(state))])


def _posterior(state: np.ndarray) -> StatePosterior:
    """P(s | E), where each triple shows its three sensors' state but for a slip, by definition."""
    seen = _inconsistent(state)
    likelihood = []
    for each in state_vectors(len(state)):
        agrees = _inconsistent(each) == seen
        likelihood.append(np.prod(np.where(agrees, 1 - _SLIP, _SLIP)))
    found = np.array(likelihood) * attack_prior(len(state), beyond=1.0)
    return StatePosterior((found / found.sum())[None])


def _statuses(posterior: StatePosterior) -> list[SensorStatus]:
    yes = np.ones(1, bool)
    return Decoding(posterior, yes, yes).statuses(0.8)[0]


def _states_left_open(sensors: int) -> list[np.ndarray]:
    """The LiDAR and n - 2 cameras attacked, one sensor more than the thesis' algorithms name."""
    found = []
    for cameras in combinations(range(1, sensors), sensors - 3):
        state = np.zeros(sensors, bool)
        state[[0, *cameras]] = True
        found.append(state)
    return found


@pytest.mark.parametrize("sensors", [3, 4, 5])
def test_one_more_attacked_sensor_than_a_car_alone_can_name_is_named(sensors: int) -> None:
    for state in _states_left_open(sensors):
        own = _posterior(state)
        assert SensorStatus.CANNOT_TELL in _statuses(own)
        without_lidar = state.copy()
        without_lidar[0] = False
        joined = joined_posterior(own, _NAMED, _posterior(without_lidar))
        expected = [SensorStatus.ATTACKED if each else SensorStatus.SOUND for each in state]
        assert _statuses(joined) == expected


def test_the_thesis_algorithms_leave_these_states_open() -> None:
    for state in _states_left_open(4):
        assert _inconsistent(state).all()
        found = identify_attacked_sensors(lambda triple, s=state: bool(s[list(triple)].any()), 4)
        assert set(found.named) != set(np.flatnonzero(state).tolist())


def test_a_lidar_that_others_clear_leaves_the_cameras() -> None:
    own = _posterior(np.array([False, True, False]))
    assert _statuses(own) == [SensorStatus.CANNOT_TELL] * 3
    lidar, *cameras = _statuses(joined_posterior(own, _CLEARED))
    assert lidar == SensorStatus.SOUND
    assert cameras == [SensorStatus.CANNOT_TELL] * 2


def test_log_likelihoods_add_up() -> None:
    own = _posterior(np.array([True, False, False, False]))
    states = own.states
    joined = joined_posterior(own, 1.7)
    logs = np.log(own.probabilities[0]) + 1.7 * states[:, 0]
    np.testing.assert_allclose(joined.probabilities[0], np.exp(logs) / np.exp(logs).sum())
    np.testing.assert_allclose(joined_posterior(own, 0.0).probabilities, own.probabilities)
    # The recovered scan says nothing of whether the LiDAR was attacked.
    recovered = _posterior(np.array([False, True, False, False]))
    both = joined_posterior(own, 1.7, recovered)
    np.testing.assert_allclose(both.sensors[:, 0], joined.sensors[:, 0])
    without = both.probabilities[0, ~states[:, 0]]
    np.testing.assert_allclose(without, joined.probabilities[0, ~states[:, 0]])


def test_statuses_are_worth_what_they_were_counted_for() -> None:
    likelihood = StatusLikelihood(
        {"attacked": 13, "cannot tell": 9, "sound": 38}, {"sound": 32, "cannot tell": 0}
    )
    named, still_open, sound = (
        likelihood.ratio(status)
        for status in (SensorStatus.ATTACKED, SensorStatus.CANNOT_TELL, SensorStatus.SOUND)
    )
    assert named == pytest.approx(np.log((14 / 63) / (1 / 35)))
    assert named > still_open > 0 > sound
    # Attacks that no other vehicle sees are reported as sound: that clears little.
    assert sound > -1
    with pytest.raises(ConfigurationError, match="counted"):
        StatusLikelihood({"guilty": 3}, {})
    with pytest.raises(ConfigurationError, match="counted"):
        StatusLikelihood({"sound": -1}, {})


class _Own:
    """Evidence of a car's own sensors: frames are named by what is attacked in them."""

    system = SensorSystem((LIDAR, 1, 3, 2))

    def decode(self, frame: str) -> Decoding:
        state = np.array([name in frame.split("+") for name in ("lidar", "1", "3", "2")])
        yes = np.ones(1, bool)
        return Decoding(_posterior(state), np.array([state.any()]), yes)


def _others(status: SensorStatus, repaired: str = "") -> Any:
    judged = SimpleNamespace(
        statuses={LIDAR: status},
        alarm=status != SensorStatus.SOUND,
        repaired=lambda frame: repaired,
    )
    return SimpleNamespace(validate=lambda frame: judged)


def test_a_frame_is_judged_again_with_the_recovered_scan() -> None:
    likelihood = StatusLikelihood({"attacked": 300, "sound": 2}, {"sound": 300})
    frame: Any = "lidar+3"
    own: Any = _Own()
    named = _others(SensorStatus.ATTACKED, repaired="3")
    found = identify_with_neighbours(frame, own, named, likelihood)
    assert found.alarms.all()
    assert found.statuses(0.8)[0] == [
        SensorStatus.ATTACKED,
        SensorStatus.SOUND,
        SensorStatus.ATTACKED,
        SensorStatus.SOUND,
    ]
    cleared = identify_with_neighbours(frame, own, _others(SensorStatus.SOUND), likelihood)
    assert cleared.statuses(0.8)[0][0] == SensorStatus.SOUND
    clean: Any = ""
    assert not identify_with_neighbours(
        clean, own, _others(SensorStatus.SOUND), likelihood
    ).alarms.any()
    own.system = SensorSystem((1, 3, 2))
    with pytest.raises(ConfigurationError, match="have none"):
        identify_with_neighbours(frame, own, named, likelihood)
