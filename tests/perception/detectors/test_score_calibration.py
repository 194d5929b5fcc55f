"""Scores as probabilities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import expit, logit

from avsec_gym.errors import DataError
from avsec_gym.perception.detectors.score_calibration import (
    ScoreCalibration,
    fit_score_calibration,
)
from avsec_gym.perception.weights.model_card import ModelCard


def test_a_bent_scale_is_straightened() -> None:
    """Boxes are real as often as a hidden line says; afterwards the scores say so."""
    randomness = np.random.default_rng(0)
    scores = randomness.uniform(0.05, 0.6, 20_000)
    real = randomness.random(20_000) < expit(2.5 * logit(scores) + 1.2)
    line = fit_score_calibration(scores, real.astype(float), (~real).astype(float))
    assert line.slope == pytest.approx(2.5, abs=0.1)
    assert line.offset == pytest.approx(1.2, abs=0.1)
    after = line(scores)
    assert (np.argsort(after) == np.argsort(scores)).all()
    for low, high in ((0.0, 0.2), (0.2, 0.4), (0.4, 0.8)):
        some = (after >= low) & (after < high)
        assert real[some].mean() == pytest.approx(after[some].mean(), abs=0.03)


def test_what_else_is_known_counts_by_what_it_tells() -> None:
    randomness = np.random.default_rng(1)
    scores = randomness.uniform(0.05, 0.9, 20_000)
    evidence = randomness.normal(size=(20_000, 2))
    real = randomness.random(20_000) < expit(logit(scores) + 2.0 * evidence[:, 0] - 0.5)
    found = fit_score_calibration(scores, real.astype(float), (~real).astype(float), evidence)
    assert found.evidence == pytest.approx((2.0, 0.0), abs=0.1)
    after = found(scores, evidence)
    for low, high in ((0.0, 0.3), (0.3, 0.7), (0.7, 1.0)):
        some = (after >= low) & (after < high)
        assert real[some].mean() == pytest.approx(after[some].mean(), abs=0.03)


def test_counts_weigh_as_boxes_do() -> None:
    scores = np.array([0.2, 0.2, 0.5, 0.5, 0.5])
    right = np.array([0.0, 1, 1, 1, 0])
    grouped = fit_score_calibration(np.array([0.2, 0.5]), np.array([1.0, 2]), np.array([1.0, 1]))
    one_by_one = fit_score_calibration(scores, right, 1 - right)
    assert grouped.slope == pytest.approx(one_by_one.slope, rel=1e-3)


def test_without_a_card_scores_stay() -> None:
    scores = np.array([0.0, 0.3, 1.0])
    assert ScoreCalibration.of_card(None)(scores) is scores
    assert ScoreCalibration.of_card(ModelCard("dsgn"))(scores) is scores
    card = ModelCard("dsgn", beside={"score_calibration": [1.0, 1.0]})
    assert ScoreCalibration.of_card(card)(scores)[1] == pytest.approx(expit(logit(0.3) + 1))


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [([0, 0], [1, 1], "0 are right"), ([1, 1], [0, 0], "0 wrong"), ([9, 0], [0, 9], "less often")],
)
def test_what_cannot_be_calibrated(right: list[float], wrong: list[float], says: str) -> None:
    with pytest.raises(DataError, match=says):
        fit_score_calibration(np.array([0.2, 0.8]), np.array(right), np.array(wrong))
