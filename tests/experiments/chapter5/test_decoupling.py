"""Losses of precision and safety, and whether they go together: known answers, brute force."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.experiments.chapter5.decoupling import RankCorrelation, decoupling, rank_correlation
from avsec_gym.experiments.chapter5.losses import losses, precision, safety
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.metrics.cluster_bootstrap import draw_resamples

CLEAN = Condition("dsgn")
ATTACKS = tuple(
    Condition("dsgn", attack, float(n))
    for attack in ("thesis_pgd-0.4", "thesis_pgd-1")
    for n in (1, 2, 3, 4)
)
NOISE = Condition("dsgn", "noise-1", 4.0)


def taking(made: ModuleType, cars: list[int], episodes: list[int], count: int = 40) -> Outcomes:
    """The n-th attack hides so many cars, and makes so many other scenarios unsafe."""
    results, names = made.MadeResults(), made.names(count)
    results.add(CLEAN, names)
    for condition, hidden, unsafe in zip(ATTACKS, cars, episodes, strict=False):
        results.add(condition, names, lost=names[:hidden], unsafe=names[count - unsafe :])
    # A control that would spoil every correlation, and must not count.
    results.add(NOISE, names, unsafe=names)
    found: Outcomes = made.outcomes(results, names)
    return found


def test_losses_that_rise_together_are_coupled(made: ModuleType) -> None:
    found = taking(made, [4, 8, 12, 16, 20, 24, 28, 32], [4, 8, 12, 16, 20, 24, 28, 32])
    result = decoupling(found)
    assert result.rank_correlation["dsgn"].attacks == 8
    assert result.rank_correlation["dsgn"].rho == pytest.approx(1)
    low, high = result.rank_correlation["dsgn"].interval
    assert 0.9 < low <= result.rank_correlation["dsgn"].rho <= high <= 1 + 1e-9
    assert result.discordant_pairs["dsgn"].discordant == 0
    assert result.discordant_pairs["dsgn"].concordant > 10
    assert [row.counts for row in result.attacks] == [True] * 8 + [False]
    assert result.unattacked[0].safety.value == 100


def test_losses_that_have_nothing_to_do_with_each_other_are_not(made: ModuleType) -> None:
    found = taking(made, [4, 8, 12, 16, 20, 24, 28, 32], [14, 8, 16, 10, 12, 9, 15, 11])
    correlation = decoupling(found).rank_correlation["dsgn"]
    assert abs(correlation.rho) < 0.4
    assert correlation.interval is not None
    assert correlation.interval[0] < 0 < correlation.interval[1]


def test_bootstrap_samples_are_those_of_the_scenarios_drawn(made: ModuleType) -> None:
    found = taking(made, [3, 6, 9, 2], [5, 1, 4, 7], count=12)
    draws = draw_resamples(12, RESAMPLES, 0)
    every = [loss for loss in losses(found) if loss.counts]
    for sample in (0, 17, 400):
        frames = np.repeat(np.arange(12), draws[sample])
        truth = [found.labels[found.scenarios[frame]] for frame in frames]
        lost = []
        for condition in (CLEAN, *ATTACKS[:4]):
            seen = found.detections(condition)
            again = average_precision(truth, [seen[i] for i in frames], classes=("Car",))
            drawn = precision(found, condition).samples[sample]
            assert drawn == pytest.approx(again.value("Car"))
            safe = np.array([record.safe for record in found.records(condition)]).reshape(12, 3)
            rate = safety(found, condition).samples[sample]
            assert rate == pytest.approx(100 * safe[frames].mean())
            lost.append((drawn, rate))
        taken = np.array(lost[0]) - np.array(lost[1:])
        ours = [(loss.precision.samples[sample], loss.safety.samples[sample]) for loss in every]
        np.testing.assert_allclose(ours, taken, atol=1e-9)
    rho = rank_correlation(every).rho
    assert rho == pytest.approx(
        spearmanr([o.precision.value for o in every], [o.safety.value for o in every]).statistic
    )


def test_two_attacks_make_no_correlation(made: ModuleType) -> None:
    result = decoupling(taking(made, [4, 8], [8, 4]))
    assert result.rank_correlation["dsgn"] == RankCorrelation(2, None, None)
    constant = decoupling(taking(made, [4, 8, 12], [0, 0, 0]))
    assert constant.rank_correlation["dsgn"].rho is None
