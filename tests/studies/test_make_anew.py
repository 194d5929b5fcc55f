"""A study is made by its steps, and recorded; the command says what it lacks."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import studies.make_anew
from avsec_gym.errors import AvsecError
from studies import __main__ as command
from studies.catalogue import STUDIES
from studies.make_anew import make_anew
from studies.provenance import Record
from studies.source_states import SourceState
from studies.study import DATA, ROOT, Step, Study


@pytest.fixture
def records(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Record]:
    kept = {"old": Record("2026-11-21", "020f0c9")}
    monkeypatch.setattr(studies.make_anew, "ROOT", tmp_path)
    monkeypatch.setattr(studies.make_anew, "read_records", lambda: dict(kept))
    monkeypatch.setattr(studies.make_anew, "write_records", kept.update)
    return kept


def study(*steps: Step) -> Study:
    return Study("new", "?", 1, ("out.json",), steps, ("benchmarks/layouts.py",))


def test_steps_are_taken_and_recorded(
    records: dict[str, Record], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    print_paths = "import os, sys; print(os.getcwd() + '/here', *sys.argv[1:])"
    make_anew(
        study(Step(("-c", "pass")), Step(("-c", print_paths, "$kitti/training"), "out.json")),
        {"kitti": ["/data/kitti"], "runs": ["runs"]},
    )
    # No paths of one machine.
    assert (tmp_path / "out.json").read_text() == "here KITTI/training\n"
    assert "new: step 2 of 2, 0 min passed, about 1 min left" in capsys.readouterr().err
    assert sorted(records) == ["new", "old"]
    made = records["new"]
    assert made.sources is not None
    assert "benchmarks/layouts.py" in made.sources.values()
    assert made.command == "python -m studies.new --kitti DIR"


def test_a_step_that_fails_ends_it_unrecorded(records: dict[str, Record], tmp_path: Path) -> None:
    with pytest.raises(AvsecError, match="exit code 3"):
        make_anew(study(Step(("-c", "raise SystemExit(3)"), "out.json")), {"runs": ["runs"]})
    assert sorted(records) == ["old"]
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        # A folder of this name, a name of the catalogue alone, and what is neither.
        (["studies.chapter5"], 2, "chapter5 needs --kitti DIR"),
        (["studies.parity"], 2, "parity needs --parity DIR (outputs of the original networks"),
        (["studies.nothing"], 1, "No module named studies.nothing"),
        (["studies", "beleived"], 2, 'Did you mean "believed"?'),
    ],
)
def test_the_command(words: list[str], code: int, said: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (ended.returncode, said in ended.stderr) == (code, True), ended.stderr


def test_parts_of_a_page_that_are_of_todays_sources_stay(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = STUDIES["detectors"]
    stale = {"detector_ranking", "detector_benchmark"}
    states = {name: SourceState(name in stale, "") for name in (page.name, *page.shows)}
    monkeypatch.setattr(command, "source_states", lambda records: states)
    given: dict[str, list[str]] = {name: ["there"] for name in DATA}
    asked = command._asked([page.name], given)
    assert {each.name for each in asked[:-1]} == stale
    assert asked[-1] is page
    said = capsys.readouterr().err
    assert said.count("its sources are unchanged") == len(page.shows) - len(stale)
    # What is named itself is made anew, whatever its sources.
    monkeypatch.setitem(states, page.name, SourceState(False, ""))
    assert command._asked([page.name], given)[-1] is page
