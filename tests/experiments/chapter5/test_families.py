"""Families of attacks with known exchange rates: they come out, with paired intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from types import ModuleType

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.experiments.chapter5.decoupling import decoupling
from avsec_gym.experiments.chapter5.families import (
    ALL_FAMILIES,
    FamilyFigures,
    exchange_rate,
    family_figures,
    figures_of,
    rates_differ,
)
from avsec_gym.experiments.chapter5.losses import Losses, losses
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import FAMILIES
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.metrics.cluster_bootstrap import Sampled, draw_resamples

NAMES = [("thesis_pgd-1", float(n)) for n in (1, 2, 3, 4)] + [
    ("patch-random", 0.0), ("patch-specific", 0.0), ("joint-random", 0.0),
]  # fmt: skip
PRECISION = [10.0, 20.0, 30.0, 40.0, 10.0, 16.0, 22.0]
RATES = [0.1] * 4 + [0.25] * 3


def made_losses(
    precision: Sequence[float] = PRECISION,
    rates: Sequence[float] = RATES,
    *,
    common: float = 0.0,
    own: float = 0.0,
    detector: str = "dsgn",
) -> list[Losses]:
    """Attacks of two families that cost so much; draws vary in common, and each by itself."""
    random = np.random.default_rng(3)
    shared = 1 + common * random.normal(size=2000)

    def drawn(value: float) -> Sampled:
        return Sampled(value, value * shared + own * random.normal(size=2000))

    return [
        Losses(Condition(detector, *name), drawn(taken), drawn(rate * taken))
        for name, taken, rate in zip(NAMES, precision, rates, strict=True)
    ]


def test_known_exchange_rates_and_their_ratio() -> None:
    found = figures_of(made_losses(own=0.4))
    rates = {row.family: row.exchange_rate for row in found.rows}
    assert list(rates) == [ALL_FAMILIES, "perturbations", "patches"]
    assert rates["perturbations"].value == pytest.approx(0.1)
    assert rates["patches"].value == pytest.approx(0.25)
    assert rates[ALL_FAMILIES].value == pytest.approx((10 + 12) / 148)
    for rate in rates.values():
        assert rate.interval is not None
        assert rate.interval[0] < rate.value < rate.interval[1]
    (between,) = found.compared
    assert (between.first, between.second) == ("patches", "perturbations")
    assert between.ratio.value == pytest.approx(2.5)
    assert between.difference.value == pytest.approx(0.15)
    assert between.p_holm is not None
    assert between.p_holm < 1e-6


def test_intervals_are_those_of_ratios_in_the_same_draws() -> None:
    attacks = made_losses(own=0.5)
    perturbations, patches = attacks[:4], attacks[4:]

    def drawn(group: Sequence[Losses]) -> np.ndarray:
        return np.array(
            [
                sum(attack.safety.samples[r] for attack in group)
                / sum(attack.precision.samples[r] for attack in group)
                for r in range(2000)
            ]
        )

    (between,) = figures_of(attacks).compared
    expected = np.quantile(drawn(patches) / drawn(perturbations), [0.025, 0.975])
    np.testing.assert_allclose(between.ratio.interval, expected)
    difference = np.quantile(drawn(patches) - drawn(perturbations), [0.025, 0.975])
    np.testing.assert_allclose(between.difference.interval, difference)


def test_what_varies_in_common_leaves_the_rate_as_it_is() -> None:
    """Pairing: were precision and safety drawn apart, these rates would be wide."""
    found = figures_of(made_losses(common=0.1))
    for row in found.rows:
        assert row.exchange_rate.interval == pytest.approx([row.exchange_rate.value] * 2)
        assert row.precision_lost.interval[1] - row.precision_lost.interval[0] > 4
    assert found.compared[0].ratio.interval == pytest.approx([2.5, 2.5])


def test_equal_rates_are_not_called_different() -> None:
    (between,) = figures_of(made_losses(rates=[0.2] * 7, own=2.0)).compared
    assert between.p_holm is not None
    assert between.p_holm > 0.5
    assert between.ratio.interval[0] < 1 < between.ratio.interval[1]
    # Not equal, but by less than the draws can tell; the same difference is sure in narrow ones.
    nearly = [0.2] * 4 + [0.23] * 3
    assert figures_of(made_losses(rates=nearly, own=4.0)).compared[0].p_holm > 0.1
    assert figures_of(made_losses(rates=nearly, own=0.1)).compared[0].p_holm < 1e-6


def test_a_divisor_near_zero_does_not_hide_that_rates_differ() -> None:
    """The ratio itself runs away in some draws, and its spread with it."""
    attacks = made_losses(precision=[10, 20, 30, 40, 2.0, 2.1, 2.2], rates=[0.07] * 4 + [0.7] * 3)
    random = np.random.default_rng(5)
    near = 1 + 0.45 * random.normal(size=2000)
    patches = [
        Losses(each.condition, Sampled(each.precision.value, each.precision.value * near),
               Sampled(each.safety.value, each.safety.value + 0.3 * random.normal(size=2000)))
        for each in attacks[4:]
    ]  # fmt: skip
    (between,) = figures_of([*attacks[:4], *patches]).compared
    assert between.difference.interval[0] > 0
    assert between.p_holm < 0.001


@pytest.mark.parametrize(("precision", "most"), [((20.0, 10.0), 0.09), ((10.2, 2.1), 0.15)])
def test_equal_rates_are_called_different_as_rarely_as_the_level_says(
    precision: tuple[float, float], most: float
) -> None:
    """Losses of scenes are drawn, their sums bootstrapped: the whole way of a run, 200 times.

    In the second case one family turns four episodes of 1,800 in all: so few are called different
    twice as often as they should be.
    """
    random = np.random.default_rng(11)
    called, scenes, runs = 0, 600, 200
    for _ in range(runs):
        # A scene that is hard under one attack is so under the other; safety is lost in few.
        common = random.gamma(1.0, 1.0, scenes)
        lost = [mean * common * random.gamma(4.0, 0.25, scenes) for mean in precision]
        unsafe = [100 / 3 * random.binomial(3, np.minimum(0.001 * each, 1.0)) for each in lost]
        drawn = random.multinomial(scenes, np.full(scenes, 1 / scenes), 300) / scenes
        groups = [
            [
                Losses(
                    Condition("dsgn", "patch-random"),
                    Sampled(taken.mean(), drawn @ taken),
                    Sampled(cost.mean(), drawn @ cost),
                )
            ]
            for taken, cost in zip(lost, unsafe, strict=True)
        ]
        called += rates_differ(*groups).p < 0.05
    assert called < most * runs


def test_nothing_is_exchanged_where_no_precision_is_surely_lost() -> None:
    attacks = made_losses(precision=[10, 20, 30, 40, 0.1, -0.2, 0.3], own=1.0)
    assert exchange_rate(attacks[4:]) is None
    found = figures_of(attacks)
    patches = next(row for row in found.rows if row.family == "patches")
    assert patches.exchange_rate.value is None
    assert patches.safety_lost.value is not None
    (between,) = found.compared
    assert (between.ratio.value, between.difference.value, between.p_holm) == (None, None, None)


def test_a_correlation_over_all_attacks_may_hide_the_families() -> None:
    rates = [0.1] * 4 + [1.0] * 3
    found = figures_of(made_losses(precision=[31, 32, 33, 34, 4, 5, 6], rates=rates, own=0.01))
    rho = {row.family: row.correlation.rho for row in found.rows}
    assert rho["perturbations"] == pytest.approx(1)
    assert rho["patches"] == pytest.approx(1)
    taken = [31, 32, 33, 34, 4, 5, 6]
    lost = [3.1, 3.2, 3.3, 3.4, 4, 5, 6]
    assert rho[ALL_FAMILIES] == pytest.approx(spearmanr(taken, lost).statistic)
    assert rho[ALL_FAMILIES] < 0


def test_pairs_by_brute_force() -> None:
    attacks = made_losses(rates=[0.1, 0.1, 0.02, 0.1, 1.0, 0.3, 0.01], own=0.7)
    found = figures_of(attacks)
    # Holm's correction for all 21 pairs by its definition: the smallest first, until one fails.
    pairs = list(combinations(range(7), 2))
    p = {
        (i, j): max(
            (attacks[i].precision - attacks[j].precision).p,
            (attacks[i].safety - attacks[j].safety).p,
        )
        for i, j in pairs
    }
    sure = set()
    for number, pair in enumerate(sorted(pairs, key=lambda pair: p[pair])):
        if p[pair] * (21 - number) > 0.05:
            break
        sure.add(pair)

    def counted(chosen: list[tuple[int, int]]) -> tuple[int, int, int]:
        signs = [
            (attacks[i].precision.value - attacks[j].precision.value)
            * (attacks[i].safety.value - attacks[j].safety.value)
            for i, j in chosen
            if (i, j) in sure
        ]
        with_it = sum(sign > 0 for sign in signs)
        return with_it, len(signs) - with_it, len(chosen) - len(signs)

    expected = {
        ALL_FAMILIES: pairs,
        "perturbations": [pair for pair in pairs if max(pair) < 4],
        "patches": [pair for pair in pairs if min(pair) >= 4],
    }
    for row in found.rows:
        counts = (row.pairs.concordant, row.pairs.discordant, row.pairs.undecided)
        assert counts == counted(expected[row.family]), row.family
    (between,) = found.compared
    counts = (between.pairs.concordant, between.pairs.discordant, between.pairs.undecided)
    assert counts == counted([pair for pair in pairs if min(pair) < 4 <= max(pair)])
    assert found.rows[0].pairs.discordant > 0
    assert found.rows[0].pairs.concordant > 0


def test_comparisons_of_several_detectors_are_corrected_together() -> None:
    one = made_losses(own=2.0)
    alone = figures_of(one).compared[0].p_holm
    both = figures_of([*one, *made_losses(own=2.0, detector="stereo_rcnn")]).compared
    assert [row.detector for row in both] == ["dsgn", "stereo_rcnn"]
    assert alone is not None
    assert both[0].p_holm == pytest.approx(min(2 * alone, 1))


def test_rates_of_a_run_are_those_of_its_scenarios_drawn_anew(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(20)
    clean, attacks = Condition("dsgn"), [Condition("dsgn", *name) for name in NAMES]
    results.add(clean, names)
    for condition, hidden, unsafe in zip(
        attacks, (4, 6, 8, 10, 6, 9, 12), (1, 2, 3, 4, 5, 6, 7), strict=True
    ):
        results.add(condition, names, lost=names[:hidden], unsafe=names[20 - unsafe :])
    outcomes = made.outcomes(results, names)
    found = family_figures(outcomes)
    rows = {row.family: row for row in found.rows}
    assert rows[ALL_FAMILIES].correlation == decoupling(outcomes).rank_correlation["dsgn"]
    draws = draw_resamples(20, RESAMPLES, 0)
    of_attacks = [loss for loss in losses(outcomes) if loss.counts]
    for family, group in (("perturbations", of_attacks[:4]), ("patches", of_attacks[4:])):
        rate = exchange_rate(group)
        assert rate is not None
        assert rows[family].exchange_rate == rate.estimate
        for sample in (0, 11, 500):
            # Scenarios are drawn, each with all its attacks and intentions, and judged anew.
            frames = np.repeat(np.arange(20), draws[sample])
            taken = {
                condition: drawn_anew(outcomes, condition, frames)
                for condition in (clean, *(attack.condition for attack in group))
            }
            precision, safety = np.sum(
                [taken[clean] - taken[attack.condition] for attack in group], axis=0
            )
            assert rate.samples[sample] == pytest.approx(safety / precision)
    again = row_of(FamilyFigures, row_json(found))
    assert again.rows[1].exchange_rate.value == rows["perturbations"].exchange_rate.value
    assert again.rows[1].correlation == rows["perturbations"].correlation


def drawn_anew(outcomes: Outcomes, condition: Condition, frames: np.ndarray) -> np.ndarray:
    """Average precision and safe driving of drawn scenarios, percent."""
    truth = [outcomes.labels[outcomes.scenarios[frame]] for frame in frames]
    found = []
    for look in outcomes.looks(condition):
        seen = outcomes.detections(condition, look)
        again = average_precision(truth, [seen[frame] for frame in frames], classes=("Car",))
        found.append(again.value("Car"))
    safe = np.array([record.safe for record in outcomes.records(condition)]).reshape(20, 3)
    return np.array([np.mean(found), 100 * safe[frames].mean()])


def test_no_attack_belongs_to_two_families() -> None:
    names = [name for attacks in FAMILIES.values() for name in attacks]
    assert len(names) == len(set(names))
