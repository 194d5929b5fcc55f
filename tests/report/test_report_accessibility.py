"""Every kind of page can be read by every reader: axe-core, and what it leaves out."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from matplotlib.figure import Figure

from avsec_gym.cli import run
from avsec_gym.commands.drive_results import PAGE
from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.experiments.chapter3.defence.rates import DefenceSummary
from avsec_gym.experiments.chapter3.defence.section import defence_section
from avsec_gym.experiments.chapter3.identification.five_sensors import FiveSummary
from avsec_gym.experiments.chapter3.identification.five_sensors_section import five_section
from avsec_gym.experiments.chapter3.identification.section import validation_section
from avsec_gym.experiments.chapter3.identification.summary import ValidationSummary
from avsec_gym.experiments.chapter3.localisation.rates import LocalisationSummary
from avsec_gym.experiments.chapter3.localisation.repair_pictures import RepairPicture
from avsec_gym.experiments.chapter3.localisation.section import localisation_section
from avsec_gym.experiments.chapter3.objects.section import optical_section
from avsec_gym.experiments.chapter3.objects.tables import OpticalSummaries
from avsec_gym.experiments.chapter4.section import connected_section
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter5 import attacked_episodes, scenes
from avsec_gym.experiments.demo import drive_on
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.report.html import html_page
from avsec_gym.report.run_facts import OtherRates, RunFacts
from avsec_gym.report.run_report import RunReport, run_report
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, Section

pytestmark = pytest.mark.slow

RESULTS = Path(__file__).parents[2] / "studies" / "results"
PAGES = (
    "page", "torso", "identification_sgbm", "five_sensors", "optical_attacks", "believed",
    "localisation", "defence", "chapter4", "other", "drives", "demo", "leaderboard",
)  # fmt: skip
"""The run of `conftest`, whole and in part; committed results; a run of other settings; the pages
of `avsec drive`, `avsec demo` and `avsec benchmark board`."""
SECTIONS: dict[str, Callable[[Any], Section]] = {
    "validation": lambda figures: validation_section(row_of(ValidationSummary, figures)),
    "five_sensors": lambda figures: five_section(row_of(FiveSummary, figures)),
    "defence": lambda figures: defence_section(row_of(DefenceSummary, figures)),
    "connected": lambda figures: connected_section(row_of(ConnectedSummary, figures)),
}
"""Of committed results, by the names of their figures."""
IDS = (
    "scenes", "losses", "precision", "safety", "ghosts", "spread", "controls", "flips",
    "validation", "five", "optical", "localisation", "defence", "connected", "other", "run",
)  # fmt: skip
"""Of all sections."""
LOOKS = (("light", 1280), ("dark", 390), ("light", 390), ("dark", 1280))
RULES = """
() => axe.run(document, {
  runOnly: {type: "tag", values: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]},
  rules: {"empty-table-header": {enabled: true}},
  resultTypes: ["violations"],
}).then((found) => found.violations.map((one) => `${one.id}: ${one.nodes[0].html}`))
"""
OPENED = """
() => {
  for (const one of document.querySelectorAll("details")) one.open = true;
  // Rows of one table look alike.
  for (const one of document.querySelectorAll("tbody tr:nth-child(n + 15)")) one.remove();
}
"""
TABLE = "<table><tr><th>{}</th><th>b</th></tr><tr><td>1</td><td>2</td></tr></table>"
DRAWING = "<svg viewBox='0 0 100 20' style='width: {}px'><text y='15' {}>i</text></svg>"
FAULTS = {
    "color-contrast": "<p style='color: #8b95a1'>faint words</p>",
    "empty-table-header": TABLE.format(""),
    "11.00 px": "<p style='font-size: 11px'>small words</p>",
    "10.00 px": DRAWING.format(50, "font-size='20'"),
    "contrast 3": DRAWING.format(100, "font-size='15' fill='#8b95a1'"),
    "a heading without words": TABLE.format(" "),
}
"""What has to be said of each."""


@pytest.fixture(scope="module")
def source(
    page: Path,
    torso: RunFolder,
    drawn: ModuleType,
    frames: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Callable[[str], str]:
    """The HTML of one of `PAGES`."""

    def of(name: str) -> str:
        if name == "page":
            return page.read_text()
        if name == "torso":
            return html_page(run_report(torso))
        if name == "drives":
            folder = tmp_path_factory.mktemp("drives") / "out"
            asked = f"drive --scenarios layouts --limit 2 --settings truth blind --out {folder}"
            assert run(asked.split()) == 0
            return (folder / PAGE).read_text()
        if name == "demo":
            return demo_page(drawn, tmp_path_factory.mktemp("demo"))
        if name == "leaderboard":
            board = tmp_path_factory.mktemp("board") / "leaderboard.html"
            asked = f"benchmark board {RESULTS.parents[1] / 'leaderboard'} --out {board}"
            assert run(asked.split()) == 0
            return board.read_text()
        if name == "other":
            base = json.loads((RESULTS / "five_sensors.json").read_text())
            other = [
                row_of(OtherRates, {**row, "setting": "mine"})
                for row in run_report(torso).data["safety"]
            ]
            return html_page(RunReport(row_of(RunFacts, base), other=other))
        report = json.loads((RESULTS / f"{name}.json").read_text())
        sections = [of(report[part]) for part, of in SECTIONS.items() if report.get(part)]
        if any(report.get(part) for part in ("baseline", "impact", "believed", "sensitivity")):
            sections.append(optical_section(row_of(OpticalSummaries, report)))
        if name == "localisation":
            figure = Figure(figsize=(4, 2), dpi=50)
            figure.subplots().plot([0, 1])
            image = embedded(picture_array(figure))
            repair = RepairPicture("facula", "facula: 000000", figure, image, as_stored=False)
            sections = [
                localisation_section(row_of(LocalisationSummary, report["localisation"]), [repair])
            ]
        return html_page(RunReport(row_of(RunFacts, report), [Findings(sections)]))

    return of


def demo_page(drawn: ModuleType, folder: Path) -> str:
    """The page of a demo whose detections are drawn, and in which nothing is rendered."""
    sees = {drive_on.UNATTACKED: "truth", drive_on.ATTACKED: "blind", drive_on.DEFENDED: "truth"}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(attacked_episodes, "AttackedEpisodes", drawn.DrawnEpisodes)
        patched.setattr(
            scenes, "procedural_frames",
            lambda count, seed, contested: drawn.write_frames(folder / "frames", count),
        )  # fmt: skip
        patched.setattr(
            drive_on, "SETTINGS",
            tuple(DriveSetting(name, {"perception": what}) for name, what in sees.items()),
        )  # fmt: skip
        scenes._scenes.cache_clear()
        asked = f"demo --scenarios 4 --workers 0 --out {folder / 'out'}"
        assert run(asked.split()) == 0
    scenes._scenes.cache_clear()
    return (folder / "out" / "report.html").read_text()


@pytest.fixture
def tab_of(browser: Any, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    contexts = []

    def open_(html: str, scheme: str = "light", width: int = 1280) -> Any:
        # Its own policy lets the page load no scripts, axe-core's neither.
        context = browser.new_context(
            viewport={"width": width, "height": 800}, color_scheme=scheme, bypass_csp=True
        )
        contexts.append(context)
        path = tmp_path / "page.html"
        path.write_text(html)
        tab = context.new_page()
        tab.goto(path.as_uri())
        tab.evaluate(OPENED)
        return tab

    yield open_
    for context in contexts:
        context.close()


def by_axe(tab: Any) -> list[str]:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    tab.evaluate((resources.files(axe) / "axe.min.js").read_text())
    return list(tab.evaluate(RULES))


def beyond_axe(tab: Any) -> list[str]:
    script = (Path(__file__).parent / "accessibility.js").read_text()
    return list(tab.evaluate(script.partition("\n")[2]))


@pytest.mark.parametrize("name", PAGES)
def test_every_kind_of_page_can_be_read(
    tab_of: Callable[..., Any], source: Callable[[str], str], name: str
) -> None:
    html = source(name)
    for scheme, width in LOOKS:
        tab = tab_of(html, scheme, width)
        assert beyond_axe(tab) == [], (scheme, width)
        assert tab.evaluate("document.documentElement.scrollWidth") <= width, (scheme, width)
        # Colours depend on the scheme, what else axe-core asks for on the width.
        if (scheme, width) in LOOKS[:2]:
            assert by_axe(tab) == [], (scheme, width)
        tab.close()


def test_all_sections_are_on_some_page(source: Callable[[str], str]) -> None:
    every = "".join(source(name) for name in PAGES)
    assert [section for section in IDS if f'<section id="{section}">' not in every] == []
    assert 'id="failures"' in every


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_planted_is_found(tab_of: Callable[..., Any], fault: str) -> None:
    start = (
        "<!doctype html><html lang='en'><title>t</title><main style='background: #fff'><h1>t</h1>"
    )
    clean, planted = (tab_of(f"{start}{html}</main></html>") for html in ("", FAULTS[fault]))
    assert by_axe(clean) + beyond_axe(clean) == []
    assert any(complaint.startswith(fault) for complaint in by_axe(planted) + beyond_axe(planted))
