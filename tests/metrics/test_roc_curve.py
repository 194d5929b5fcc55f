"""ROC curves against counting, and intervals that widen where cases belong together."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.metrics.roc_curve import ClusteredScores, roc_area, roc_curve, threshold_at


def scores_of(positives: int, negatives: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    # Rounded, so that some are equal.
    return np.round(random.normal(1, 1, positives), 1), np.round(random.normal(0, 1, negatives), 1)


@pytest.mark.parametrize("rate", [0.0, 0.01, 0.29, 0.5, 1.0])
def test_at_most_the_asked_share_of_negatives_exceeds_the_threshold(rate: float) -> None:
    _, negatives = scores_of(0, 100)
    threshold = threshold_at(negatives, rate)
    assert (negatives > threshold).mean() <= rate + 1e-12
    lower = negatives[negatives < threshold]
    if len(lower):  # A lower one would let more pass.
        assert (negatives > lower.max()).mean() > rate


def test_nothing_exceeds_a_threshold_without_negatives() -> None:
    assert threshold_at(np.zeros(0), 0.5) == np.inf
    assert threshold_at(np.array([-np.inf, 1.0]), 1.0) == -np.inf


def test_a_curve_counts_and_its_area_is_that_of_the_pairs() -> None:
    positives, negatives = scores_of(40, 60)
    false, true = roc_curve(positives, negatives)
    assert (false[0], true[0], false[-1], true[-1]) == (0.0, 0.0, 1.0, 1.0)
    threshold = np.unique(np.r_[positives, negatives])[-5]
    assert true[5] == (positives >= threshold).mean()
    assert false[5] == (negatives >= threshold).mean()
    alone = [
        ClusteredScores(each, [*map(str, range(len(each)))]) for each in (positives, negatives)
    ]
    area = roc_area(*alone)
    assert area.value == pytest.approx(np.trapezoid(true, false))
    assert area.value is not None
    assert area.interval is not None
    assert area.interval[0] < area.value < area.interval[1]


def test_what_has_no_score_is_never_taken_for_positive() -> None:
    false, true = roc_curve(np.array([1.0, -np.inf]), np.array([0.0, -np.inf]))
    assert (false[-1], true[-1]) == (0.5, 0.5)


def test_copies_of_cases_add_no_certainty() -> None:
    positives, negatives = scores_of(30, 30)
    names = [*map(str, range(30))]
    once = roc_area(ClusteredScores(positives, names), ClusteredScores(negatives, names))
    nine = roc_area(
        ClusteredScores(np.tile(positives, 9), names * 9),
        ClusteredScores(np.tile(negatives, 9), names * 9),
    )
    assert nine.value == pytest.approx(once.value)
    assert nine.interval == pytest.approx(once.interval)


def test_without_positives_there_is_no_area() -> None:
    nothing, some = ClusteredScores(np.zeros(0), []), ClusteredScores(np.zeros(1), ["a"])
    assert roc_area(nothing, some).value is None
    assert roc_area(some, some).interval is None
