"""The probability of improvement against hand counts, scipy's U, and simulated players."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from avsec_gym.metrics.probability_of_improvement import probability_of_improvement


def test_it_is_mann_and_whitneys_u_of_each_task_averaged() -> None:
    generator = np.random.default_rng(0)
    trainings = generator.integers(0, 4, (5, 6)) / 4
    other = generator.integers(0, 4, 6) / 4
    per_task = [
        mannwhitneyu(trainings[:, task], other[task : task + 1]).statistic / 5 for task in range(6)
    ]
    found = probability_of_improvement(list(trainings), other)
    assert found.value == pytest.approx(np.mean(per_task))
    low, high = found.interval or (0.0, 0.0)
    assert low < found.value < high


def test_the_interval_holds_trainings_that_differ() -> None:
    """Half of the trainings always win and half never do: tasks alone would show no doubt."""
    ones, zeros, other = np.ones(50), np.zeros(50), np.full(50, 0.5)
    low, high = probability_of_improvement([ones, zeros, ones, zeros], other).interval or (0.0, 0.0)
    assert low <= 0.05
    assert high >= 0.95
    always = probability_of_improvement([ones, ones], other)
    assert (always.value, always.interval) == (1.0, [1.0, 1.0])


def test_tasks_count_once_however_many_trainings_play_them() -> None:
    """Trainings that are copies of one tell no more about the tasks than it does alone."""
    generator = np.random.default_rng(1)
    scores, other = generator.random(20), generator.random(20)
    one = probability_of_improvement([scores], other)
    five = probability_of_improvement([scores] * 5, other)
    assert five.interval == pytest.approx(one.interval)


def test_one_score_alone_has_no_interval() -> None:
    found = probability_of_improvement([np.array([0.5])], np.array([0.5]))
    assert found.value == 0.5
    assert found.interval is None
