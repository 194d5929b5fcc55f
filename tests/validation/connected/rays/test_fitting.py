"""Fits give back what data were drawn from."""

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.rays.fitting import (
    LabelledCounts,
    ScoreProbability,
    fit_calibration,
    fit_rates,
)


def _drawn(present: list[float], absent: list[float], seed: int = 0) -> LabelledCounts:
    rng = np.random.default_rng(seed)
    totals = rng.integers(10, 60, 400)
    return LabelledCounts(rng.multinomial(totals, present), rng.multinomial(totals, absent))


def test_rates_are_those_that_rays_were_drawn_with() -> None:
    rates = fit_rates(_drawn([0.9, 0.07, 0.03], [0.1, 0.7, 0.2]))
    assert rates.support_present == pytest.approx(0.9, abs=0.02)
    assert rates.missing_present == pytest.approx(0.03, abs=0.02)
    assert rates.through_absent == pytest.approx(0.7, abs=0.02)


def test_independent_rays_count_in_full_and_rays_that_err_together_do_not() -> None:
    drawn = _drawn([0.6, 0.4, 0.0], [0.4, 0.6, 0.0])
    together = LabelledCounts(
        np.array([[30, 0, 0]] * 60 + [[0, 30, 0]] * 40),
        np.array([[0, 30, 0]] * 60 + [[30, 0, 0]] * 40),
    )
    assert fit_rates(drawn).most == 40.0
    assert fit_rates(together).most == 2.0


def test_nothing_is_fitted_on_a_handful() -> None:
    with pytest.raises(DataError):
        fit_rates(LabelledCounts(np.full((9, 3), 20), np.full((90, 3), 20)))
    with pytest.raises(DataError):
        fit_calibration([1.0, 2.0], [True, True])


def test_a_calibration_gives_probabilities_that_come_true() -> None:
    rng = np.random.default_rng(1)
    scores = rng.normal(0.0, 4.0, 20_000)
    attacked = rng.random(20_000) < ScoreProbability(0.5, -1.0).probability(scores)
    half = scores[:10_000], attacked[:10_000]
    probability = fit_calibration(*half).probability(scores[10_000:])
    for low in np.arange(0.0, 1.0, 0.2):
        chosen = (probability >= low) & (probability < low + 0.2)
        assert attacked[10_000:][chosen].mean() == pytest.approx(
            probability[chosen].mean(), abs=0.05
        )


def test_a_calibration_carries_over_to_another_share_of_attacks() -> None:
    scores, attacked = np.repeat([-1.0, 1.0], 100), np.repeat([False, True], 100)
    even, rare = fit_calibration(scores, attacked), fit_calibration(scores, attacked, prior=0.01)
    assert rare.slope == even.slope
    assert rare.offset - even.offset == pytest.approx(np.log(0.01 / 0.99))
    assert np.isfinite(even.slope)


def test_what_no_calibration_is_fitted_on_is_refused() -> None:
    with pytest.raises(DataError, match="decidable"):
        fit_calibration([0.0, 1.0, -np.inf, 3.0], [False, False, False, True])
    for prior in (0.0, 1.0):
        with pytest.raises(ConfigurationError, match="prior"):
            fit_calibration([0.0, 1.0, 2.0, 3.0], [False, False, True, True], prior)
