"""Rates of detection and identification from evidence whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.identification.beyond_rates import RATE, beyond_rates
from avsec_gym.experiments.chapter3.identification.calibration import calibration
from avsec_gym.experiments.chapter3.identification.detection_rates import (
    attack_cases_of,
    detection_rates,
)
from avsec_gym.experiments.chapter3.identification.error_distributions import (
    case_distributions,
    reference_distributions,
)
from avsec_gym.experiments.chapter3.identification.evidence_table import (
    EvidenceTable,
    evidence_table,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    algorithm_2,
    fitted_model,
    identification_rates,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import measured
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.runs.experiment import Measurement
from avsec_gym.sensor_system import KITTI_SYSTEM
from avsec_gym.validation.evidence.evidence import evidence_elements
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.state_posterior import SensorStatus, attack_prior, state_vectors
from avsec_gym.validation.thresholds import ThresholdTable

ELEMENTS = evidence_elements(KITTI_SYSTEM)
SCOPES = [scope for _, scope in ELEMENTS]
STATES = state_vectors(4)
ON = FittedOn(KITTI_SYSTEM, {"name": "sgbm"}, (48.0, 384.0), {"made": "up"})


def made_up(frames: int, seed: int, damage: float = 0.5) -> EvidenceTable:
    """Clean errors of 0 to 0.2; an attack on a sensor adds so much to what depends on it."""
    rng = np.random.default_rng(seed)
    touched = np.array([[state[list(scope)].any() for scope in SCOPES] for state in STATES])
    clean = rng.uniform(0.0, 0.2, (frames, len(STATES), len(SCOPES)))
    shares = clean + damage * touched
    triples = KITTI_SYSTEM.triples
    of_triples = rng.uniform(0.0, 0.1, (frames, len(STATES), 2, len(triples)))
    names = [f"{number:03d}/0" for number in range(frames)]
    return EvidenceTable(KITTI_SYSTEM, names, shares, of_triples)


def test_clear_attacks_are_always_detected_and_named_within_the_limit() -> None:
    fitted, judged = made_up(100, 0), made_up(60, 1)
    for row in detection_rates(fitted, judged, ON, "error", (0.0, 0.1)):
        assert row.rates.average == 1.0
        # Sixty drives without a miss leave a doubt.
        assert row.rates.interval == pytest.approx(wilson_interval(60, 60))
        assert len(row.rates.cases) == 7
        assert row.rates.false_alarms.percent == pytest.approx(100 * row.rate, abs=10)
    rows = identification_rates(
        lambda rate: algorithm_2(fitted, judged, ON, rate), judged.drives, 4, (0.0,)
    )
    assert rows[0].average is not None
    assert rows[0].average > 0.95
    assert set(rows[0].sensors) == {"S0", "S1", "S2", "S3"}
    assert rows[0].beyond.of == 60 * (15 - 4)
    assert rows[0].beyond.percent < 100


def test_an_error_that_no_sensor_explains_is_an_alarm_as_the_validator_raises_it() -> None:
    """The validator's own rule, frame by frame, with maps that are not needed to know e."""
    fitted, judged = made_up(100, 0), made_up(300, 1, damage=0.0)
    found = algorithm_2(fitted, judged, ON, 0.05)
    thresholds = ThresholdTable(ON, fitted.measures[:, 0]).thresholds(0.05)
    for number, measures in enumerate(judged.measures[:, 0]):
        e = {
            triple: bool((shares > thresholds[triple].shares).any())
            for triple, shares in zip(KITTI_SYSTEM.triples, measures, strict=True)
        }
        answer = identify_attacked_sensors(e.__getitem__, 4)
        assert found.alarms[number, 0] == bool(answer.attacked or answer.doubtful)
        assert set(np.flatnonzero(found.sensors[number, 0])) == set(answer.attacked)
        named = set() if answer.limit_exceeded else set(answer.attacked)
        assert set(np.flatnonzero(found.reported[number, 0])) == named
    row = identification_rates(lambda rate: found, judged.drives, 4, (0.05,))[0]
    assert row.false_alarms.count == found.alarms[:, 0].sum()
    # Some of them name no sensor.
    assert found.alarms[:, 0].sum() > found.sensors[:, 0].any(axis=1).sum()


def test_attacks_that_change_nothing_are_detected_as_often_as_false_alarms() -> None:
    fitted, judged = made_up(400, 0, damage=0.0), made_up(400, 1, damage=0.0)
    for row in detection_rates(fitted, judged, ON, rates=(0.05,)):
        assert row.rates.average == pytest.approx(0.05, abs=0.04)
        assert row.rates.false_alarms.rate == pytest.approx(0.05, abs=0.04)


def test_likelihood_tells_what_it_knows() -> None:
    fitted, judged = made_up(60, 0), made_up(40, 1)
    model = fitted_model(fitted, ON)
    found = maximum_likelihood(model, judged, 0.0)
    assert found.sensors.shape == (40, 16, 4)
    np.testing.assert_array_equal(found.alarms, found.sensors.any(axis=2))
    rows = identification_rates(
        lambda rate: maximum_likelihood(model, judged, rate), judged.drives, 4, (0.01,)
    )
    assert rows[0].average is not None
    assert rows[0].average > 0.95
    assert rows[0].false_alarms.percent < 10


def test_calibration_is_of_what_is_reported() -> None:
    fitted, judged = made_up(60, 0, damage=0.08), made_up(40, 1, damage=0.08)
    model = fitted_model(fitted, ON)
    found = calibration(model, judged)
    counted: dict[int, list[str]] = {}
    for number, state in enumerate(STATES):
        for shares in judged.shares[:, number]:
            # As the validator does, a frame at a time.
            decoding = model.decode(shares[None], LikelihoodValidator.rate)
            for said, attacked in zip(decoding.statuses()[0], state, strict=True):
                right = said == (SensorStatus.ATTACKED if attacked else SensorStatus.SOUND)
                what = "cannot_tell" if said == SensorStatus.CANNOT_TELL else "wrong"
                counted.setdefault(int(state.sum()), []).append("right" if right else what)
    assert list(found.statuses) == ["0", "1", "2", "3", "4"]
    for count, answers in counted.items():
        row = found.statuses[str(count)]
        for what in ("right", "wrong", "cannot_tell"):
            assert (getattr(row, what).count, getattr(row, what).of) == (
                answers.count(what),
                len(answers),
            )
        whole = [set(answers[i : i + 4]) == {"right"} for i in range(0, len(answers), 4)]
        assert (row.all_right.count, row.all_right.of) == (sum(whole), len(whole))
    # Not to know is neither right nor wrong.
    assert any(row.cannot_tell.count for row in found.statuses.values())
    assert found.probabilities.brier < 0.1
    predicted, observed, sensors = (
        np.array([getattr(row, column) for row in found.probabilities.reliability])
        for column in ("predicted", "observed", "sensors")
    )
    assert sensors.sum() == pytest.approx(1.0)
    # As often as the prior expects sensors to be attacked.
    attacked = attack_prior(4) @ STATES.mean(axis=1)
    assert (observed * sensors).sum() == pytest.approx(attacked)
    assert (predicted * sensors).sum() == pytest.approx(attacked, rel=0.2)
    assert found.probabilities.calibration_error == pytest.approx(
        (np.abs(predicted - observed) * sensors).sum()
    )
    for row in found.probabilities.reliability:
        assert row.interval[0] <= row.observed <= row.interval[1]


def test_attacks_beyond_are_judged_sensor_by_sensor() -> None:
    fitted = made_up(200, 0)
    clear, nothing = (
        EvidenceTable(
            table.system, table.frames, table.shares[:, [1, 2, 4, 8]],
            table.of_triples[:, [1, 2, 4, 8]],
        )
        for table in (made_up(40, 1), made_up(40, 1, damage=0.0))
    )  # fmt: skip
    model = fitted_model(fitted, ON)
    rows = beyond_rates(fitted, {"clear": clear, "nothing": nothing}, ON, model)
    assert [(row.kind, row.sensor) for row in rows] == [
        (kind, sensor) for kind in ("clear", "nothing") for sensor in range(4)
    ]
    ways = ("detected", "detected_by_error", "named", "named_likeliest")
    for row in rows:
        rates = [getattr(row, way).rate for way in ways]
        assert min(rates) > 0.8 if row.kind == "clear" else max(rates) < 0.2
    assert RATE == 0.01


def test_distributions_tell_the_cases_apart() -> None:
    judged = made_up(50, 1)
    for row in case_distributions(judged):
        assert len(row.cases) == 7
        for shares in (row.clean, *row.cases.values()):
            assert sum(shares) == pytest.approx(1.0)
        clean = np.flatnonzero(row.clean).max()
        assert all(np.flatnonzero(shares).min() > clean for shares in row.cases.values())
    rows = reference_distributions(judged)
    assert [row.triple for row in rows] == [[0, 1, 3], [0, 2, 3], [1, 2, 3]]
    for row in rows:
        clean = np.flatnonzero(row.cases[""]).max()
        for sensor in range(4):
            is_larger = np.flatnonzero(row.cases[f"S{sensor}"]).min() > clean
            assert is_larger == (sensor in row.triple)


def test_measures_of_a_triple_are_elements_and_what_is_none() -> None:
    table = made_up(2, 0)
    shares = {element: table.shares[..., i] for i, element in enumerate(ELEMENTS)}
    for column, triple in enumerate(KITTI_SYSTEM.triples):
        error, holes, densest, brightness = np.moveaxis(table.measures[:, :, column], -1, 0)
        np.testing.assert_array_equal(error, shares["error", triple])
        np.testing.assert_array_equal(holes, table.of_triples[:, :, 0, column])
        # Only where the triple has a scan.
        assert (("densest", triple) in shares) == (triple[0] == 0)
        np.testing.assert_array_equal(densest, shares.get(("densest", triple), 0.0))
        np.testing.assert_array_equal(brightness, table.of_triples[:, :, 1, column])


def test_cases_are_the_seven_sets_of_a_triple() -> None:
    cases = attack_cases_of((0, 2, 3), 4)
    assert sorted(cases.values()) == [(0,), (0, 2), (0, 2, 3), (0, 3), (2,), (2, 3), (3,)]
    assert all(np.flatnonzero(STATES[index]).tolist() == [*case] for index, case in cases.items())


class Stored:
    """A run's measurements."""

    def __init__(self, table: EvidenceTable) -> None:
        self.rows = []
        for m, id in enumerate(table.frames):
            for index, state in enumerate(STATES):
                setting = "judged " + "".join("01"[int(attacked)] for attacked in state)
                named = [measured(*element) for element in ELEMENTS]
                named += [
                    measured(name, triple)
                    for name in ("hole_share", "brightness")
                    for triple in KITTI_SYSTEM.triples
                ]
                values = [*table.shares[m, index], *table.of_triples[m, index].ravel()]
                self.rows += [
                    Measurement(setting, id, name, value)
                    for name, value in zip(named, values, strict=True)
                ]

    def measurements(self, **where: str) -> list[Measurement]:
        return [row for row in self.rows if row.setting == where["setting"]]


def test_a_run_is_read_back_and_half_a_frame_left_out() -> None:
    table = made_up(3, 0)
    stored = Stored(table)
    del stored.rows[-1]
    found = evidence_table(stored, "judged", KITTI_SYSTEM)  # type: ignore[arg-type]
    assert found.frames == ["000/0", "001/0"]
    np.testing.assert_array_equal(found.shares, table.shares[:2])
    np.testing.assert_array_equal(found.of_triples, table.of_triples[:2])
    with pytest.raises(ConfigurationError, match="no whole frame"):
        evidence_table(stored, "fitted", KITTI_SYSTEM)  # type: ignore[arg-type]
