"""Rates of detection and identification from evidence whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.detection_rates import (
    attack_cases_of,
    detection_rates,
    moment_interval,
)
from avsec_gym.experiments.chapter3.evidence_table import EvidenceTable, evidence_table
from avsec_gym.experiments.chapter3.identification_rates import (
    algorithm_2,
    fitted_model,
    honesty,
    identification_rates,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.state_evidence_cells import measured
from avsec_gym.sensor_system import KITTI_SYSTEM
from avsec_gym.validation.evidence import evidence_elements
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.state_posterior import state_vectors

ELEMENTS = evidence_elements(KITTI_SYSTEM)
SCOPES = [scope for _, scope in ELEMENTS]
STATES = state_vectors(4)
ON = FittedOn(KITTI_SYSTEM, {"name": "sgbm"}, (48.0, 384.0), {"made": "up"})


def made_up(moments: int, seed: int, damage: float = 0.5) -> EvidenceTable:
    """Clean errors of 0 to 0.2; an attack on a sensor adds so much to what depends on it."""
    rng = np.random.default_rng(seed)
    touched = np.array([[state[list(scope)].any() for scope in SCOPES] for state in STATES])
    clean = rng.uniform(0.0, 0.2, (moments, len(STATES), len(SCOPES)))
    shares = clean + damage * touched
    holes = rng.uniform(0.0, 0.1, (moments, len(STATES), len(KITTI_SYSTEM.triples)))
    names = [f"{number:03d}" for number in range(moments)]
    return EvidenceTable(KITTI_SYSTEM, names, shares, holes)


def test_clear_attacks_are_always_noticed_and_named_within_the_limit() -> None:
    fitted, judged = made_up(100, 0), made_up(60, 1)
    for row in detection_rates(fitted, judged, ON, "error", (0.0, 0.1)):
        assert row["average"] == 1.0
        assert row["interval"] == (1.0, 1.0)
        assert len(row["cases"]) == 7
        assert abs(row["false_alarms"]["rate"] - row["rate"]) < 0.1
    rows = identification_rates(lambda rate: algorithm_2(fitted, judged, ON, rate), 4, (0.0,))
    assert rows[0]["average"] > 0.95
    assert set(rows[0]["sensors"]) == {"S0", "S1", "S2", "S3"}
    assert rows[0]["beyond"]["of"] == 60 * (15 - 4)
    assert rows[0]["beyond"]["rate"] < 1.0


def test_attacks_that_change_nothing_are_noticed_as_often_as_false_alarms() -> None:
    fitted, judged = made_up(400, 0, damage=0.0), made_up(400, 1, damage=0.0)
    for row in detection_rates(fitted, judged, ON, rates=(0.05,)):
        assert row["average"] == pytest.approx(0.05, abs=0.04)
        assert row["false_alarms"]["rate"] == pytest.approx(0.05, abs=0.04)


def test_likelihood_tells_what_it_knows() -> None:
    fitted, judged = made_up(60, 0), made_up(40, 1)
    model = fitted_model(fitted, ON)
    found = maximum_likelihood(model, judged, 0.0)
    assert found.shape == (40, 16, 4)
    rows = identification_rates(lambda rate: maximum_likelihood(model, judged, rate), 4, (0.01,))
    assert rows[0]["average"] > 0.95
    assert rows[0]["false_alarms"]["rate"] < 0.1
    told = honesty(model, judged)
    assert told["right_where_told"]["rate"] > 0.95
    assert told["brier"] < 0.2


def test_brightness_of_a_triple_is_that_of_its_worse_pair_of_cameras() -> None:
    table = made_up(2, 0)
    shares = {element: table.shares[..., i] for i, element in enumerate(ELEMENTS)}
    for column, (i, j, k) in enumerate(KITTI_SYSTEM.triples):
        error, holes, densest, brightness = np.moveaxis(table.measures[:, :, column], -1, 0)
        np.testing.assert_array_equal(error, shares["error", (i, j, k)])
        np.testing.assert_array_equal(holes, table.hole_shares[..., column])
        np.testing.assert_array_equal(densest, shares["densest", (i, j, k)])
        both = shares["brightness", (j, k)]
        if i > 0:
            both = np.maximum(both, shares["brightness", (i, k)])
        np.testing.assert_array_equal(brightness, both)


def test_cases_are_the_seven_sets_of_a_triple() -> None:
    cases = attack_cases_of((0, 2, 3), 4)
    assert sorted(cases.values()) == [(0,), (0, 2), (0, 2, 3), (0, 3), (2,), (2, 3), (3,)]
    assert all(np.flatnonzero(STATES[index]).tolist() == [*case] for index, case in cases.items())


def test_cases_of_one_moment_count_as_one() -> None:
    hits = np.repeat(np.arange(100) < 80, 7).reshape(100, 7)
    low, high = moment_interval(hits)
    # As wide as of 100 moments, not of 700 cases.
    assert low == pytest.approx(0.72, abs=0.02)
    assert high == pytest.approx(0.88, abs=0.02)


class Stored:
    """A run's measurements."""

    def __init__(self, table: EvidenceTable) -> None:
        self.rows = []
        for m, moment in enumerate(table.moments):
            for index, state in enumerate(STATES):
                setting = "judged " + "".join("01"[int(one)] for one in state)
                named = [measured(*element) for element in ELEMENTS]
                named += [measured("hole_share", triple) for triple in KITTI_SYSTEM.triples]
                values = [*table.shares[m, index], *table.hole_shares[m, index]]
                self.rows += [
                    {"setting": setting, "scenario": moment, "name": name, "value": value}
                    for name, value in zip(named, values, strict=True)
                ]

    def measurements(self, **where: str) -> list[dict]:
        return [row for row in self.rows if row["setting"] == where["setting"]]


def test_a_run_is_read_back_and_half_a_moment_left_out() -> None:
    table = made_up(3, 0)
    stored = Stored(table)
    del stored.rows[-1]
    found = evidence_table(stored, "judged", KITTI_SYSTEM)  # type: ignore[arg-type]
    assert found.moments == ["000", "001"]
    np.testing.assert_array_equal(found.shares, table.shares[:2])
    np.testing.assert_array_equal(found.hole_shares, table.hole_shares[:2])
    with pytest.raises(ConfigurationError, match="no moment"):
        evidence_table(stored, "fitted", KITTI_SYSTEM)  # type: ignore[arg-type]
