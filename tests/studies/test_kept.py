"""What a study has computed is packed, and unpacked elsewhere if its sources are the same."""

from __future__ import annotations

import json
import tarfile
from pathlib import Path

import pytest

import studies.kept
from avsec_gym.errors import ConfigurationError, DataError
from studies.kept import forget, keep, take_up
from studies.provenance import sources_of
from studies.study import Step, Study

STUDY = Study(
    "new", "?", 1, ("out.json",),
    (Step(("-c", "pass", "--out", "$runs/new/rows", "$runs/news", "$runs/others")),),
    ("benchmarks/layouts.py",),
)  # fmt: skip
FILES = {
    "new/rows/rows.jsonl": b'{"a": 1}\n',
    "new/rows/films/a.npz": b"\x00\x01",
    "news/record.json": b"{}",
}
LEFT_OUT = ["new/rows/view.webp", "new/world/training/calib/1.txt", "others/shared.json"]


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    for name, content in FILES.items() | dict.fromkeys(LEFT_OUT, b"1").items():
        (tmp_path / "runs" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "runs" / name).write_bytes(content)
    return tmp_path / "runs"


def test_what_is_computed_is_unpacked_elsewhere(runs: Path, tmp_path: Path) -> None:
    archive = keep(STUDY, runs, tmp_path / "kept")
    first = archive.read_bytes()
    assert keep(STUDY, runs, tmp_path / "kept").read_bytes() == first
    other = tmp_path / "machine/runs"
    assert take_up(STUDY, other, tmp_path / "kept")
    there = {path.relative_to(other).as_posix() for path in other.rglob("*") if path.is_file()}
    assert there == set(FILES)
    assert all((other / name).read_bytes() == content for name, content in FILES.items())
    # Never over what lies there.
    (other / "new/rows/rows.jsonl").write_text("more")
    assert not take_up(STUDY, other, tmp_path / "kept")
    assert (other / "new/rows/rows.jsonl").read_text() == "more"
    forget(STUDY, tmp_path / "kept")
    assert not take_up(STUDY, tmp_path / "third", tmp_path / "kept")


def test_other_sources_begin_from_nothing(
    runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    keep(STUDY, runs, tmp_path / "kept")
    monkeypatch.setattr(studies.kept, "sources_of", lambda _: {"12345678": "new.py"})
    assert not take_up(STUDY, tmp_path / "other", tmp_path / "kept")
    assert "new begins from nothing" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()


def test_nothing_and_too_much_are_not_kept(
    runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ConfigurationError, match="computed nothing"):
        keep(STUDY, tmp_path / "empty", tmp_path / "kept")
    monkeypatch.setattr(studies.kept, "MOST_BYTES", 10)
    with pytest.raises(ConfigurationError, match="at most"):
        keep(STUDY, runs, tmp_path / "kept")
    assert not (tmp_path / "kept").exists()


def test_damaged_archives_are_told(runs: Path, tmp_path: Path) -> None:
    archive = keep(STUDY, runs, tmp_path / "kept")
    sound = archive.read_bytes()
    for most in (0, 1, 2):
        place = (most + 1) * len(sound) // 4
        for broken in (sound[:place], sound[:place] + bytes(64) + sound[place + 64 :]):
            archive.write_bytes(broken)
            with pytest.raises(DataError, match="damaged"):
                take_up(STUDY, tmp_path / "other", tmp_path / "kept")
            assert not (tmp_path / "other").exists()


def test_an_archive_writes_nothing_outside(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    with tarfile.open(tmp_path / "kept/new.tar.xz", "w:xz") as archive:
        for name, text in (
            ("sources.json", json.dumps(sources_of(STUDY.sources))),
            ("../outside.json", "{}"),
        ):
            studies.kept._add(archive, name, text.encode())
    with pytest.raises(DataError, match="damaged"):
        take_up(STUDY, tmp_path / "runs", tmp_path / "kept")
    assert not (tmp_path / "outside.json").exists()
