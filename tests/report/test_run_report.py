"""A report says what its run says: all of it, no more, whatever it is."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from avsec_gym.commands.report import Report
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter5 import attacked_episodes, patch_spreads
from avsec_gym.experiments.chapter5.section import pictures
from avsec_gym.experiments.chapter5.section.findings import outcomes_of
from avsec_gym.experiments.chapter5.section.scene_strip import amplified, scene_strips
from avsec_gym.experiments.chapter5.section.telling_scenes import (
    COLLAPSE,
    PATCHED,
    TEXTURED,
    telling_scenes,
)
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.report.html import html_page
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_remarks import remarks
from avsec_gym.report.run_report import RunReport, run_report
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest

pytestmark = pytest.mark.slow


def test_figures_are_those_of_the_run(run: RunFolder, report: RunReport) -> None:
    json.dumps(report.data, allow_nan=False)
    assert report.data["scenarios"] == 6
    assert remarks(report) == []
    row = next(
        row
        for row in report.data["safety"]
        if (row["detector"], row["attack"], row["strength"], row["intention"], row["whole_levels"])
        == ("stereo_rcnn", "patch-random", 0, "left", False)
    )
    records = run.records(setting="stereo_rcnn patch-random", intention="left")
    assert row["safe_driving_rate"] == SafetyRates.of(records).safe_driving_rate
    assert row["thesis"]["safe"] == 0.689
    parts = report.data["timings"]["parts"]
    assert set(parts) == {"attack", "detector", "planner", "spread"}
    assert {row["detector"] for row in report.data["safety"]} == {"dsgn", "stereo_rcnn"}
    assert report.data["other"] == []
    assert report.data["cells"] == {"done": len(run.cells()), "failed": 0, "missing": 0}


def test_a_page_holds_everything_it_needs(page: Path) -> None:
    text = page.read_text()
    parsed = Parsed()
    parsed.feed(text)
    assert not parsed.open
    assert all(link.startswith(("#", "data:")) for link in parsed.links), parsed.links
    retextured = text.count("retextured, thesis PGD α 1, n 4</sp")
    # Of each strip two views and a difference; of each detector, on noise and on scenes, two maps.
    assert text.count("data:image/webp;base64,") == 3 * 3 + retextured + 2 * 2 * 3
    ids = set(re.findall(r'id="([\w-]+)"', text))
    assert {link[1:] for link in parsed.links if link.startswith("#")} <= ids
    assert "story" not in ids  # The demo shares these cells, and has a page of its own.
    for words in (
        *("thesis, table 5.2", "thesis, table 5.7", "thesis, figure 5.3", "McNemar"),
        *("Sanity sheet", "Flips", "thesis, section 5.5.1", "thesis, section 5.5.2"),
        *("<h3>How far a patch spreads", '<small class="theirs">thesis, figure 5.8</small>'),
    ):
        assert words in text


def test_reasons_are_told(report: RunReport) -> None:
    """What the drawn detections and maps were made to say."""
    ghosts = {(row["detector"], row["attack"]): row for row in report.data["ghosts"]}
    assert ("stereo_rcnn", "patch-specific") not in ghosts
    strong = ghosts["dsgn", "thesis_pgd-1"]
    assert strong["strength"] == 4
    assert strong["share_on_road"] < 0.1
    assert strong["ghosts"] == sum(map(len, strong["positions"].values()))
    assert [row["attack"] for row in report.data["pyramid"]] == [
        "unattacked", "patch-random", "patch-specific"
    ]  # fmt: skip
    radii = [row["radius"] for row in report.data["spread"] if row["detector"] == "dsgn"]
    assert radii == [10, 20, 10, 20]
    text = markdown_page(report)
    assert "| DSGN | conv2 | 2.0 | 2.0 | 2.0 | 2.0 | 4.0 |" in text
    assert "no file of the joint patch of DSGN, Stereo R-CNN" in text
    assert "no weights were given (--options dsgn_without_pyramid=FILE)" in text


def test_a_run_that_is_not_finished_says_so(torso: RunFolder) -> None:
    report = run_report(torso)
    told = " ".join(remarks(report))
    assert "not finished" in told
    assert re.search(r"1 of \d+ cells failed", told)
    assert "specific patch on DSGN" in told
    # The last scene lacks everything, the fourth the random patch on DSGN.
    assert report.data["scenarios"] == 4
    assert "patch-specific" not in {row["attack"] for row in report.data["safety"]}
    text = html_page(report)
    assert "the &lt;printer&gt; is out of paper" in text
    assert "not finished" in text
    assert "not finished" in markdown_page(report)


def test_a_run_of_a_third_party_is_shown_by_its_settings(
    drawn: ModuleType, frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "runs")
    import tiny_experiments

    root = tmp_path / "tiny"
    asked = Configuration(limit=2)
    run_experiments([tiny_experiments.PRECISION], asked, root, workers=0, threads=1)
    report = run_report(RunFolder.open(root))
    assert report.data["question"] == "Does the detector still see?"
    assert {row["setting"] for row in report.data["other"]} == {"none", "weak"}
    assert "weak" in html_page(report)
    assert "| weak |" in markdown_page(report)


def test_only_episodes_on_the_ground_truth_make_a_page(frames: Path, tmp_path: Path) -> None:
    from avsec_gym.experiments.chapter5.experiments import PLANNERS

    asked = Configuration(str(frames), 2)
    run_experiments([PLANNERS], asked, tmp_path / "planners", workers=0, threads=1)
    report = run_report(RunFolder.open(tmp_path / "planners"))
    assert "answer" not in report.data
    text = html_page(report)
    assert "Table 5.6" in text
    assert "Table 5.1" not in text


def test_scenes_are_chosen_by_their_rules(run: RunFolder) -> None:
    outcomes = outcomes_of(run)
    chosen = telling_scenes(outcomes, 8)
    assert len({episode.scenario for episode in chosen}) == len(chosen) <= 6
    for episode in chosen:
        clean, attacked = (
            {record.intention: record.safe for record in outcomes.records(condition)
             if record.scenario == episode.scenario}
            for condition in episode.conditions[:2]
        )  # fmt: skip
        if episode.rule == COLLAPSE:
            assert all(clean.values())
            assert all(attacked.values())
        elif episode.rule != TEXTURED:
            assert clean[episode.intention]
            assert not attacked[episode.intention]
        if episode.rule == PATCHED:
            assert "patch" in episode.conditions[1].attack
    assert telling_scenes(outcomes, 8) == chosen
    assert telling_scenes(outcomes, 2) == chosen[:2]
    assert telling_scenes(outcomes, 0) == []


def test_pictures_are_of_the_stored_episodes(run: RunFolder, drawn: ModuleType) -> None:
    outcomes = outcomes_of(run)
    telling = telling_scenes(outcomes, 6)
    episodes = drawn.DrawnEpisodes(run.configuration)
    (strip,) = scene_strips(telling[:1], outcomes, episodes)
    assert all(view.as_stored for view in strip.views)
    assert (strip.factor, strip.largest) == (31, 4.0)
    assert len(strip.views[0].real) == len(outcomes.labels[telling[0].scenario])

    class Other(drawn.DrawnEpisodes):  # type: ignore[misc, name-defined]
        """Under an attack the search takes a node more than when it was stored."""

        def again(self, detector: str, attack: str, *rest: Any, **options: Any) -> Any:
            done = super().again(detector, attack, *rest, **options)
            record = done.episode.record
            record = replace(record, expanded=record.expanded + (attack != "unattacked"))
            return replace(done, episode=replace(done.episode, record=record))

    (strip,) = scene_strips(telling[:1], outcomes, Other(run.configuration))
    assert [view.as_stored for view in strip.views] == [True, False]


def test_a_process_repeats_an_episode_once(
    run: RunFolder, drawn: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    repeated: list[str] = []

    class Counted(drawn.DrawnEpisodes):  # type: ignore[misc, name-defined]
        def again(
            self, detector: str, attack: str, scenario: str, *rest: Any, **options: Any
        ) -> Any:
            repeated.append(scenario)
            return super().again(detector, attack, scenario, *rest, **options)

    monkeypatch.setattr(attacked_episodes, "AttackedEpisodes", Counted)
    monkeypatch.setattr(pictures, "_strips_made", cache(lambda run, started: {}))
    outcomes = outcomes_of(run)
    first, second, third = (telling.scenario for telling in telling_scenes(outcomes, 3))
    two, _ = pictures.strips_of(run, outcomes, ReportRequest(2))
    assert set(repeated) == {first, second}
    repeated.clear()
    three, problems = pictures.strips_of(run, outcomes, ReportRequest(3))
    assert set(repeated) == {third}
    assert three[:2] == two
    assert not problems


def test_differences_are_amplified_as_far_as_they_fit() -> None:
    before = np.full((2, 2, 3), 100, np.uint8)
    after = before.astype(np.float32)
    after[0, 0] += 1.6
    after[1, 1] -= 0.8
    picture, factor, largest = amplified(before, after)
    assert factor == 79
    assert largest == pytest.approx(1.6)
    assert (picture[0, 0, 0], picture[0, 1, 0], picture[1, 1, 0]) == (254, 128, 65)
    assert amplified(before, before)[1:] == (1, 0.0)


def test_the_command_writes_page_and_tables(
    run: RunFolder,
    drawn: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(attacked_episodes, "AttackedEpisodes", drawn.DrawnEpisodes)
    monkeypatch.setattr(patch_spreads, "PatchSpreads", drawn.DrawnSpreads)
    page, tables = tmp_path / "a.html", tmp_path / "a.md"
    command = Report(run.path, out=page, markdown=tables, pictures=1, json=True)
    assert command.run() == 0
    assert page.read_text().count("data:image/webp") >= 3 + 2 * 2 * 3
    assert not (run.figures / "feature_spread.png").exists()
    assert "| DSGN |" in tables.read_text()
    assert json.loads(capsys.readouterr().out)["scenarios"] == 6
    with pytest.raises(DataError, match="exists"):
        command.run()


def test_without_weights_there_is_a_page_without_pictures(
    run: RunFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(configuration: Configuration) -> None:
        raise DataError("there are no weights.")

    monkeypatch.setattr(attacked_episodes, "AttackedEpisodes", none)
    monkeypatch.setattr(patch_spreads, "PatchSpreads", none)
    copied = tmp_path / "run"  # Pictures that were drawn of the run before are there still.
    shutil.copytree(run.path, copied)
    assert Report(copied, pictures=1).run() == 3
    assert "data:image/webp" not in (copied / "report.html").read_text()


class Parsed(HTMLParser):
    """Links, and elements that are not closed."""

    VOID = ("meta", "link", "input", "img", "br")

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attributes if name in ("src", "href")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag
