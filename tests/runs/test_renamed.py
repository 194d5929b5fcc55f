"""Results that were made under old names are found under the new ones."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.runs.catalogue import EXPERIMENTS as CATALOGUE
from avsec_gym.runs.catalogue import attribute
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Experiment, Measurement
from avsec_gym.runs.manifest import MANIFEST
from avsec_gym.runs.renamed import (
    EXPERIMENTS,
    KEYS,
    SETTINGS,
    WORKS,
    with_new_keys,
    with_new_names,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder

RESULTS = Path(__file__).parents[2] / "studies" / "results"
WORK = f"{__name__}:work"
REKEYED = {
    "identification_sgbm": {"validation": "identification"},
    "identification_psmnet": {"validation": "identification"},
    "five_sensors": {"five_sensors": "five_sensors"},
    "localisation": {"localisation": "localisation"},
    "optical_attacks": {name: name for name in ("impact", "sensitivity")},
    "other_pairs": {"": "other_pairs"},
    "identification_real": {"": "identification_real"},
    "shipped_fits": {"": "shipped_fits"},
    "chapter5_errors": {"": "chapter5_errors"},
}
"""Committed results: the part of each, and the experiment whose keys it has; empty: all of it."""


def work(configuration: Configuration) -> Any:
    def measure(number: int) -> CellResult:
        return CellResult(measurements=[Measurement("setting", str(number), "name", 1.0)])

    return measure


def cells(configuration: Configuration) -> list[Cell]:
    return [Cell.of(WORK, "", number=number) for number in range(3)]


def test_a_new_name_stands_for_each_old_one() -> None:
    assert set(EXPERIMENTS.values()) <= set(CATALOGUE)
    assert not set(EXPERIMENTS) & set(CATALOGUE)
    for place in WORKS.values():
        assert callable(attribute(place))


def test_cells_keep_the_ids_of_the_first_place() -> None:
    for old, new in WORKS.items():
        digest = hashlib.sha256(f'{old} {{"number":1}}'.encode()).hexdigest()
        assert Cell.of(new, number=1).id == digest[:16]


def test_a_run_of_an_old_name_is_read_and_continued(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = Experiment("adaptive_attacks", "Which?", "", cells)
    run_experiments([experiment], Configuration(), tmp_path, workers=0, threads=1)
    before = RunFolder.open(tmp_path).cells()
    # The manifest of a release that named the experiment otherwise.
    manifest = (tmp_path / MANIFEST).read_text()
    (tmp_path / MANIFEST).write_text(manifest.replace('"adaptive_attacks"', '"knowing"'))
    assert json.loads((tmp_path / MANIFEST).read_text())["experiments"].keys() == {"knowing"}
    assert RunFolder.open(tmp_path).experiments == ("adaptive_attacks",)
    run_experiments([experiment], Configuration(), tmp_path, workers=0, threads=1)
    again = RunFolder.open(tmp_path)
    assert again.experiments == ("adaptive_attacks",)
    assert again.cells("adaptive_attacks") == before, "no cell is done again"


@pytest.mark.parametrize("name", REKEYED)
def test_committed_results_have_the_new_keys(name: str) -> None:
    results = json.loads((RESULTS / f"{name}.json").read_text())
    for part, experiment in REKEYED[name].items():
        figures = results[part] if part else results
        assert with_new_keys(figures, KEYS[experiment]) == figures


@pytest.mark.parametrize("name", ["chapter5", "chapter5_errors", "chapter5_thresholds"])
def test_committed_results_have_the_new_settings(name: str) -> None:
    results = json.loads((RESULTS / f"{name}.json").read_text())
    assert with_new_names(results, SETTINGS["chapter5"]) == results
