"""Two of five sensors attacked: from drives to evidence, and from known evidence to the page."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from avsec_gym.experiments.chapter3.identification import five_sensors
from avsec_gym.experiments.chapter3.identification.evidence_table import evidence_table
from avsec_gym.experiments.chapter3.identification.five_sensors import (
    FIVE,
    FiveStateEvidences,
    five_cells,
    five_summary,
)
from avsec_gym.experiments.chapter3.identification.in_words import five_sentence
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import (
    OF_TRIPLES,
    bits,
    measured,
)
from avsec_gym.experiments.chapter3.identification.tables_of_five_sensors import table_of_five
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import CellResult, Configuration, Measurement
from avsec_gym.validation.evidence.evidence import evidence_elements
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.state_posterior import state_vectors

STATES = state_vectors(len(FIVE))
FRAMES = 30


class Kept:
    """What cells came to, as a run keeps it."""

    def __init__(self, *cells: CellResult) -> None:
        self._rows: dict[str, list[Measurement]] = {}
        for cell in cells:
            for row in cell.measurements:
                self._rows.setdefault(row.setting, []).append(row)

    def measurements(self, setting: str) -> list[Measurement]:
        return self._rows.get(setting, [])


def test_a_cell_has_all_states_of_all_sensors(tmp_path: Path, walls: ModuleType) -> None:
    fit, judged = (
        walls.write_wall(tmp_path / part, 1, 0, seed)
        for part, seed in (("fit", 10), ("judged", 20))
    )
    configuration = Configuration(str(judged), options={"fit": str(fit)})
    cells = five_cells(configuration)
    assert cells == experiment("five_sensors").cells(configuration)
    assert [cell.arguments["part"] for cell in cells] == ["fitted", "judged"]
    result = FiveStateEvidences(configuration)(**cells[1].arguments)
    assert {row.setting for row in result.measurements} == {
        f"judged {bits(state)}" for state in STATES
    }
    table = evidence_table(Kept(result), "judged", FIVE)  # type: ignore[arg-type]
    assert table.shares.shape == (1, 32, len(evidence_elements(FIVE)))
    clean = StateEvidence(walls.wall(20), {}, FIVE, PairDepth("sgbm")).evidence(STATES[:1])
    np.testing.assert_allclose(table.shares[:, 0], clean, atol=1e-9)
    # With a sensor that is not attacked, all others agree.
    for state, shares in zip(STATES, table.shares[0], strict=True):
        for number, (_, scope) in enumerate(evidence_elements(FIVE)):
            if not state[list(scope)].any():
                assert shares[number] == pytest.approx(table.shares[0, 0, number])


def known_frame(part: str, number: int, hidden: int) -> CellResult:
    """An attack adds to what depends on it; on the hidden sensor alone only to what is darker."""
    random = np.random.default_rng([part == "judged", number])
    # What is judged stays below the largest of what is fitted.
    id, rows, most = f"drive_{number:03d}/0", [], 0.05 if part == "fitted" else 0.04
    for state in STATES:
        setting = f"{part} {bits(state)}"
        lone = state.sum() == 1 and state[hidden]
        for name, scope in evidence_elements(FIVE):
            touched = state[list(scope)].any() and not (lone and name != "darker")
            share = random.uniform(0.01, most) + 0.4 * touched
            rows.append(Measurement(setting, id, measured(name, scope), share))
        for name in OF_TRIPLES:
            for triple in FIVE.triples:
                touched = state[list(triple)].any() and not lone
                share = random.uniform(0.01, most) + 0.4 * touched
                rows.append(Measurement(setting, id, measured(name, triple), share))
    return CellResult(measurements=rows)


def test_two_that_are_attacked_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    on = FittedOn(FIVE, {"name": "sgbm"}, (100.0, 100.0, 100.0), {"made": "up"})
    monkeypatch.setattr(five_sensors, "fitted_to", lambda configuration, system: on)
    cells = [
        known_frame(part, number, hidden=2)
        for part in ("fitted", "judged")
        for number in range(FRAMES)
    ]
    told = five_summary(Kept(*cells), Configuration())  # type: ignore[arg-type]
    assert told is not None
    json.dumps(as_json(told), allow_nan=False)
    rows = {(row.method, row.rates.rate): row.rates for row in told.identification}
    by_algorithm, likeliest = (
        rows[rule, 0.0] for rule in ("algorithm 2, any", "maximum likelihood")
    )
    # Nothing that a triple has tells of the third sensor alone; what pairs have does.
    assert by_algorithm.together["1"].rate == pytest.approx(4 / 5)
    assert by_algorithm.together["2"].rate == 1.0
    assert likeliest.together["1"].percent > 95
    assert likeliest.together["2"].percent > 95
    assert by_algorithm.average == pytest.approx(14 / 15)
    assert by_algorithm.beyond.of == FRAMES * 16
    table = table_of_five(told)
    assert len(table.rows) == 15
    assert all(len(row) == len(table.columns) for row in table.rows)
    said = five_sentence(told)
    assert "two together in" in said
    few = five_summary(Kept(*cells[:5], *cells[-5:]), Configuration())  # type: ignore[arg-type]
    assert few is None
