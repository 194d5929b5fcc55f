"""An experiment in a package of its own is run, and reported like ours."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from avsec_gym.cli import run
from avsec_gym.errors import ConfigurationError
from avsec_gym.report.run_report import run_report
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest

PACKAGE = '''
"""Do coins fall as often on heads as on tails?"""

import random

from avsec_gym.drawing.page_figure import Figure, line_key
from avsec_gym.drawing.page_plots import Frame, Scale, drawing, polyline
from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.runs.experiment import Cell, CellResult, Experiment, Measurement
from avsec_gym.runs.section import Findings, Section

FRAME = Frame(Scale(0, 99, 30, 240), Scale(0, 1, 140, 20))


def coin(configuration):
    def toss(weight):
        draw = random.Random(f"{configuration.seed} {weight}")
        heads = [draw.random() < weight for _ in range(100)]
        rows = [Measurement("coin", f"{n:02d}", "heads", h, weight) for n, h in enumerate(heads)]
        return CellResult(measurements=rows)

    return toss


def cells(configuration):
    return [Cell.of("coins.tossing:coin", weight=weight) for weight in (0.5, 0.9)]


def findings(run, request):
    tosses = {}
    for row in run.measurements(name="heads"):
        tosses.setdefault(row.strength, []).append(row.value)
    if not tosses:
        return Findings()
    shares = {weight: sum(found) / len(found) for weight, found in tosses.items()}
    rows = [[name(f"{weight:g}"), figure(share, scale=100)] for weight, share in shares.items()]
    lines = [
        polyline([FRAME.at((n, sum(found[: n + 1]) / (n + 1))) for n in range(100)], "line-0")
        for found in tosses.values()
    ]
    shown = drawing(250, 160, [FRAME.axes([], [0, 1]), *lines], "Share of heads over tosses")
    section = Section(
        "coins",
        "Are the coins fair?",
        [f"The heavier coin falls on heads {shares[0.9]:.0%} of the time."],
        [
            Figure("Heads over tosses", [shown], [line_key("line-0", "share of heads")]),
            Table("Heads of 100 tosses", ["weight", "heads, %"], rows),
        ],
    )
    numbers = {"coins": {str(weight): share for weight, share in shares.items()}}
    return Findings([section], numbers, style=".coin > b { top: 0 }", script="coin(1 < 2);")


COINS = Experiment("coins", "Are coins fair?", "", cells, section="coins.tossing:findings")
'''


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "elsewhere" / "coins"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "tossing.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(folder.parent)
    yield folder
    forget()


def forget() -> None:
    for module in ("coins", "coins.tossing"):
        sys.modules.pop(module, None)


def test_its_section_is_on_the_page_in_the_text_and_in_the_json(
    package: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert len(PACKAGE.strip().splitlines()) < 60
    out, text = tmp_path / "run", tmp_path / "tables.md"
    assert run(["run", "coins.tossing:COINS", "--out", str(out), "--workers", "0"]) == 0
    capsys.readouterr()
    asked = ["--experiments", "coins.tossing:COINS", "--markdown", str(text), "--json"]
    assert run(["report", str(out), *asked]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    share = found["coins"]["0.9"]
    assert 0.8 < share < 1
    sentence = f"The heavier coin falls on heads {share:.0%} of the time."
    assert sentence in told.err
    assert found["question"] == "Are coins fair?"
    page = (out / "report.html").read_text()
    section = page.partition('<section id="coins">')[2].partition("</section>")[0]
    for words in (
        *("<h2>Are the coins fair?</h2>", sentence, "Heads of 100 tosses", "Heads over tosses"),
        *('aria-label="Share of heads over tosses"', 'class="line line-0"', "share of heads</li>"),
        f">{100 * share:.1f}<",
    ):
        assert words in section
    head, _, body = page.partition("</style>")
    assert ".coin > b { top: 0 }" in head
    assert "coin(1 < 2);" in body
    assert "thesis_pgd" not in head, "the renderer holds nothing of one experiment's"
    assert '<a href="#coins">Are the coins fair?</a>' in page
    assert f"- {sentence}\n" in text.read_text()
    assert "## Heads of 100 tosses\n\n| weight | heads, % |\n| --- | --- |\n" in text.read_text()
    assert f"| 0.9 | {100 * share:.1f} |" in text.read_text()


def test_nothing_that_only_the_manifest_names_is_imported(package: Path, tmp_path: Path) -> None:
    """A run's folder may come from anywhere, and so may what it names."""
    out = tmp_path / "run"
    assert run(["run", "coins.tossing:COINS", "--out", str(out), "--workers", "0"]) == 0
    forget()
    (package / "tossing.py").write_text("raise SystemExit('run by a report')")
    assert run(["report", str(out)]) == 0
    assert "coins.tossing" not in sys.modules
    page = (out / "report.html").read_text()
    assert "A section is missing: the run names coins.tossing:findings" in page
    assert "<h1>Are coins fair?</h1>" in page
    assert 'id="coins"' not in page


def test_a_package_that_is_gone_is_named(package: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    assert run(["run", "coins.tossing:COINS", "--out", str(out), "--workers", "0"]) == 0
    package.rename(package.with_name("gone"))
    forget()
    asked = ReportRequest(experiments=["coins.tossing:COINS"])
    with pytest.raises(ConfigurationError, match=r"coins\.tossing:COINS cannot be imported"):
        run_report(RunFolder.open(out), asked)


@pytest.mark.parametrize(
    ("ours", "theirs", "problem"),
    [
        ('{"coins": {', '{"defence": {', "figures the name defence"),
        ('{"coins": {', '{"other": {', "figures the name other"),
        ('        "coins",', '        "run",', "the id run"),
    ],
)
def test_names_that_are_taken_are_refused(
    package: Path, tmp_path: Path, ours: str, theirs: str, problem: str
) -> None:
    assert PACKAGE.count(ours) == 1
    (package / "tossing.py").write_text(PACKAGE.replace(ours, theirs))
    out = tmp_path / "run"
    assert run(["run", "coins.tossing:COINS", "--out", str(out), "--workers", "0"]) == 0
    with pytest.raises(ConfigurationError, match=problem):
        run_report(RunFolder.open(out), ReportRequest(experiments=["coins.tossing:COINS"]))
