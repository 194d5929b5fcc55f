"""The measure that works best is named by rule, and with what is known of its limits."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.metrics.estimate import NOTHING, Estimate
from studies.chapter5.best_measure import LIMITS, BestMeasure, best_measure, sentences
from studies.chapter5.case_measures import CONTACT_RECALL, CONTESTED, PLANNING_KL, SUPPORT
from studies.chapter5.telling_flips import FlipRow
from studies.chapter5.telling_measures import ALL_ATTACKS, BOTH, MEASURES, PRECISION, MeasureRow


def measure_row(
    measure: str,
    rho: float | None,
    *,
    detector: str = BOTH,
    family: str = ALL_ATTACKS,
    spread: float = 0.1,
    p: float | None = 0.5,
    more: float = 0.2,
) -> MeasureRow:
    interval = None if rho is None else [rho - spread, rho + spread]
    return MeasureRow(measure, detector, family, 12, rho, interval, Estimate(more), p)


def flip_row(measure: str, area: float | None, *, p: float = 0.5) -> FlipRow:
    interval = None if area is None else [area - 0.05, area + 0.05]
    return FlipRow(measure, BOTH, ALL_ATTACKS, 100, 9, 7, area, interval, NOTHING, p)


ROWS = [measure_row(PRECISION, 0.6, p=None), measure_row(CONTACT_RECALL, 0.85),
        measure_row(CONTESTED, 0.9, p=0.01), measure_row(SUPPORT, 0.4)]  # fmt: skip
FLIPS = [flip_row(PRECISION, 0.5), flip_row(PLANNING_KL, 0.8), flip_row(CONTESTED, 0.7)]


def test_the_highest_over_all_attacks_is_named() -> None:
    found = best_measure(ROWS, FLIPS)
    assert found.over_attacks is not None
    assert (found.over_attacks.measure, found.over_attacks.value) == (CONTESTED, 0.9)
    assert found.over_attacks.surely_more
    assert found.over_attacks.not_surely_worse == [CONTACT_RECALL]
    assert found.in_episodes is not None
    assert (found.in_episodes.measure, found.in_episodes.surely_more) == (PLANNING_KL, False)
    assert found.in_episodes.not_surely_worse == []


def test_families_show_where_it_is_weakest_and_do_not_choose() -> None:
    parts = [
        measure_row(CONTESTED, 0.95, detector="dsgn", family="perturbations"),
        measure_row(CONTESTED, 0.3, detector="stereo_rcnn", family="patches"),
        measure_row(SUPPORT, 1.0, detector="dsgn", family="patches"),
        measure_row(CONTESTED, None, detector="dsgn", family="patches"),
        measure_row(CONTESTED, 0.1, detector=BOTH, family="patches"),
    ]
    found = best_measure([*parts, *ROWS], FLIPS).over_attacks
    assert found is not None
    assert found.measure == CONTESTED
    assert found.weakest == ("stereo_rcnn", "patches", 0.3)


@pytest.mark.parametrize(("p", "more"), [(0.2, 0.2), (None, 0.2), (0.01, -0.2)])
def test_without_a_sure_difference_to_average_precision_none_is_claimed(
    p: float | None, more: float
) -> None:
    rows = [measure_row(PRECISION, 0.6), measure_row(CONTESTED, 0.9, p=p, more=more)]
    found = best_measure(rows, []).over_attacks
    assert found is not None
    assert not found.surely_more


def test_sentences_name_limits_and_the_weighted_recall_only_where_it_is_one() -> None:
    found = best_measure(ROWS, FLIPS)
    text = sentences(found, 28)
    assert text[0] == (
        f"Over attacks of all families, *{CONTESTED}* works best: ρ 0.90 (0.80 to 1.00), surely"
        f" more than {PRECISION}. Not surely worse: {CONTACT_RECALL}."
    )
    assert text[1] == (
        f"In single drives, *{PLANNING_KL}* works best: area 0.80 (0.75 to 0.85), not surely more"
        f" than {PRECISION}."
    )
    assert text[2] == "No measure is best at both."
    assert text[3].endswith(
        "It is the `safety_weighted_recall` of objects that must not be missed."
    )
    assert "safety_weighted_recall" not in text[4]
    assert "28 scenarios" in text[-1]
    neither = best_measure([measure_row(SUPPORT, 0.9)], [flip_row(PLANNING_KL, 0.8)])
    assert "No `safety_weighted_recall` is best at either." in sentences(neither, 28)


def test_average_precision_may_be_the_best() -> None:
    found = best_measure([measure_row(PRECISION, 0.9, p=None), measure_row(SUPPORT, 0.2)], [])
    text = sentences(found, 28)
    assert text[0].startswith(f"Over attacks of all families, *{PRECISION}* works best: ρ 0.90")
    assert "more than" not in text[0]
    assert found.in_episodes is None


@pytest.mark.parametrize("rows", [[], [measure_row(SUPPORT, None)]])
def test_without_anything_to_compare(rows: Sequence[MeasureRow]) -> None:
    found = best_measure(rows, [flip_row(SUPPORT, None)])
    assert found == BestMeasure(None, None)
    assert sentences(found, 3)[0].startswith("No measure can be compared")


def test_every_measure_has_its_limits() -> None:
    assert set(LIMITS) == set(MEASURES)


def test_as_json_and_back() -> None:
    parts = [measure_row(CONTESTED, 0.3, detector="dsgn", family="patches")]
    found = best_measure([*parts, *ROWS], FLIPS)
    assert row_of(BestMeasure, row_json(found)) == found
