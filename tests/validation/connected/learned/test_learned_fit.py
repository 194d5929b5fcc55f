"""The model's file, its alarms, and what refuses to be one."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.fitting import FittedInstants
from avsec_gym.validation.connected.learned.features import FEATURES
from avsec_gym.validation.connected.learned.learned_fit import (
    SHIPPED_MODEL,
    LearnedFit,
    read_learned_fit,
    write_learned_fit,
)
from avsec_gym.validation.connected.learned_fitting import LearnedSamples, fit_of_samples


def _samples(instants: int = 20, lift: float = 2.0) -> LearnedSamples:
    """Ten regions an instant, one of them attacked; the first feature shows it."""
    rng = np.random.default_rng(0)
    attacked = np.tile(np.arange(10) == 9, instants)
    features = rng.normal(0, 1, (10 * instants, len(FEATURES)))
    features[:, 0] += lift * attacked
    return LearnedSamples(features, attacked, np.repeat(np.arange(instants), 10), instants)


@pytest.fixture(scope="module")
def fit() -> LearnedFit:
    return fit_of_samples(_samples(), FittedInstants({"seed": 1}), "fitted on nothing")


def test_a_file_holds_the_fit_with_its_card(fit: LearnedFit, tmp_path: Path) -> None:
    odds = (-np.inf, *fit.clean_log_odds)
    written = replace(fit, clean_log_odds=odds)
    write_learned_fit(tmp_path / "model.json", written)
    assert read_learned_fit(tmp_path / "model.json") == written
    assert fit.card.data == {"seed": 1, "instants": 20}
    assert (fit.card.attacked, fit.card.attack_free) == (20, 180)


def test_held_out_instants_judge_the_model() -> None:
    # Pure noise: a model that was judged on its own samples would seem to know something.
    noise = fit_of_samples(_samples(lift=0.0), FittedInstants(), "")
    assert noise.card.held_out_area == pytest.approx(0.5, abs=0.15)
    samples = _samples(lift=0.0)
    odds = noise.model.log_odds(samples.features)
    own = (odds[samples.attacked][:, None] > odds[~samples.attacked]).mean()
    assert own > noise.card.held_out_area + 0.1
    assert fit_of_samples(_samples(lift=4.0), FittedInstants(), "").card.held_out_area > 0.95


def test_so_many_attack_free_instants_alarm(fit: LearnedFit) -> None:
    odds = np.array(fit.clean_log_odds)
    for alarms, count in ((0.0, 0), (0.1, 2), (0.5, 10)):
        assert (odds > fit.rule(alarms).threshold).sum() == count
    with pytest.raises(ConfigurationError, match="share"):
        fit.rule(1.0)


def test_the_shipped_model_weighs_contradictions() -> None:
    shipped = read_learned_fit(SHIPPED_MODEL)
    assert shipped.card.held_out_area > 0.9
    weight = dict(zip(FEATURES, shipped.model.weights, strict=True))
    assert weight["rays that support, of all pairs"] < 0 < weight["rays through, of all pairs"]
    assert shipped.card.data["assets"] == "train"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "connected_vehicles"}, "is no"),
        ({"features": ["rays"]}, "features"),
        ({"clean_log_odds": ["high"]}, "no number"),
        ({"clean_log_odds": []}, "log odds"),
        ({"card": {}}, "damaged"),
        ({"model": {"centre": [0]}}, "lacks"),
    ],
)
def test_what_is_no_model_is_refused(
    change: dict[str, object], words: str, fit: LearnedFit, tmp_path: Path
) -> None:
    path = tmp_path / "model.json"
    write_learned_fit(path, fit)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(DataError, match=words) as raised:
        read_learned_fit(path)
    assert "--method learned" in str(raised.value)


def test_a_card_with_another_type_is_refused(fit: LearnedFit, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    write_learned_fit(path, fit)
    content = json.loads(path.read_text())
    content["card"]["attacked"] = "many"
    path.write_text(json.dumps(content))
    with pytest.raises(DataError, match="attacked is 'many'"):
        read_learned_fit(path)


def test_too_few_instants_are_refused() -> None:
    with pytest.raises(DataError, match="5 instants or more"):
        fit_of_samples(_samples(4), FittedInstants(), "")
    with pytest.raises(ConfigurationError, match="folds"):
        fit_of_samples(_samples(), FittedInstants(), "", folds=1)
