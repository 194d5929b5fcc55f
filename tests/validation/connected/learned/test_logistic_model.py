"""Logistic regression, held against scipy's optimiser on the same data."""

import numpy as np
import pytest
from scipy.optimize import minimize

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.learned.logistic_model import LogisticModel, fit_logistic


def _data(seed: int, overlap: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    attacked = rng.random(300) < 0.2
    features = rng.normal(0, overlap, (300, 4)) + attacked[:, None] * [2.0, -1.0, 0.0, 0.5]
    return features * [1.0, 10.0, 0.1, 100.0] + [0, 5, 0, -300], attacked


@pytest.mark.parametrize("penalty", [0.1, 1.0, 30.0])
def test_the_model_is_that_of_a_general_optimiser(penalty: float) -> None:
    features, attacked = _data(0)
    standard = (features - features.mean(axis=0)) / features.std(axis=0)

    def loss(solution: np.ndarray) -> float:
        odds = standard @ solution[:4] + solution[4]
        of_data = np.log1p(np.exp(-np.abs(odds))) + np.maximum(odds, 0) - attacked * odds
        return float(of_data.sum() + penalty / 2 * (solution[:4] ** 2).sum())

    theirs = minimize(loss, np.zeros(5), method="BFGS", options={"gtol": 1e-6})
    ours = fit_logistic(features, attacked, penalty)
    np.testing.assert_allclose([*ours.weights, ours.offset], theirs.x, atol=2e-4)
    np.testing.assert_allclose(
        ours.log_odds(features), standard @ theirs.x[:4] + theirs.x[4], atol=2e-3
    )


def test_what_a_threshold_separates_has_finite_weights() -> None:
    features, attacked = _data(1, overlap=0.01)
    model = fit_logistic(features, attacked)
    odds = model.log_odds(features)
    assert odds[attacked].min() > 0 > odds[~attacked].max()
    assert np.abs(model.weights).max() < 20


def test_a_feature_that_never_varies_weighs_nothing() -> None:
    features, attacked = _data(2)
    features[:, 2] = 7.0
    assert fit_logistic(features, attacked).weights[2] == pytest.approx(0.0, abs=1e-9)


def test_what_cannot_be_learned_is_refused() -> None:
    features, attacked = _data(3)
    with pytest.raises(DataError, match="attacked and attack-free"):
        fit_logistic(features, np.ones_like(attacked))
    with pytest.raises(ConfigurationError, match="penalty"):
        fit_logistic(features, attacked, penalty=0.0)
    features[0, 0] = np.nan
    with pytest.raises(DataError, match="finite"):
        fit_logistic(features, attacked)
    with pytest.raises(ConfigurationError):
        LogisticModel((0.0,), (0.0,), (1.0,), 0.0)
    with pytest.raises(ConfigurationError):
        LogisticModel((0.0, 1.0), (1.0,), (1.0,), 0.0)
