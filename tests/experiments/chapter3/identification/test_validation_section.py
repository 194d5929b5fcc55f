"""A run of chapter 3, from cells to page, with sensors whose answers are known."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avsec_gym.commands.report import Report
from avsec_gym.experiments.chapter3.attacks import BEYOND
from avsec_gym.experiments.chapter3.identification import summary as chapter_3
from avsec_gym.experiments.chapter3.identification.adaptive_attacks import (
    DIM,
    FAR,
    KINDS,
    states_of,
)
from avsec_gym.experiments.chapter3.identification.in_words import validation_sentences
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import alone, bits, measured
from avsec_gym.experiments.chapter3.identification.tables import unseen_table
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_report import run_report
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    Experiment,
    Measurement,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.validation.evidence.evidence import evidence_elements
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.state_posterior import state_vectors

pytestmark = pytest.mark.slow

FRAMES = 24
HIDDEN_FROM_E = 3
"""Position of a camera whose attacks leave E as it is, and are seen by brightness alone."""


def judged_frame(configuration: Configuration) -> Any:
    def work(part: str, number: int) -> CellResult:
        random = np.random.default_rng([part == "judged", number])
        rows = []
        every = state_vectors(len(SYSTEM))
        states = [(part, state) for state in every]
        if part == "judged":
            states += [(kind, state) for kind in BEYOND for state in alone(every)]
            for kind, way in KINDS.items():
                states += [(kind, state) for state in states_of(way, len(SYSTEM))]
        id = f"drive_{number:03d}/0"
        for kind, state in states:
            setting = f"{kind} {bits(state)}"
            for name, scope in evidence_elements(SYSTEM):
                seen = [sensor for sensor in scope if state[sensor]]
                if name not in ("brighter", "darker"):
                    seen = [sensor for sensor in seen if sensor != HIDDEN_FROM_E]
                share = random.uniform(0.01, 0.05) + (0.4 if seen else 0.0)
                rows.append(Measurement(setting, id, measured(name, scope), share))
            for triple in SYSTEM.triples:
                name = measured("hole_share", triple)
                rows.append(Measurement(setting, id, name, 0.1))
                lit = 0.4 if any(state[sensor] for sensor in triple) else 0.0
                name = measured("brightness", triple)
                rows.append(Measurement(setting, id, name, random.uniform(0.01, 0.05) + lit))
        return CellResult(measurements=rows)

    return work


def cells(configuration: Configuration) -> list[Cell]:
    work = f"{__name__}:judged_frame"
    return [
        Cell.of(work, "", part=part, number=number)
        for part in ("fitted", "judged")
        for number in range(configuration.limit or FRAMES)
    ]


KNOWN = Experiment("known", "Is it detected?", "Chapter 3", cells)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunFolder:
    on = FittedOn(SYSTEM, {"name": "sgbm"}, (195.0, 195.0), {"made": "up"})
    monkeypatch.setattr(chapter_3, "fitted_to", lambda configuration: on)
    run_experiments([KNOWN], Configuration("made_up"), tmp_path / "run", workers=0, threads=1)
    return RunFolder.open(tmp_path / "run")


def test_a_page_shows_what_sensors_detect(
    run: RunFolder, capsys: pytest.CaptureFixture[str]
) -> None:
    report = run_report(run)
    json.dumps(report.data, allow_nan=False)
    summary = report.data["validation"]
    rows = {(row["scenario"], row["criterion"], row["rate"]): row for row in summary["detection"]}
    for scenario in ("LiDAR and two cameras", "three cameras"):
        # One of the seven cases is an attack on the camera that E does not see.
        alone = rows[scenario, "error", 0.0]
        assert alone["cases"]["S3"] == pytest.approx(0.0, abs=0.2)
        assert alone["average"] == pytest.approx(6 / 7, abs=0.05)
        assert rows[scenario, "any", 0.0]["average"] == 1.0
    named = {(row["method"], row["rate"]): row for row in summary["identification"]}
    assert named["algorithm 2, any", 0.0]["sensors"]["S3"]["rate"] > 0.9
    assert named["algorithm 2, error", 0.0]["sensors"]["S3"]["rate"] < 0.2
    assert named["maximum likelihood", 0.01]["average"] > 0.9
    assert Report(run.path).run() == 0
    said = capsys.readouterr().err
    assert validation_sentences(row_of(chapter_3.ValidationSummary, summary))[0] in said
    page = (run.path / "report.html").read_text()
    for words in ("thesis, table 3.1", "thesis, table 3.2", "99.89", "98.15", "1 m wide"):
        assert words in page
    for figure, panels in (("3.5", 7), ("3.6", 8), ("3.7", 7), ("3.8", 8), ("3.9", 15)):
        box = page.partition(f"thesis, figure {figure}<")[2].partition("</ul>")[0]
        assert box.count("<svg") == panels
    box = page.partition("thesis, figure 3.10<")[2].partition("</ul>")[0]
    assert box.count("<svg") == 4
    assert "The thesis, r = 1 %: 97.60" in box
    assert "of 24 drives" in page
    # A point for each tenth of probability that was predicted.
    both = (summary["calibration"], summary["calibration"]["all_alike"])
    assert page.count('data-hint="predicted ') == sum(
        len(figures["reliability"]) for figures in both
    )
    # The mean of all cases, with the thesis beside it.
    box = page.partition("thesis, figure 3.8<")[2].partition("</ul>")[0]
    assert "The thesis, r = 1 %: 99.97" in box
    text = markdown_page(report)
    told = {(row["kind"], *row["attacked"]): row for row in summary["adaptive_attacks"]}
    assert len(told) == sum(len(kind.attacked) for kind in KINDS.values())
    for row in told.values():
        for share in (*row["detected"].values(), row["named_likeliest"]):
            assert share["of"] == FRAMES
    # Only the first scenario has a LiDAR, only the second one the rightmost camera.
    assert list(told[FAR, 0]["detected"]) == ["LiDAR and two cameras"]
    assert list(told[DIM, 1]["detected"]) == ["three cameras"]
    assert told[DIM, 1]["detected"]["three cameras"]["rate"] > 0.9
    assert told[DIM, 1]["named_likeliest"]["rate"] > 0.9 > 0.1 > told[DIM, 1]["accused"]["rate"]
    assert "## Adaptive attacks" in text
    assert "## Table 3.2" in text
    assert "a bogus return that hides what is behind it" in text
    assert "## Status that maximum likelihood reports" in text
    # Curves know more rates than tables.
    assert len(text.partition("## Table 3.1")[2].partition("##")[0].strip().splitlines()) < 30
    assert "*98.15*" in text


def test_frames_that_were_looked_at_are_left_out_once(
    run: RunFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [SimpleNamespace(id=f"drive_{number:03d}/0") for number in range(FRAMES)]
    monkeypatch.setattr(chapter_3, "recordings_of", lambda *_: SimpleNamespace(frames=frames))
    whole = run_report(run).data["validation"]
    assert whole["unseen"] is None
    some, none = (
        chapter_3.validation_summary(run, run.configuration, looked_at) for looked_at in (5, FRAMES)
    )
    assert some is not None
    assert some.unseen is not None
    assert (some.unseen.looked_at, some.unseen.frames) == (5, FRAMES - 5)
    assert [row.scenario for row in some.unseen.detection] == list(SCENARIOS)
    assert {row.rates.rate for row in some.unseen.identification} == {0.01}
    assert none is not None
    assert none.unseen is None
    assert "19 frames that were not looked at" in unseen_table(some.unseen).title


def test_too_few_frames_are_not_summed_up(tmp_path: Path) -> None:
    configuration = Configuration("made_up", limit=3)
    run_experiments([KNOWN], configuration, tmp_path / "few", workers=0, threads=1)
    report = run_report(RunFolder.open(tmp_path / "few"))
    assert report.data["validation"] is None
    assert report.data["question"] == "Is it detected?"
