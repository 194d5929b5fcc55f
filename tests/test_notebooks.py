"""The notebooks run in a kernel, in a short form: with smaller numbers as parameters."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples/notebooks").glob("*.ipynb"))
SHORT = {
    "attack_a_detector": {"FRAMES": 1},
    "train_an_attacker": {"STEPS": 4096, "EPISODES": 100},
    "validate_a_drive": {"FRAMES": 2},
}
"""Parameters of a run in the tests."""


def read(path: Path) -> Any:
    return nbformat.read(path, as_version=4)


def test_every_notebook_has_a_short_form() -> None:
    assert {path.stem for path in NOTEBOOKS} == set(SHORT)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_they_are_kept_without_outputs(path: Path) -> None:
    nbformat.validate(read(path))
    code = [cell for cell in read(path).cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_their_links_lead_somewhere(path: Path) -> None:
    text = "\n".join(cell.source for cell in read(path).cells if cell.cell_type == "markdown")
    links = re.findall(r"\]\(([^)\s]+)\)", text)
    assert links
    assert all((path.parent / link).exists() for link in links if not link.startswith("http"))


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_they_run(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # In an environment that is not activated: its commands are not on the path.
    own = Path(sys.executable).parent
    folders = [each for each in os.environ["PATH"].split(os.pathsep) if Path(each) != own]
    monkeypatch.setenv("PATH", os.pathsep.join(folders))
    notebook = read(path)
    [parameters] = [c for c in notebook.cells if "parameters" in c.metadata.get("tags", [])]
    for name, value in SHORT[path.stem].items():
        assert re.search(rf"^{name} = ", parameters.source, re.MULTILINE)
        parameters.source += f"\n{name} = {value}"
    resources = {"metadata": {"path": str(tmp_path)}}
    done = nbclient.NotebookClient(notebook, timeout=900, resources=resources).execute()
    shown = [output for cell in done.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in shown)
    assert not any("Traceback" in output.get("text", "") for output in shown)
