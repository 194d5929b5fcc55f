"""Pairs of attacks that surely go with each other or against each other, of many compared."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import pytest
from scipy.stats import norm

from avsec_gym.experiments.chapter5.losses import Losses
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.pairs_of_attacks import discordant_pairs
from avsec_gym.metrics.cluster_bootstrap import Sampled


def attacks(precision: Sequence[float], safety: Sequence[float], spread: float) -> list[Losses]:
    """Attacks that take so much, measured with independent errors of that spread."""
    random = np.random.default_rng(1)

    def measured(value: float) -> Sampled:
        errors = random.normal(size=1000)
        return Sampled(value, value + spread * (errors - errors.mean()) / errors.std(ddof=1))

    return [
        Losses(Condition("dsgn", "thesis_pgd-1", float(n)), measured(taken), measured(lost))
        for n, (taken, lost) in enumerate(zip(precision, safety, strict=True), start=1)
    ]


def test_pairs_that_surely_go_against_each_other_are_found() -> None:
    # The first takes all precision and no safety, the second the other way round.
    result = discordant_pairs(attacks([100, 0, 100], [0, 75, 75], spread=0.5))
    assert (result.pairs, result.concordant, result.discordant, result.undecided) == (3, 0, 1, 2)
    assert result.example is not None
    first, second = result.example
    assert (first.condition.strength, second.condition.strength) == (1, 2)
    assert first.precision_lost.value > second.precision_lost.value
    assert first.safety_lost.value < second.safety_lost.value


def test_the_example_differs_most_of_all_that_are_sure() -> None:
    result = discordant_pairs(attacks([10, 20, 60], [30, 20, 1], spread=0.1))
    assert (result.concordant, result.discordant) == (0, 3)
    assert [row.condition.strength for row in result.example or ()] == [3, 1]


@pytest.mark.parametrize(("spread", "concordant"), [(0.1, 6), (10.0, 0)])
def test_differences_within_the_errors_are_undecided(spread: float, concordant: int) -> None:
    result = discordant_pairs(attacks([1, 2, 3, 4], [1, 2, 3, 4], spread))
    assert (result.concordant, result.discordant) == (concordant, 0)
    assert result.concordant + result.discordant + result.undecided == result.pairs == 6


def test_one_pair_that_is_sure_alone_is_not_sure_among_many() -> None:
    # 2.5 standard errors apart in both; the others all take the same.
    apart = 2.5 * np.sqrt(2)
    alone = discordant_pairs(attacks([0, apart], [apart, 0], spread=1.0))
    many = discordant_pairs(attacks([0, apart, *10 * [5]], [apart, 0, *10 * [5]], spread=1.0))
    assert (alone.discordant, many.discordant) == (1, 0)


def test_attacks_that_all_do_the_same_are_rarely_called_sure() -> None:
    random = np.random.default_rng(0)
    plain = corrected = 0
    for _ in range(200):
        drawn = attacks(*random.normal(size=(2, 8)), spread=1.0)
        result = discordant_pairs(drawn)
        corrected += result.undecided < result.pairs
        plain += any(
            max((a.precision - b.precision).p, (a.safety - b.safety).p) < 0.05
            for a, b in combinations(drawn, 2)
        )
    assert corrected <= 0.05 * 200
    assert plain > 2 * corrected


def test_the_p_value_is_that_of_the_normal_distribution() -> None:
    samples = np.array([1.0, 2.0, 3.0, 4.0, np.nan])
    spread = np.std([1, 2, 3, 4], ddof=1)
    assert Sampled(2.5, samples).p == pytest.approx(2 * norm.sf(2.5 / spread))
    assert Sampled(-2.5, -samples).p == pytest.approx(2 * norm.sf(2.5 / spread))
    assert Sampled(3.0, np.full(9, 3.0)).p == 0
    assert Sampled(0.0, np.zeros(9)).p == 1
    assert np.isnan(Sampled(np.nan, samples).p)
