"""Decisions: who is named, who is not, and what one liar can do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.rays.decision import (
    CANNOT_TELL,
    NO_ATTACK,
    DecisionRule,
    decide,
)
from avsec_gym.validation.connected.rays.fitting import ScoreProbability
from avsec_gym.validation.connected.rays.rates import RayRates, decidable, log_likelihood_ratio

_RATES, _RULE = RayRates(), DecisionRule()
_YES, _NO = (30, 0, 0), (0, 30, 0)


def _region(vehicles: int, pairs: dict[tuple[int, int], tuple[int, int, int]]) -> np.ndarray:
    counts = np.zeros((1, vehicles, vehicles, 3), np.int64)
    for pair, each in pairs.items():
        counts[0, pair[0], pair[1]] = each
    return counts


def test_the_ratio_is_the_sum_over_rays_of_one_testimony() -> None:
    rates = RayRates(0.9, 0.08, 0.02, 0.05, 0.8, 0.15, most=1e12)
    by_hand = 6 * np.log(0.8 / 0.08) + 2 * np.log(0.05 / 0.9) + np.log(0.15 / 0.02)
    assert log_likelihood_ratio([2, 6, 1], rates) == pytest.approx(by_hand)


def test_rays_of_one_object_count_as_few_that_are_independent() -> None:
    one = float(log_likelihood_ratio([0, 5, 0], RayRates(most=2.0, least=5)))
    many = float(log_likelihood_ratio([0, 100, 0], RayRates(most=2.0, least=5)))
    assert one < many < 2.0 * RayRates().weights[1]


def test_few_rays_and_missing_ones_alone_decide_nothing() -> None:
    assert decidable([[4, 0, 0], [0, 0, 90], [2, 3, 0]], _RATES).tolist() == [False, False, True]
    assert log_likelihood_ratio([0, 0, 90], _RATES) == 0


def test_two_witnesses_name_the_vehicle_with_the_ghost() -> None:
    decision = decide(_region(3, {(1, 0): _NO, (1, 2): _NO}), _RATES, _RULE)
    assert decision.named.tolist() == [1]
    assert decision.ghost[0, 1] > 0.9


def test_two_claims_name_the_vehicle_from_which_an_object_was_removed() -> None:
    pairs = {(0, 2): _NO, (1, 2): _NO, (0, 1): _YES, (1, 0): _YES}
    decision = decide(_region(3, pairs), _RATES, _RULE)
    assert decision.named.tolist() == [2]
    assert decision.removal[0, 2] > 0.9


def test_one_witness_alone_leaves_it_open_who_of_both_is_attacked() -> None:
    decision = decide(_region(3, {(0, 1): _NO}), _RATES, _RULE)
    assert decision.named.tolist() == [CANNOT_TELL]
    assert decision.victim[0].tolist() == pytest.approx([0.5, 0.5, 0.0])


def test_agreement_is_no_attack_and_silence_neither() -> None:
    pairs = {(i, j): _YES for i in range(3) for j in range(3) if i != j}
    assert decide(_region(3, pairs), _RATES, _RULE).named.tolist() == [NO_ATTACK]
    silent = decide(_region(3, {}), _RATES, _RULE)
    assert silent.named.tolist() == [NO_ATTACK]
    assert silent.score.tolist() == [-np.inf]
    assert silent.probability[0] < 1e-6


def test_a_fence_contradicts_in_all_directions_and_convicts_no_vehicle() -> None:
    pairs = {(i, j): _NO for i in range(3) for j in range(3) if i != j}
    assert decide(_region(3, pairs), _RATES, _RULE).named[0] < 0


def test_two_victims_of_one_region_are_not_told_apart() -> None:
    # The same ghost in the scans of 0 and 1, which support each other, against 2 and 3.
    pairs = {(0, 1): _YES, (1, 0): _YES}
    pairs |= {(i, k): _NO for i in (0, 1) for k in (2, 3)}
    assert decide(_region(4, pairs), _RATES, _RULE).named.tolist() == [CANNOT_TELL]


@settings(max_examples=200, deadline=None)
@given(
    vehicles=st.integers(3, 5),
    truth=st.integers(0, 2**20 - 1),
    lies=arrays(np.int64, (2, 5, 3), elements=st.integers(0, 40)),
)
def test_a_single_liar_never_convicts_an_honest_vehicle(
    vehicles: int, truth: int, lies: np.ndarray
) -> None:
    # Honest vehicles agree, or see nothing of one another's; vehicle 0 says and claims anything.
    counts = np.zeros((1, vehicles, vehicles, 3), np.int64)
    for bit, pair in enumerate(np.ndindex(vehicles, vehicles)):
        if truth >> bit & 1 and pair[0] != pair[1]:
            counts[0, pair[0], pair[1]] = _YES
    counts[0, 0], counts[0, :, 0] = lies[0, :vehicles], lies[1, :vehicles]
    # Honest witnesses contradict all that it claims, at worst.
    counts[0, 0, 1:, 1] += 30
    assert decide(counts, _RATES, _RULE).named[0] in (0, CANNOT_TELL, NO_ATTACK)


@pytest.mark.parametrize("wrong", [{"alarm": 0.0}, {"certain": 0.3}, {"accuser": -1.0}])
def test_a_rule_that_is_none_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError):
        DecisionRule(**wrong)


@pytest.mark.parametrize("wrong", [{"most": 0.0}, {"least": 0}, {"through_present": 1.0}])
def test_rates_that_are_none_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError):
        RayRates(**wrong)


@pytest.mark.parametrize("calibration", [(0.0, 1.0), (-0.5, 0.0)])
def test_silence_does_not_alarm_whatever_the_calibration(calibration: tuple[float, float]) -> None:
    rule = DecisionRule(calibration=ScoreProbability(*calibration))
    silent = decide(_region(3, {}), _RATES, rule)
    assert silent.probability.tolist() == [0.0]
    assert silent.named.tolist() == [NO_ATTACK]


def test_who_hardly_contradicts_is_no_accuser() -> None:
    # The second witness sees as many rays end there as pass through.
    counts = _region(3, {(1, 0): _NO, (1, 2): (3, 3, 0)})
    weak = float(log_likelihood_ratio([3, 3, 0], _RATES))
    for accuser, named in ((2 * weak, CANNOT_TELL), (weak / 2, 1)):
        rule = DecisionRule(calibration=_RULE.calibration, accuser=accuser, certain=0.5)
        assert decide(counts, _RATES, rule).named.tolist() == [named]
