"""Cells and their identity; experiments by name and by place."""

from __future__ import annotations

import sys
from importlib import metadata
from types import ModuleType, SimpleNamespace

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.runs import catalogue
from avsec_gym.runs.catalogue import (
    EXPERIMENTS,
    experiment,
    importable_experiments,
    known_experiments,
)
from avsec_gym.runs.experiment import Cell, Configuration, Experiment, with_defaults

TRUTH = Experiment("truth", "Is it?", "Table 5.1", lambda configuration: [])


def test_a_cell_is_its_work_and_arguments() -> None:
    cell = Cell.of("a:b", "scene", attack={"name": "pgd", "alpha": 0.4}, n=4)
    same = Cell.of("a:b", n=4, attack={"alpha": 0.4, "name": "pgd"})
    assert cell == same
    assert len({cell, same, Cell.of("a:c", n=4), Cell.of("a:b", n=5)}) == 3
    assert cell.id == same.id != Cell.of("a:b", n=5).id
    assert cell.arguments == {"attack": {"name": "pgd", "alpha": 0.4}, "n": 4}
    # Ids are stored: they may never change.
    assert Cell.of("a:b", n=4).id == "cdd6df41ab8e524a"
    for odd in (float("nan"), {1, 2}, object()):
        with pytest.raises(ConfigurationError, match="no JSON"):
            Cell.of("a:b", odd=odd)


def test_options_get_defaults_and_are_checked() -> None:
    options = {"alpha": 0.4, "weights": None, "detectors": ["dsgn"], "quantised": False}
    known = Experiment("x", "", "", lambda configuration: [], options=options)
    given = {"alpha": 1, "weights": "a.safetensors", "detectors": ("stereo_rcnn",)}
    result = with_defaults(Configuration(options=given), [TRUTH, known])
    assert result.options == {
        "alpha": 1, "weights": "a.safetensors", "detectors": ["stereo_rcnn"], "quantised": False,
    }  # fmt: skip
    for wrong in ({"beta": 1}, {"alpha": "x"}, {"detectors": "dsgn"}, {"quantised": 1}):
        with pytest.raises(ConfigurationError):
            with_defaults(Configuration(options=wrong), [known])
    for impossible in ({"limit": 0}, {"seed": -1}, {"options": {"x": object()}}):
        with pytest.raises(ConfigurationError):
            Configuration(**impossible)  # type: ignore[arg-type]


def test_experiments_are_found_by_name_and_by_place(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("other_experiments")
    module.TRUTH, module.NONE = TRUTH, 3  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "other_experiments", module)
    assert experiment("other_experiments:TRUTH") is TRUTH
    monkeypatch.setitem(catalogue.EXPERIMENTS, "short", "other_experiments:TRUTH")
    assert experiment("short") is TRUTH
    for wrong in ("truth", "other_experiments:NONE", "other_experiments:X", "no_where:X"):
        with pytest.raises(ConfigurationError):
            experiment(wrong)


def test_packages_add_experiments_but_take_no_name(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    module = ModuleType("other_experiments")
    module.TRUTH = TRUTH  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "other_experiments", module)
    places = {"truth": "other_experiments:TRUTH", "demo": "other_experiments:TRUTH"}
    points = [SimpleNamespace(name=name, value=place) for name, place in places.items()]
    groups = {"avsec_gym.experiments": [*points, SimpleNamespace(name="lost", value="no_where:X")]}
    monkeypatch.setattr(metadata, "entry_points", lambda group: groups.get(group, []))
    assert list(known_experiments()) == [*EXPERIMENTS, "truth", "lost"]
    assert known_experiments()["demo"] == EXPERIMENTS["demo"]
    assert "experiment demo of other_experiments:TRUTH is left out" in caplog.text
    assert experiment("truth") is TRUTH
    with pytest.raises(ConfigurationError, match='Did you mean "truth"'):
        experiment("thruth")
    found, problems = importable_experiments()
    assert [each.name for each in found] == [*EXPERIMENTS, "truth"]
    assert len(problems) == 1
    assert "the experiment lost of another package" in problems[0]


def test_every_experiment_of_the_catalogue_can_be_loaded() -> None:
    for name in EXPERIMENTS:
        found = experiment(name)
        assert found.name == name
        assert found.question.endswith("?")
        assert found.question.count("\n") == 0
