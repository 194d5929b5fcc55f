"""Pages state what is known of their sources; of staleness, a page must not call itself current."""

from __future__ import annotations

import json
import re
from itertools import cycle
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from studies.__main__ import main
from studies.catalogue import STUDIES
from studies.docs_pages import docs_called_current, docs_pages
from studies.index import README, called_current, pages, with_remark, without_remark
from studies.provenance import Record, read_records, sources_of
from studies.source_states import SourceState, source_state, source_states
from studies.study import RESULTS, Step, Study

STALENESS = re.compile(
    r"Sources: unchanged|Stale: \d+ of \d+ source files have changed \(.*?\)"
    r"|\| (current|stale) \||, stale\)"
)


def test_the_index_and_the_pages_agree_with_the_records_and_the_results() -> None:
    states = source_states(read_records())
    wrong = [
        path.name
        for path, text in (pages(states) | docs_pages(states)).items()
        if STALENESS.sub("", path.read_text()) != STALENESS.sub("", text)
    ]
    assert not wrong, "run `python -m studies index`"


def test_what_is_said_of_sources(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("import b\n")
    (tmp_path / "b.py").write_text("B = 1\n")
    study = Study("new", "?", 1, ("new.md",), (Step(("a.py",)),), ("a.py",))

    def state(record: Record | None) -> tuple[bool | None, str]:
        found = source_state(study, {} if record is None else {"new": record}, tmp_path)
        return found.stale, found.text

    assert state(None) == (None, "Not made yet")
    assert state(Record("2026-11-21", "020f0c9")) == (
        True,
        "Stale: made before its sources were recorded (commit 020f0c9, 2026-11-21), and many have"
        " changed since",
    )
    made = Record("2026-12-01", version="0.1.0", sources=sources_of(["a.py"], tmp_path))
    since = "since it was made, 2026-12-01 (avsec-gym 0.1.0)"
    assert state(made) == (False, f"Sources: unchanged {since}")
    (tmp_path / "b.py").write_text("B = 2\n")
    assert state(made) == (True, f"Stale: 1 of 2 source files have changed (b.py) {since}")
    for name in ("c", "d", "e"):
        (tmp_path / f"{name}.py").write_text("")
    (tmp_path / "b.py").write_text("import c, d, e\n")
    named = "b.py, c.py, d.py, ..."
    assert state(made) == (True, f"Stale: 4 of 5 source files have changed ({named}) {since}")
    (tmp_path / "b.py").write_text("B = 2\n")
    assert STALENESS.sub("", state(made)[1]) == f" {since}"


def test_the_list_has_the_minutes_and_the_states_of_the_index(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = read_records()
    states = {
        name: SourceState(stale if name in made else None, "")
        for name, stale in zip(STUDIES, cycle((True, False, None)))
    }
    monkeypatch.setattr("studies.__main__.source_states", lambda _: states)
    assert main(["--json"]) == 0
    index = pages(states)[README]
    for facts in json.loads(capsys.readouterr().out):
        assert facts["stale"] is states[facts["name"]].stale
        assert f"| `{facts['command']}` | {facts['minutes']} min |" in index
    assert main([]) == 0
    listed = capsys.readouterr().out
    assert all(word in listed for word in ("current", "stale", "not made"))


def test_a_page_is_as_stale_as_the_parts_that_it_shows() -> None:
    study = STUDIES["detectors"]
    made = {
        name: Record("2026-12-01", version="0.1.0", sources=sources_of(STUDIES[name].sources))
        for name in (study.name, *study.shows)
    }
    assert source_state(study, made).stale is False
    changed = made["parity"].sources
    assert changed is not None
    made["parity"] = Record("2026-12-01", version="0.1.0", sources={**changed, "0": "gone.py"})
    assert source_state(study, made).text.startswith("Stale: 1 of ")
    made["disparity"] = Record("2026-11-22", "3b525f0")
    assert "(commit 3b525f0, 2026-11-22)" in source_state(study, made).text


def test_a_study_that_has_not_been_made_has_a_row_and_no_page(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.py").write_text("A = 1\n")
    writes = (f"{RESULTS}/new.md", f"{RESULTS}/new.json")
    new = Study("new", "What?", 7, writes, (Step(("a.py",)),), ("a.py",))
    for module in ("index", "source_states"):
        monkeypatch.setattr(f"studies.{module}.STUDIES", {"new": new})
    index = tmp_path / "studies/README.md"
    written = pages(source_states({}, tmp_path), tmp_path)
    assert list(written) == [index]
    # A link would lead nowhere.
    assert written[index].endswith(
        "| new | What? | `python -m studies.new` | 7 min | Not made yet |\n"
    )
    # It calls nothing current, so that the check has no fault to find.
    assert called_current(source_states({}, tmp_path), tmp_path) == []
    monkeypatch.setattr("studies.__main__.read_records", dict)
    monkeypatch.setattr("studies.__main__.pages", lambda _: {})
    monkeypatch.setattr("studies.docs_pages.docs_pages", lambda _: {})
    monkeypatch.setattr("studies.docs_pages.docs_called_current", lambda _: [])
    assert main(["check"]) == 0
    assert "0 of unchanged sources, 0 stale, 1 not made yet" in capsys.readouterr().out
    # A page that was made and is gone is a fault.
    made = {"new": Record("2026-12-01", version="0.1.0", sources=sources_of(["a.py"], tmp_path))}
    with pytest.raises(DataError, match=r"new\.md"):
        pages(source_states(made, tmp_path), tmp_path)
    (tmp_path / RESULTS).mkdir(parents=True)
    (tmp_path / writes[0]).write_text("# New\n")
    written = pages(source_states(made, tmp_path), tmp_path)
    assert "| [new](results/new.md) |" in written[index]
    assert "Sources: unchanged" in written[tmp_path / writes[0]]


def test_a_page_that_is_called_current_though_its_sources_changed_is_found(tmp_path: Path) -> None:
    since = "since it was made, 2026-12-01 (avsec-gym 0.1.0)"
    current = f"Sources: unchanged {since}"
    stale = f"Stale: 1 of 2 source files have changed (b.py) {since}"
    place, index = "studies/results/believed.md", "studies/README.md"
    (tmp_path / place).parent.mkdir(parents=True)

    def found(remark: str, row: str, state: bool | None) -> list[str]:
        page = with_remark(f"# Believed\n\n{current}\n", remark)  # The text is the study's own.
        (tmp_path / place).write_text(page)
        (tmp_path / index).write_text(f"| [fuzz](f.md) | {current} |\n| [believed](b) | {row} |\n")
        return called_current({"believed": SourceState(state, "")}, tmp_path)

    assert found(current, current, False) == []
    assert found(stale, stale, True) == []
    assert found(current, stale, True) == [place]
    assert found(stale, current, True) == [index]
    assert found(current, current, None) == [index, place]


@pytest.mark.parametrize(("claims", "code"), [([], 0), (["studies/README.md"], 1)])
def test_the_check_fails_on_such_a_page_alone(
    claims: list[str],
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("studies.__main__.source_states", lambda _: {"a": SourceState(True, "")})
    monkeypatch.setattr("studies.__main__.outdated", lambda _: [README])
    monkeypatch.setattr("studies.__main__.pages", lambda _: {})
    monkeypatch.setattr("studies.docs_pages.docs_pages", lambda _: {})
    monkeypatch.setattr("studies.docs_pages.docs_called_current", lambda _: [])
    monkeypatch.setattr("studies.__main__.called_current", lambda _: claims)
    assert main(["check"]) == code
    told = capsys.readouterr()
    assert "1 stale" in told.out
    assert ("called unchanged" in told.err) == bool(claims)


def test_a_remark_comes_below_the_title_and_goes_again() -> None:
    page = "# A title\n\nText.\n"
    once = with_remark(page, "*Stale.*")
    assert once.startswith("# A title\n\n<!-- sources -->\n*Stale.*\n<!-- /sources -->\n\nText.")
    assert with_remark(once, "*New.*") == with_remark(page, "*New.*")
    assert without_remark(once) == page == without_remark(page)


@pytest.mark.parametrize("name", ["chapter5_errors", "benchmarks"])
def test_remarks_of_this_repository(name: str) -> None:
    text = (Path(__file__).parents[2] / f"studies/results/{name}.md").read_text()
    assert text.count("<!-- sources -->") == 1
    assert "[all studies](../README.md)" in text


def test_a_row_that_is_called_current_though_its_sources_changed_is_found(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    row = "| a | 1 | 2 | – | real | `believed.json: a` | `python -m studies.believed --kitti DIR` |"
    page = "docs/reproduce_chapter3.md"

    def found(word: str, state: bool | None) -> list[str]:
        (tmp_path / page).write_text(f"{row} {word} | open |\n")
        return docs_called_current({"believed": SourceState(state, "")}, tmp_path)

    assert found("stale", True) == found("current", False) == found("stale", False) == []
    assert found("current", True) == found("current", None) == [page]
