"""A small run of chapter 4, from places to its section; and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.condition_states import condition_states
from avsec_gym.experiments.chapter4.instant_cells import (
    connected_cells,
    connected_inputs,
    constants_under,
)
from avsec_gym.experiments.chapter4.section import findings
from avsec_gym.experiments.chapter4.settings import (
    BY_GEOMETRY,
    CONDITIONS,
    EXACT,
    FITTED,
    JUDGED,
)
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL

TWO_VEHICLES = 4
"""Place of the condition in `CONDITIONS`."""


def configuration(**options: Any) -> Configuration:
    return Configuration("procedural", 2, options=options)


def test_each_place_has_a_cell_under_each_condition() -> None:
    cells = connected_cells(configuration())
    assert len(set(cells)) == len(cells) == 2 * 2 * len(CONDITIONS)
    assert {cell.arguments["part"] for cell in cells} == {FITTED, JUDGED}
    # Cells of a place go to one process, which scans it once.
    assert len({cell.group for cell in cells}) == 4
    [first, second] = connected_cells(Configuration("procedural", 1, options={"conditions": [3]}))
    assert first.arguments["condition"] == second.arguments["condition"] == 3
    shipped = {"constants": SHIPPED_FIT, "model": SHIPPED_MODEL}
    assert connected_inputs(configuration()) == shipped
    assert connected_inputs(configuration(constants="mine.json", model="learned.json")) == {
        "constants": Path("mine.json"),
        "model": Path("learned.json"),
    }


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (Configuration("mixed"), "procedural"),
        (Configuration("procedural", seed=1000), "0 to 999"),
        (configuration(conditions=[len(CONDITIONS)]), "conditions are places"),
        (configuration(conditions=["exact"]), "conditions are places"),
        (configuration(conditions=[True]), "conditions are places"),
    ],
)
def test_what_cannot_be_is_refused(wrong: Configuration, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        connected_cells(wrong)


def test_vehicles_know_how_much_their_poses_err() -> None:
    fit = read_connected_fit(SHIPPED_FIT)
    exact, wrong = (constants_under(fit, condition) for condition in (EXACT, CONDITIONS[2]))
    assert exact.margins.position_noise == 0.0
    assert wrong.margins.heading_noise == pytest.approx(np.radians(0.5))
    assert exact.rates == wrong.rates == fit.rates


@pytest.mark.slow
def test_a_run_is_resumed_and_shown(tmp_path: Path) -> None:
    chapter = experiment("chapter4")
    small = Configuration("procedural", 1, options={"conditions": [TWO_VEHICLES]})
    done = run_experiments([chapter], small, tmp_path / "run", workers=0)
    assert not done.failures
    again = run_experiments([chapter], small, tmp_path / "run", workers=0)
    assert not again.failures
    run = RunFolder.open(tmp_path / "run")
    assert run.missing() == 0
    [states] = condition_states(run)
    assert states.condition == CONDITIONS[TWO_VEHICLES]
    [fitted], [clean] = states.fitted, states.clean
    for state in (fitted, clean):
        assert state.regions == len(state.scores["rays"]) > 3
        assert 0 < state.decidable[BY_GEOMETRY].sum() < state.regions
        assert (state.nbytes("rays") <= 4096).all()
        assert (state.nbytes("rays") > 0).all()
        assert len(state.distances) <= state.pairs == state.regions
        assert (state.distances >= 0).all()
    shown = findings(run, ReportRequest())
    assert shown.sections[0].tables[0].rows
