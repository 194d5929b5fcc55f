"""`avsec run` and `avsec experiments`: what they print and how they end."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.cli import run
from avsec_gym.runs import catalogue

DONE, BAD_DATA, BAD_USAGE, IN_PART = 0, 1, 2, 3
PRECISION, SAFETY = "tiny_experiments:PRECISION", "tiny_experiments:SAFETY"


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "runs")
    monkeypatch.setenv("TINY_DIARY", str(tmp_path / "diary"))
    monkeypatch.chdir(tmp_path)


def ends(*arguments: Any) -> int:
    try:
        return run([*map(str, arguments)])
    except SystemExit as end:
        return int(end.code or 0)


def test_a_run_and_its_continuation(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    usual = ("run", PRECISION, SAFETY, "--limit", 2, "--workers", 0, "--out", "here")
    assert ends(*usual) == DONE
    assert "here: 6 cells, 6 done, 0 were there" in capsys.readouterr().err
    assert ends(*usual, "--json") == DONE
    summary = json.loads(capsys.readouterr().out)
    assert summary == {
        "schema": "avsec.run/1",
        "out": "here", "cells": 6, "kept": 6, "done": 0, "failed": 0, "failed_before": 0,
        "failures": [],
    }  # fmt: skip
    assert ends(*usual, "--seed", 1) == BAD_DATA
    assert "has seed 0, asked is 1" in capsys.readouterr().err


def test_failed_cells_are_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    usual = ("run", "tiny_experiments:TROUBLE", "--workers", 0)
    assert ends(*usual) == IN_PART
    error = capsys.readouterr().err
    assert "ZeroDivisionError: a slip" in error
    assert "1 failed; run.log states why, --retry does them again" in error
    assert (tmp_path / "runs/trouble/run.log").is_file()
    assert ends(*usual, "--json") == IN_PART
    assert json.loads(capsys.readouterr().out)["failed_before"] == 1
    (tmp_path / "diary.repaired").touch()
    assert ends(*usual, "--retry") == DONE


def test_options_are_json_or_text(tmp_path: Path) -> None:
    weights = tmp_path / "weights"
    weights.touch()
    options = ("--options", "pause=0.001", f"weights={weights}")
    assert ends("run", PRECISION, "--limit", 1, "--workers", 0, *options) == DONE
    manifest = json.loads((tmp_path / "runs/precision/manifest.json").read_text())
    assert manifest["configuration"]["options"] == {"pause": 0.001, "weights": str(weights)}


def test_what_cannot_work_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for arguments, told in (
        ((), "avsec experiments"),
        (("unheard_of",), "no experiment 'unheard_of'"),
        ((PRECISION, "--limit", 0), "--limit"),
        ((PRECISION, "--workers", -1), "--workers"),
        ((PRECISION, "--options", "pause"), "NAME=VALUE"),
        ((PRECISION, "--options", "speed=3"), "Known: pause, weights"),
        ((PRECISION, "--options", 'pause="long"'), "like 0.0"),
        ((PRECISION, "--seed", -1), "seed"),
    ):
        assert ends("run", *arguments) == BAD_USAGE, arguments
        assert told in capsys.readouterr().err
    missing = ("--options", "weights=nowhere.safetensors")
    assert ends("run", PRECISION, *missing) == BAD_DATA
    assert "nowhere.safetensors" in capsys.readouterr().err


def test_experiments_are_listed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(catalogue, "EXPERIMENTS", {"precision": PRECISION, "safety": SAFETY})
    assert ends("experiments") == DONE
    shown = capsys.readouterr().out
    assert "Does the car still drive safely?" in shown
    assert "Table 5.1" in shown
    assert ends("experiments", "--json", "--scenarios", "mixed", "--limit", 4) == DONE
    listed = json.loads(capsys.readouterr().out)["experiments"]
    assert [(each["name"], each["cells"]) for each in listed] == [("precision", 8), ("safety", 8)]
    assert listed[0]["options"] == {"pause": 0.0, "weights": None}
    assert ends("experiments", SAFETY, "--json") == DONE
    (safety,) = json.loads(capsys.readouterr().out)["experiments"]
    assert safety["cells"] is None
