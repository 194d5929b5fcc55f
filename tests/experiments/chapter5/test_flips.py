"""Flips are episodes that were safe and are not, each with its reason."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.flips import flips, why
from avsec_gym.experiments.chapter5.outcomes import Condition

CLEAN, PGD = Condition("dsgn"), Condition("dsgn", "thesis_pgd-1", 4.0)
NAMES = [f"{number:06d}" for number in range(4)]


def test_only_what_was_safe_can_flip(made: ModuleType) -> None:
    results = made.MadeResults()
    results.add(CLEAN, NAMES, unsafe=NAMES[:2])
    results.add(PGD, NAMES, unsafe=NAMES[1:3], outcome="unplanned")
    rows = flips(made.outcomes(results, NAMES))
    assert [(row.scenario, row.intention, row.outcome) for row in rows] == [
        ("000002", way, "unplanned") for way in ("left", "right", "straight")
    ]
    assert rows[0].condition == PGD
    assert "no way around what it believes" in rows[0].why


def test_an_attack_without_its_unattacked_detector_cannot_flip(made: ModuleType) -> None:
    results = made.MadeResults()
    results.add(PGD, NAMES, unsafe=NAMES)
    assert flips(made.outcomes(results, NAMES)) == []


@pytest.mark.parametrize(
    ("outcome", "reason", "words"),
    [
        ("collision", None, "hits a real object after 1.0 s"),
        ("unplanned", "goal_occupied", "goal occupied for all 2.0 s"),
        ("unplanned", "start_occupied", "something stands on it"),
        ("unplanned", "limit", "finds no plan (limit)"),
    ],
)
def test_every_flip_has_a_reason(
    made: ModuleType, outcome: str, reason: str | None, words: str
) -> None:
    assert words in why(made.record("000000", "left", outcome, reason))
