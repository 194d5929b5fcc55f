"""Whatever is missing in a run's manifest, or stands there: the run is reported, or refused."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.errors import DataError
from avsec_gym.report.html import html_page
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_report import run_report
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.runs.manifest import (
    MANIFEST,
    check_same_question,
    new_manifest,
    read_manifest,
    write_manifest,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.text_files import write_text

STRANGE: tuple[Any, ...] = (
    None,
    True,
    -1,
    2.5,
    10**400,
    "",
    "x",
    "\ud800",
    [],
    [[1]],
    {},
    {"x": {}},
)


def places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Ways to all values of a tree."""
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in inner:
        yield (*place, key)
        if isinstance(each, dict | list):
            yield from places(each, (*place, key))


def changed(manifest: dict[str, Any], place: tuple[Any, ...], *value: Any) -> dict[str, Any]:
    """A copy with another value at a place, or with none."""
    copy = deepcopy(manifest)
    inner: Any = copy
    for key in place[:-1]:
        inner = inner[key]
    if value:
        inner[place[-1]] = value[0]
    else:
        del inner[place[-1]]
    return copy


@pytest.fixture
def root(tiny: ModuleType, tmp_path: Path) -> Path:
    """A finished run."""
    configuration = Configuration(options={"weights": str(tmp_path / "weights")})
    (tmp_path / "weights").write_text("abc")
    run_experiments([tiny.PRECISION], configuration, tmp_path / "run", workers=0, threads=1)
    return tmp_path / "run"


def test_nothing_that_was_asked_may_be_left_out(root: Path) -> None:
    path = root / "manifest.json"
    manifest = json.loads(path.read_text())
    for place in [(name,) for name in manifest] + [
        ("configuration", name) for name in manifest["configuration"]
    ]:
        path.write_text(json.dumps(changed(manifest, place)))
        with pytest.raises(DataError, match="no manifest of a run"):
            RunFolder.open(root)


@pytest.mark.slow
def test_a_changed_manifest_is_reported_or_refused(root: Path, tmp_path: Path) -> None:
    path = root / "manifest.json"
    manifest = json.loads(path.read_text())
    for number, place in enumerate(places(manifest)):
        # A page takes longer than a look: one of each place, of another value each time.
        reported = False
        values = STRANGE[number % len(STRANGE) :] + STRANGE[: number % len(STRANGE)]
        for value in ((), *((each,) for each in values)):
            path.write_text(json.dumps(changed(manifest, place, *value)))
            try:
                read_manifest(root)
            except DataError as error:
                assert str(path) in str(error)  # noqa: PT017 - the others are reported
                continue
            if not reported:
                report = run_report(RunFolder.open(root))
                write_text(tmp_path / "page.html", html_page(report), overwrite=True)
                write_text(tmp_path / "page.md", markdown_page(report), overwrite=True)
                reported = True


def test_names_are_those_of_every_locale(tmp_path: Path) -> None:
    """Begun where the locale knows ASCII alone, read where it is UTF-8, and the other way round."""
    name = "größe"
    kept = name.encode().decode("ascii", "surrogateescape")
    manifest = new_manifest([], Configuration(kept, options={"weights": kept}), 1)
    manifest["experiments"] = {"unattacked": {"question": "", "thesis": ""}}
    write_manifest(tmp_path, manifest)
    written = json.loads((tmp_path / MANIFEST).read_text())["configuration"]
    assert (written["scenarios"], written["options"]["weights"]) == (name, name)
    # Also of a release that kept what Python had.
    for text in (json.dumps(manifest), json.dumps(written)):
        there = manifest | {"configuration": json.loads(text).get("configuration", written)}
        (tmp_path / MANIFEST).write_text(json.dumps(there))
        found = read_manifest(tmp_path)
        assert found is not None
        assert found["configuration"]["scenarios"] == name
        for scenarios in (name, kept):
            asked = Configuration(scenarios, options={"weights": scenarios})
            check_same_question(tmp_path, found, asked, 1)
    cells = [Cell.of("here:Work", weights=text) for text in (name, kept)]
    assert cells[0].id == cells[1].id
    assert cells[0].arguments == {"weights": name}
