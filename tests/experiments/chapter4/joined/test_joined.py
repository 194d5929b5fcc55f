"""Joined identification on rendered frames: the rates of what a run keeps, and one place."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.joined.cells import CASES, JOINED, STATUSES, JoinedFrames
from avsec_gym.experiments.chapter4.joined.rates import joined_rows
from avsec_gym.experiments.chapter4.joined.section import joined_section
from avsec_gym.runs.experiment import Configuration, Measurement
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.state_posterior import SensorStatus


class _Run:
    """Measurements as a run returns them."""

    def __init__(self, rows: list[Measurement]) -> None:
        self._rows = rows

    def measurements(self, *, setting: str) -> list[Measurement]:
        return [row for row in self._rows if row.setting == setting]


def _frame(case: str, place: str, status: SensorStatus) -> list[Measurement]:
    """The car knows that a sensor of three is attacked, and not which; the scan is recovered."""
    attacked = case != "joined none"
    own = np.full(8, 0.01)
    own[[1, 2, 4] if attacked else 0] = 1.0
    recovered = np.full(8, 0.001)
    recovered[0] = 1.0
    values = {
        "status": float(STATUSES.index(status)),
        "alarm": float(attacked),
        "familiar": 1.0,
        "own alarm": float(attacked),
        "own familiar": 1.0,
    }
    for name, states in (("own", own), ("recovered", recovered)):
        values |= {f"{name} {i}": float(value) for i, value in enumerate(states / states.sum())}
    return [Measurement(case, place, name, value) for name, value in values.items()]


def test_the_lidar_is_named_by_what_others_report_at_other_places() -> None:
    rows: list[Measurement] = []
    for place in map(str, range(100)):
        rows += _frame("joined none", place, SensorStatus.SOUND)
        rows += _frame("joined camera 3", place, SensorStatus.SOUND)
        rows += _frame("joined lidar", place, SensorStatus.ATTACKED)
    results: Any = _Run(rows)
    clean, lidar, camera = joined_rows(results)
    assert (clean.attacked, clean.alone.rate, clean.joined.rate) == ("none", 1.0, 1.0)
    assert (lidar.attacked, lidar.alone.rate, lidar.joined.rate) == ("lidar", 0.0, 1.0)
    assert lidar.lidar_named.rate == 1.0
    # Others say nothing of which camera it is.
    assert (camera.alone.rate, camera.joined.rate) == (0.0, 0.0)
    section = joined_section([clean, lidar, camera])
    assert "With lidar attacked, the car alone names exactly that in 0.0 %" in section.sentences[1]


def test_a_cell_for_each_place_and_no_other_scenes() -> None:
    assert len(JOINED.cells(replace(JOINED.usual, limit=3))) == 3
    with pytest.raises(ConfigurationError, match="procedural"):
        JOINED.cells(Configuration("mixed", 3))


@pytest.mark.slow
def test_a_place_keeps_the_states_of_every_case() -> None:
    result = JoinedFrames(JOINED.usual)(1)
    by_case = {case: {} for case in CASES}  # type: dict[str, dict[str, float]]
    for row in result.measurements:
        by_case[row.setting][row.name] = row.value
    for case, sensors in CASES.items():
        values = by_case[case]
        assert sum(values[f"own {index}"] for index in range(8)) == pytest.approx(1.0)
        if not sensors:
            assert values["own alarm"] == values["alarm"] == 0.0
        named = STATUSES[int(values["status"])] == SensorStatus.ATTACKED
        assert named == ("recovered 0" in values)
        assert not named or LIDAR in sensors
