"""The validator of the defence: its thresholds are measured once, kept, and never half."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.defence.validator import fitted_file
from avsec_gym.runs.experiment import Configuration
from avsec_gym.validation import fitting
from avsec_gym.validation.thresholds import read_threshold_table


@pytest.fixture
def configuration(
    tmp_path: Path, walls: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> Configuration:
    monkeypatch.setenv("AVSEC_CACHE", str(tmp_path / "cache"))
    fit = walls.write_labelled_drives(tmp_path / "fit", 1, 4, first=5000)
    judged = walls.write_labelled_drives(tmp_path / "judged", 2, 1)
    return Configuration(str(judged), options={"fit": str(fit), "fit_limit": 4})


def test_a_stopped_measurement_goes_on_and_is_kept(
    configuration: Configuration, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[str] = []
    shares_of = fitting.shares_of

    def counted(frame: Any, *others: Any) -> Any:
        if len(measured) == 3 and not stopped:
            stopped.append(True)
            raise KeyboardInterrupt
        measured.append(frame.id)
        return shares_of(frame, *others)

    stopped: list[bool] = []
    monkeypatch.setattr(fitting, "shares_of", counted)
    with pytest.raises(KeyboardInterrupt):
        fitted_file(configuration)
    path = fitted_file(configuration)
    assert len(measured) == len(set(measured)) == 4
    assert fitted_file(configuration) == path
    assert len(measured) == 4
    table = read_threshold_table(path)
    assert len(table) == table.on.data["frames"] == 4
    # What was measured on the way is not left behind.
    assert not list(path.parent.glob("*.jsonl"))


def test_likelihoods_need_a_file(configuration: Configuration) -> None:
    options = {**configuration.options, "validator": "likelihood"}
    with pytest.raises(ConfigurationError, match="needs a fit"):
        fitted_file(Configuration(configuration.scenarios, options=options))
    options["fitted_file"] = "model.json"
    given = fitted_file(Configuration(configuration.scenarios, options=options))
    assert given == Path("model.json")
