"""Names that are no ASCII, where the locale knows nothing else."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = "größe-日本"


PLAIN = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def avsec(
    folder: Path, *words: str, plain: Mapping[str, str] = PLAIN
) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "avsec_gym", *words],
        cwd=folder,
        env=os.environ | plain | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        timeout=300,
    )


@pytest.mark.slow
def test_a_run_and_its_report(tiny: ModuleType, diary: Path, tmp_path: Path) -> None:
    folder = tmp_path / FOLDER
    folder.mkdir()
    experiment = f"{tiny.__name__}:PRECISION"
    made = avsec(folder, "run", experiment, "--limit", "3", "--workers", "1", "--out", FOLDER)
    assert made.returncode == 0, made.stderr
    again = avsec(folder, "run", experiment, "--limit", "3", "--out", FOLDER)
    assert b"0 done, 6 were there" in again.stderr, again.stderr
    page = "Straße.html"
    shown = avsec(folder, "report", FOLDER, "--out", page, "--markdown", "Straße.md", "--json")
    assert shown.returncode == 0, shown.stderr
    assert json.loads(shown.stdout)
    assert FOLDER in (folder / page).read_text("utf-8")
    assert (folder / "Straße.md").read_text("utf-8")


@pytest.mark.slow
def test_a_run_goes_on_under_another_locale(tiny: ModuleType, diary: Path, tmp_path: Path) -> None:
    """With an input of such a name."""
    (tmp_path / FOLDER).write_text("weights")
    asked = ("run", f"{tiny.__name__}:PRECISION", "--limit", "3", "--options", f"weights={FOLDER}")
    made = avsec(tmp_path, *asked, "--workers", "1", "--out", "run")
    assert made.returncode == 0, made.stderr
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["configuration"]["options"]["weights"] == FOLDER
    assert manifest["inputs"]["weights"]["path"] == FOLDER
    for plain in ({"PYTHONUTF8": "1"}, PLAIN):
        again = avsec(tmp_path, *asked, "--out", "run", plain=plain)
        assert b"0 done, 6 were there" in again.stderr, again.stderr


@pytest.mark.slow
def test_the_rates_of_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / FOLDER
    folder.mkdir()
    done = avsec(folder, "evaluate", "--limit", "2", "--out", FOLDER)
    assert done.returncode == 0, done.stderr
    assert json.loads((folder / FOLDER / "evaluation.json").read_text("utf-8"))
    missing = avsec(folder, "evaluate", "--kitti", "Straße")
    assert missing.returncode == 1
    assert b"Traceback" not in missing.stderr
