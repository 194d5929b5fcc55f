"""Decoding by likelihood, against scipy's density, all states one by one, and algorithm 2."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import approx_fprime, minimize
from scipy.stats import beta

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.evidence import evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood import likelihood_fit
from avsec_gym.validation.likelihood.likelihood_fit import LikelihoodSamples, fit_likelihood
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import (
    LikelihoodModel,
    read_likelihood_model,
)
from avsec_gym.validation.likelihood.normal_scores import log_odds
from avsec_gym.validation.likelihood.score_densities import (
    LEAST_SCORE,
    SCORES,
    STEP,
    element_patterns,
)
from avsec_gym.validation.state_posterior import (
    SensorStatus,
    attack_prior,
    brier_score,
    reliability,
    state_indices,
    state_vectors,
)
from avsec_gym.validation.thresholds import ThresholdTable

MadeUp = Callable[..., Any]


def fitted_on(n: int) -> FittedOn:
    system = SensorSystem((LIDAR, *range(n)))
    return FittedOn(system, {"name": "sgbm"}, (384.0,) * (n - 1), {"seed": 0})


GRID = LEAST_SCORE + STEP * np.arange(SCORES)


def model_of(n: int, shift: Floats, deviation: float = 0.3) -> LikelihoodModel:
    """Scenes that are hard or easy for all elements alike.

    Args:
        n: Cameras.
        shift: Of the triples' log-odds under the eight patterns; pairs say nothing.
        deviation: Of the shifts.
    """
    on = fitted_on(n)
    triples, m = len(on.system.triples), len(evidence_scopes(on.system))
    shifts = np.zeros((m, 8))
    shifts[:triples] = shift
    spread = np.where(shifts != 0, np.hypot(0.5, deviation), 0.5)
    log_density = stats.norm.logpdf(GRID, (shifts - 2.5)[..., None], spread[..., None])
    return LikelihoodModel(
        on,
        np.maximum(log_density, -50.0),
        correlation=np.full((2, 2, m, m), 0.8) + 0.2 * np.eye(m),
        lowest=np.full(m, -6.0),
        highest=np.full(m, 4.0),
        weights=np.ones(m + 1),
        clean_scores=np.array([-5.0, -4.0, -3.0]),
        strangest=np.full(3, 1e9),
    )


OR = 3.0 * (np.arange(8) > 0)
ELEMENTS = len(evidence_scopes(fitted_on(3).system))
"""Any attacked sensor spoils a triple all the same: the thesis' finding."""


def by_hand(model: LikelihoodModel, evidence: Floats, prior: Floats) -> Floats:
    """The posterior by scipy's densities, one state and one element after the other."""
    scopes = evidence_scopes(model.on.system)
    posterior = []
    for index, state in enumerate(product((0, 1), repeat=len(model.on.system))):
        # Bit i of the index is s_i.
        state = tuple(index >> i & 1 for i in range(len(state)))
        patterns = [sum(state[s] << bit for bit, s in enumerate(scope)) for scope in scopes]
        density, z = [], []
        for element, pattern in enumerate(patterns):
            u = np.log(evidence[element] / (1 - evidence[element]))
            known = model.log_density[element, pattern]
            density.append(np.interp(u, GRID, known))
            chance = np.exp(known) / np.exp(known).sum()
            below = np.clip(chance.cumsum() - chance / 2, 1e-9, 1 - 1e-9)
            z.append(np.interp(u, GRID, stats.norm.ppf(below)))
        touched = [int(pattern > 0) for pattern in patterns]
        correlation = np.array(
            [
                [model.correlation[triple, other, a, b] for b, other in enumerate(touched)]
                for a, triple in enumerate(touched)
            ]
        )
        copula = stats.multivariate_normal(cov=correlation).logpdf(z) - stats.norm.logpdf(z).sum()
        terms = np.array([*density, np.clip(copula, -60, 60)])
        posterior.append(np.log(prior[index]) + model.weights @ terms + model.offset * sum(state))
    weights = np.exp(np.array(posterior) - max(posterior))
    return weights / weights.sum()


@pytest.mark.parametrize("n", [3, 4, 5, 6, pytest.param(7, marks=pytest.mark.slow)])
def test_the_posterior_is_that_of_the_densities(n: int) -> None:
    rng = np.random.default_rng(n)
    model = model_of(n, rng.uniform(0, 2, 8) * (np.arange(8) > 0))
    model = replace(model, weights=rng.uniform(0, 1, len(model.weights)), offset=0.3)
    evidence = rng.uniform(0.01, 0.6, (5 if n < 5 else 1, len(model.log_density)))
    prior = rng.dirichlet(np.ones(2 ** (n + 1)))
    found = model.posterior(evidence, prior)
    expected = [by_hand(model, of_frame, prior) for of_frame in evidence]
    np.testing.assert_allclose(found.probabilities, expected, rtol=1e-6, atol=1e-12)
    marginal = [
        sum(p for index, p in enumerate(of_frame) if index >> 1 & 1)
        for of_frame in found.probabilities
    ]
    np.testing.assert_allclose(found.sensors[:, 1], marginal)


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_every_attack_within_the_limit_is_decoded(n: int) -> None:
    """And beyond it, all that the sensors cannot tell apart stays as probable as it was before."""
    model = model_of(n, OR, deviation=0.1)
    states = state_vectors(n + 1)
    triples = model.on.system.triples
    seen = np.array([[bool(state[list(t)].any()) for t in triples] for state in states])
    u = np.full((len(states), len(model.log_density)), -2.5)
    u[:, : len(triples)] += 3.0 * seen
    prior = attack_prior(n + 1, 0.3)
    found = model.decode(1 / (1 + np.exp(-u)), prior=prior)
    few = states.sum(axis=1) <= n - 2
    np.testing.assert_array_equal(found.states[few], states[few])
    assert found.posterior.probabilities[few, np.flatnonzero(few)].min() > 0.99
    # Fewer than three sound sensors: no triple is consistent, whichever they are.
    alike = np.where(few, 0.0, prior) / prior[~few].sum()
    for of_frame in found.posterior.probabilities[~few]:
        np.testing.assert_allclose(of_frame, alike, atol=1e-3)


def test_what_cannot_be_told_is_not_told() -> None:
    model = model_of(3, OR, deviation=0.1)
    u = np.full((3, len(model.log_density)), -2.5)
    u[1, [0, 1, 3]] += 3.0
    u[2, :4] += 3.0
    sound, second, all_spoilt = model.decode(1 / (1 + np.exp(-u))).statuses()
    assert sound == [SensorStatus.SOUND] * 4
    assert second == [
        SensorStatus.SOUND,
        SensorStatus.ATTACKED,
        SensorStatus.SOUND,
        SensorStatus.SOUND,
    ]
    assert all_spoilt == [SensorStatus.CANNOT_TELL] * 4
    strange = replace(model, strangest=np.full(3, 0.5)).decode(
        1 / (1 + np.exp(-u - np.resize([2, -2], u.shape[1])))
    )
    assert not strange.familiar.any()
    assert strange.alarms.all()
    assert strange.statuses() == [[SensorStatus.CANNOT_TELL] * 4] * 3


def test_a_blind_triple_has_no_say() -> None:
    model = model_of(3, OR)
    blind = replace(
        model,
        log_density=np.r_[model.log_density[:1, :1].repeat(8, axis=1), model.log_density[1:]],
        correlation=np.broadcast_to(np.eye(ELEMENTS), model.correlation.shape),
    )
    evidence = np.full((2, ELEMENTS), 0.08)
    evidence[1, 0] = 0.15
    assert (blind.posterior(evidence).sensors < 0.02).all()
    assert not blind.decode(evidence, rate=0.0).states.any()
    # The same from a triple that sees.
    evidence[1, 1] = 0.5
    assert (blind.posterior(evidence).sensors[1] > 0.02).any()


def test_far_beyond_all_that_was_seen_nothing_turns_over() -> None:
    model = model_of(3, OR)
    evidence = np.full((4, ELEMENTS), 0.08)
    evidence[1:, [0, 1, 3]] = [[0.7], [0.99], [1.0]]
    sensors = model.posterior(evidence).sensors
    assert (sensors[0] < 0.05).all()
    assert (sensors[1:, 1] > 0.9).all()
    assert np.isfinite(model.alarm_scores(np.array([np.zeros(ELEMENTS), np.ones(ELEMENTS)]))).all()


def test_sensors_are_attacked_independently_of_each_other() -> None:
    prior = attack_prior(5, 0.2, beyond=1)
    assert prior.sum() == pytest.approx(1)
    assert prior[1] / prior[0] == pytest.approx(0.25)
    np.testing.assert_allclose(prior @ state_vectors(5), 0.2)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_more_than_can_be_identified_are_rarer_still(n: int) -> None:
    count = state_vectors(n + 1).sum(axis=1)
    prior, independent = attack_prior(n + 1, 0.2, 0.03), attack_prior(n + 1, 0.2, 1)
    rarer = prior / prior[0] / (independent / independent[0])
    # Of three sensors none can be identified, and yet one is no more than the thesis expects.
    np.testing.assert_allclose(rarer, np.where(count > max(n - 2, 1), 0.03, 1))
    for wrong in (0.0, 1.5):
        with pytest.raises(ConfigurationError, match="rarer"):
            attack_prior(n + 1, 0.2, wrong)


@pytest.fixture(scope="module")
def judged(made_up: MadeUp) -> tuple[LikelihoodModel, Any, Any]:
    """A model of 100 frames, and 100 others, each in all states."""
    on = fitted_on(3)
    states = np.broadcast_to(state_vectors(4), (100, 16, 4))
    fit = made_up(on.system, states, seed=1, damage=0.3)
    samples = LikelihoodSamples(fit.evidence, fit.states, fit.frames)
    return fit_likelihood(on, samples), fit, made_up(on.system, states, seed=2, damage=0.3)


def test_it_tells_more_than_algorithm_2(judged: tuple[LikelihoodModel, Any, Any]) -> None:
    model, fit, others = judged
    triples = model.on.system.triples
    clean = fit.evidence[~fit.states.any(axis=1)][:, : len(triples)]
    shares = np.zeros((*clean.shape, len(MEASURES)))
    shares[..., MEASURES.index("error")] = clean
    thresholds = ThresholdTable(model.on, shares).thresholds(0.01, "error")
    one_attacked = others.states.sum(axis=1) == 1
    by_thresholds = []
    for evidence, state in zip(
        others.evidence[one_attacked], others.states[one_attacked], strict=True
    ):
        exceeded = {
            t: e > thresholds[t].error
            for t, e in zip(triples, evidence[: len(triples)], strict=True)
        }
        found = identify_attacked_sensors(exceeded.__getitem__, 4)
        by_thresholds.append(set(found.attacked) == set(np.flatnonzero(state)))
    decoded = model.decode(others.evidence, rate=0.01)
    right = (decoded.states == others.states).all(axis=1)
    assert right[one_attacked].mean() > 0.85
    assert right[one_attacked].mean() > np.mean(by_thresholds) + 0.3
    false_alarms = decoded.alarms[~others.states.any(axis=1)].mean()
    assert false_alarms <= 0.03
    assert decoded.familiar.mean() > 0.99


def test_its_probabilities_are_honest(judged: tuple[LikelihoodModel, Any, Any]) -> None:
    model, _, others = judged
    posterior = model.posterior(others.evidence)
    # As often as is expected of each state.
    truth = state_indices(others.states)
    weights = attack_prior(4)[truth] / np.bincount(truth)[truth]
    mean, share, sensors, independent = reliability(posterior, others.states, weights).T
    assert (np.abs(mean - share) < 3 * np.sqrt(mean * (1 - mean) / independent) + 0.01).all()
    assert np.average(np.abs(mean - share), weights=sensors) < 0.01
    assert brier_score(posterior, others.states, weights) < 0.02
    certain = posterior.probabilities.max(axis=1)
    exact = posterior.probabilities.argmax(axis=1) == truth
    assert certain @ weights == pytest.approx(exact @ weights, abs=0.03)


def test_the_offset_makes_the_true_states_of_other_frames_most_probable(
    judged: tuple[LikelihoodModel, Any, Any],
) -> None:
    model, _, others = judged
    truth = state_indices(others.states)
    weights = attack_prior(4)[truth] / np.bincount(truth)[truth]

    def log_probability(offset: float) -> float:
        probabilities = replace(model, offset=offset).posterior(others.evidence).probabilities
        return float(weights @ np.log(probabilities[np.arange(len(truth)), truth]))

    least, fitted, most = (log_probability(model.offset + more) for more in (-1.0, 0.0, 1.0))
    assert fitted > max(least, most)


def test_what_weights_are_chosen_by_has_the_slope_that_it_reports(
    made_up: MadeUp, monkeypatch: pytest.MonkeyPatch
) -> None:
    on, surprises = fitted_on(3), []

    def kept(surprise: Any, begin: Floats, **how: Any) -> Any:
        surprises.append((surprise, begin))
        return minimize(surprise, begin, **how)

    monkeypatch.setattr(likelihood_fit.optimize, "minimize", kept)
    states = np.broadcast_to(state_vectors(4), (30, 16, 4))
    fit = made_up(on.system, states, seed=1, damage=0.3)
    fit_likelihood(on, LikelihoodSamples(fit.evidence, fit.states, fit.frames))
    [(surprise, begin)] = surprises
    for weights in (begin + 0.3, 0.5 * begin - 0.1):
        slope = approx_fprime(weights, lambda each: surprise(each)[0], 1e-6)
        np.testing.assert_allclose(surprise(weights)[1], slope, rtol=1e-3, atol=1e-5)


def test_a_density_leaves_little_to_what_no_sample_shows(
    judged: tuple[LikelihoodModel, Any, Any],
) -> None:
    """The share `_UNSEEN`, 2 %, of a wide normal distribution, most of which lies elsewhere."""
    model, fit, _ = judged
    assert model.scale is not None
    scores = model.scale(fit.evidence)
    scopes = evidence_scopes(model.on.system)
    patterns = element_patterns(fit.states, scopes)
    grid = LEAST_SCORE + STEP * np.arange(SCORES)
    for element, scope in enumerate(scopes):
        for pattern in range(1, 2 ** len(scope)):
            seen = scores[patterns[:, element] == pattern, element]
            mass = np.exp(model.log_density[element, pattern]) * STEP
            outside = (grid < seen.min() - 1) | (grid > seen.max() + 1)
            assert mass.sum() == pytest.approx(1, abs=1e-3)
            assert 0.0005 < mass[outside].sum() < 0.01


def test_the_false_alarm_rate_is_that_of_frames_held_out(
    judged: tuple[LikelihoodModel, Any, Any],
) -> None:
    model, _, others = judged
    clean = others.evidence[~others.states.any(axis=1)]
    assert len(model.clean_scores) == 100
    rates = [model.decode(clean, rate).alarms.mean() for rate in (0.0, 0.1, 0.5, 1.0)]
    # Of 100 and 100 frames, two standard errors.
    assert rates[0] <= 0.05
    assert rates[1] == pytest.approx(0.1, abs=0.085)
    assert rates[2] == pytest.approx(0.5, abs=0.15)
    assert rates[3] == 1.0
    with pytest.raises(ConfigurationError, match="rate from 0 to 1"):
        model.decode(clean, 1.5)


def test_a_rate_that_too_few_clean_frames_can_show_is_remarked(
    judged: tuple[LikelihoodModel, Any, Any],
) -> None:
    model, _, _ = judged
    for shown in (0.0, 0.01, 0.5):
        assert LikelihoodValidator(model, shown).remark == ""
    rare = LikelihoodValidator(model, 0.004).remark
    assert "of 100 clean frames" in rare
    assert rare.endswith("it takes 250")


@pytest.mark.parametrize(("rate", "above"), [(0.0, 0), (0.05, 5), (0.2, 20)])
def test_a_model_vouches_for_what_its_clean_frames_can_show(
    judged: tuple[LikelihoodModel, Any, Any], rate: float, above: int
) -> None:
    model, _, _ = judged
    expected = beta.ppf(0.95, above + 1, 100 - above)
    assert model.vouched_rate(rate) == pytest.approx(expected)
    said = LikelihoodValidator(model, rate).vouched
    assert said.startswith("100 clean frames")
    assert f"of {expected:.2g} at most" in said


def test_strange_frames_are_a_part_of_the_false_alarms(
    judged: tuple[LikelihoodModel, Any, Any],
) -> None:
    model, _, others = judged
    clean = others.evidence[~others.states.any(axis=1)]
    own = replace(model, clean_scores=model.alarm_scores(clean), strangest=model.strangeness(clean))
    for rate in (0.0, 0.05, 0.2, 0.5, 1.0):
        found = own.decode(clean, rate)
        assert found.alarms.mean() == pytest.approx(rate)
        assert (~found.familiar).mean() == pytest.approx(rate / 5)
        assert found.alarms[~found.familiar].all()


def test_one_outlier_does_not_make_everything_familiar() -> None:
    model = model_of(3, OR)
    strange = np.resize([0.03, 0.2], (1, ELEMENTS))
    many = replace(
        model, clean_scores=np.linspace(-9.0, -3.0, 1000), strangest=np.r_[np.ones(999), 1e6]
    )
    found = many.decode(strange)
    assert not found.familiar.any()
    assert found.alarms.all()
    assert found.statuses() == [[SensorStatus.CANNOT_TELL] * 4]
    few = replace(many, clean_scores=many.clean_scores[-9:], strangest=many.strangest[-9:])
    assert few.decode(strange).familiar.all()


@pytest.mark.slow
def test_false_alarms_on_new_drives_are_those_of_drives_that_were_held_out(
    made_up: MadeUp,
) -> None:
    """A drive's frames are near twins: a fold that divides it knows what it is to be judged by."""
    on, drives, each = fitted_on(3), 30, 5
    states = np.broadcast_to(state_vectors(4), (drives, 16, 4))
    scenes = made_up(on.system, states, seed=1, damage=0.3)
    twins = np.repeat(log_odds(scenes.evidence).reshape(drives, -1), each, axis=0)
    twins += np.random.default_rng(0).normal(0.0, 0.03, twins.shape)
    evidence = (1 / (1 + np.exp(-twins))).reshape(drives * each * 16, -1)
    frames = np.repeat(np.arange(drives * each), 16)
    shown = np.tile(state_vectors(4), (drives * each, 1))
    new = made_up(on.system, np.zeros((2000, 1, 4), bool), seed=3).evidence
    by_drive, by_frame = (
        fit_likelihood(on, LikelihoodSamples(evidence, shown, frames, whose))
        .decode(new, rate=0.1)
        .alarms.mean()
        for whose in (frames // each, None)
    )
    # Three standard errors of a tenth of thirty drives.
    assert by_drive < 0.1 + 3 * np.sqrt(0.1 * 0.9 / drives)
    assert by_frame > by_drive + 0.08


def test_folds_keep_drives_together_and_are_alike_in_size() -> None:
    drives = np.repeat(np.arange(9), [40, 3, 3, 20, 20, 30, 10, 4, 30])
    count = len(drives)
    samples = LikelihoodSamples(
        np.zeros((count, 1)), np.zeros((count, 4)), np.arange(count), drives
    )
    seen = []
    for rest, held_out in samples.in_folds():
        assert not {*drives[held_out]} & {*np.delete(drives, held_out)}
        assert len(rest.frames) == count - len(held_out)
        assert 26 <= len(held_out) <= 40
        seen.extend(held_out)
    assert sorted(seen) == list(range(count))


def test_a_fit_is_repeatable_and_survives_its_file(
    judged: tuple[LikelihoodModel, Any, Any], tmp_path: Path
) -> None:
    model, fit, others = judged
    again = fit_likelihood(model.on, LikelihoodSamples(fit.evidence, fit.states, fit.frames))
    path = tmp_path / "likelihoods.json"
    model.write(path)
    for other in (again, read_likelihood_model(path)):
        np.testing.assert_array_equal(
            other.decode(others.evidence).posterior.probabilities,
            model.decode(others.evidence).posterior.probabilities,
        )
    content = json.loads(path.read_text())
    offset = content.pop("offset")
    path.write_text(json.dumps(content))
    with pytest.raises(DataError, match="lacks 'offset'"):
        read_likelihood_model(path)
    for name, wrong in (("weights", [-1.0] * (ELEMENTS + 1)), ("log_density", [0.0])):
        path.write_text(json.dumps({**content, "offset": offset, name: wrong}))
        with pytest.raises(DataError, match=f"damaged: {name}"):
            read_likelihood_model(path)


@pytest.mark.parametrize("wrong", [1e308, -1e308, None, "a", {}])
def test_no_number_of_a_file_can_be_anything(
    judged: tuple[LikelihoodModel, Any, Any], wrong: object, tmp_path: Path
) -> None:
    path = tmp_path / "likelihoods.json"
    judged[0].write(path)
    sound = json.loads(path.read_text())
    places = [(sound, name) for name in sound if name not in ("format", "kind", "fitted_on")]
    places.remove((sound, "scale"))
    places += [(sound["scale"], name) for name in sound["scale"]]
    assert len(places) == 12
    for owner, name in places:
        # The first number, however deep in lists.
        key: Any = name
        while isinstance(owner[key], list):
            owner, key = owner[key], 0
        right, owner[key] = owner[key], wrong
        path.write_text(json.dumps(sound))
        with pytest.raises(DataError, match=r"likelihoods\.json: The file is damaged"):
            read_likelihood_model(path)
        owner[key] = right


@pytest.mark.parametrize(
    ("name", "lowest", "highest"),
    [
        ("log_density", -500.0, 50.0),
        ("correlation", -1.0, 1.0),
        ("lowest", -100.0, None),
        ("highest", None, 100.0),
        ("weights", 0.0, 1e6),
        ("offset", -1e6, 1e6),
        ("clean_scores", -1e9, 1e9),
        ("strangest", -1e9, 1e9),
    ],
)
def test_parameters_go_up_to_their_bounds(
    judged: tuple[LikelihoodModel, Any, Any],
    name: str,
    lowest: float | None,
    highest: float | None,
) -> None:
    model = judged[0]
    for bound, outwards in ((lowest, -1), (highest, 1)):
        if bound is None:
            continue
        value = getattr(model, name)
        filled = np.full_like(value, bound) if isinstance(value, np.ndarray) else bound
        replace(model, **{name: filled})
        beyond = bound + outwards * max(1e-6, 1e-9 * abs(bound))
        with pytest.raises(ConfigurationError, match=name):
            replace(model, **{name: filled + (beyond - bound)})


@pytest.mark.parametrize("wrong", [[], [0.5], [0.5, 0.5]])
def test_the_offset_of_a_file_is_one_number(
    judged: tuple[LikelihoodModel, Any, Any], wrong: object, tmp_path: Path
) -> None:
    """An empty list was accepted, and ended in a ValueError at the first frame."""
    path = tmp_path / "likelihoods.json"
    judged[0].write(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"offset": wrong}))
    with pytest.raises(DataError, match=r"likelihoods\.json: The file is damaged: offset"):
        read_likelihood_model(path)


def test_samples_that_teach_too_little(made_up: MadeUp) -> None:
    on = fitted_on(3)
    singles = np.r_[np.zeros((1, 4)), np.eye(4)]
    few = made_up(on.system, np.broadcast_to(singles, (12, 5, 4)), seed=1)
    samples = LikelihoodSamples(few.evidence, few.states, few.frames)
    with pytest.raises(ConfigurationError, match=r"\(0, 1, 2\) no two samples show \[0, 1\]"):
        fit_likelihood(on, samples)
    attacked = few.states.any(axis=1)
    with pytest.raises(ConfigurationError, match="0 of 12 have one"):
        LikelihoodSamples(few.evidence[attacked], few.states[attacked], few.frames[attacked])
    with pytest.raises(ConfigurationError, match="10 frames or more of 5 drives or more, got 9"):
        fit_likelihood(on, samples.of_frames(np.arange(12) < 9))
    with pytest.raises(ConfigurationError, match="5 drives or more, got 12 of 4"):
        fit_likelihood(on, replace(samples, drives=samples.frames // 3))
    with pytest.raises(ConfigurationError, match="one drive"):
        replace(samples, drives=np.arange(60))
    with pytest.raises(ConfigurationError, match="row for each sample"):
        replace(samples, drives=np.arange(59))
    with pytest.raises(ConfigurationError, match=f"{ELEMENTS} elements"):
        model_of(3, OR).posterior(np.zeros((1, 13)))
    with pytest.raises(ConfigurationError, match="prior"):
        model_of(3, OR).posterior(np.zeros((1, ELEMENTS)), np.ones(3))


def test_brier_and_reliability_by_hand() -> None:
    model = model_of(3, OR)
    posterior = model.posterior(np.full((2, ELEMENTS), 0.08), np.eye(16)[3])
    # Certain of S_0 and S_1, of which the second frame has none.
    truth = np.array([[1, 1, 0, 0], [0, 0, 0, 0]], bool)
    assert brier_score(posterior, truth) == pytest.approx(0.25)
    table = reliability(posterior, truth, bins=2)
    np.testing.assert_allclose(table, [[0, 0, 4, 2], [1, 0.5, 4, 2]])
    # The second frame counts three times.
    assert brier_score(posterior, truth, np.array([1, 3])) == pytest.approx(0.375)
    weighed = reliability(posterior, truth, np.array([1, 3]), bins=2)
    np.testing.assert_allclose(weighed, [[0, 0, 8, 64 / 40], [1, 0.25, 8, 64 / 40]])
    # Both of one drive: they are one.
    alike = reliability(posterior, truth, groups=["a", "a"], bins=2)
    np.testing.assert_allclose(alike[:, 3], 1)
