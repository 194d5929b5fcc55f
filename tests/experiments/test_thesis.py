"""The thesis' figures as typed: m_saf = m_suc (1 - m_cls) tells slips of the pen."""

from __future__ import annotations

from avsec_gym.experiments.thesis import PRECISION, SAFETY
from avsec_gym.scenario.intention import Intention

SLIP = ("dsgn", "thesis_pgd-1-3", Intention.STRAIGHT)


def test_safe_driving_follows_from_success_and_collisions() -> None:
    assert len(SAFETY) == 2 * 11 * 3
    for key, rates in SAFETY.items():
        follows = abs(rates.success * (1 - rates.collision) - rates.safe) < 0.0021
        assert follows == (key != SLIP), key


def test_precision_falls_from_easy_to_hard() -> None:
    for easy, moderate, hard in PRECISION.values():
        assert 1 > easy > moderate > hard > 0
