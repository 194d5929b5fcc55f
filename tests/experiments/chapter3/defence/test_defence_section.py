"""A run of the defence experiment, from cells to page, with outcomes that are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from avsec_gym.commands.report import Report
from avsec_gym.experiments.chapter3.defence.in_words import defence_sentences
from avsec_gym.experiments.chapter3.defence.plots import draw_defence
from avsec_gym.experiments.chapter3.defence.rates import DefenceRow, defence_summary
from avsec_gym.experiments.chapter3.defence.tables import tables_of_defence
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_report import run_report
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    EpisodeRow,
    Experiment,
    Measurement,
)
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder

FRAMES = ("a/0", "a/1", "b/0", "b/1", "c/0", "c/1")
DETECTED = {"a/0", "b/1"}
"""Of an attack on camera 3: at once in drive a, a frame later in b, never in c."""
NAN = float("nan")


def judged_frame(configuration: Configuration) -> Callable[..., CellResult]:
    """Under attack the undefended car collides; who detects stops, or drives on safely."""

    def work(attack: str, number: int) -> CellResult:
        id = FRAMES[number]
        is_attacked = attack != "none"
        alarm = id in DETECTED if is_attacked else id == "c/1"
        drives = []
        for response in ("undefended", "stop", "drop", "repair"):
            outcome, reason = ("collision" if is_attacked else "safe"), None
            if alarm and response == "stop":
                outcome, reason = "unplanned", "stopped"
            elif alarm and response != "undefended":
                outcome = "safe"
            record = SafetyRecord(id, "straight", outcome, NAN, 1, NAN, NAN, reason)
            drives.append(EpisodeRow(f"stereo_rcnn {attack} {response}", record))
        measurements = [
            Measurement(attack, id, "alarm", float(alarm)),
            Measurement(attack, id, "named 3", float(alarm)),
        ]
        return CellResult(drives, measurements=measurements)

    return work


def cells(configuration: Configuration) -> list[Cell]:
    return [
        Cell.of(f"{__name__}:judged_frame", "", attack=attack, number=number)
        for number in range(len(FRAMES))
        for attack in ("none", "3")
    ]


KNOWN = Experiment("known", "What is a defence worth?", "", cells)


def test_a_page_says_what_a_defence_is_worth(tmp_path: Path) -> None:
    run_experiments([KNOWN], Configuration("made_up"), tmp_path / "run", workers=0, threads=1)
    run = RunFolder.open(tmp_path / "run")
    report = run_report(run)
    json.dumps(report.data, allow_nan=False)
    assert [section.id for section in report.sections] == ["defence"]
    assert report.data["other"] == []
    summary = defence_summary(run)
    assert summary is not None
    assert report.data["defence"] == as_json(summary)
    worth, alarms = tables_of_defence(summary)
    rows = {tuple(cell.text for cell in row[1:3]): row[3:] for row in worth.rows}
    assert list(rows) == [
        (attacked, response)
        for attacked in ("nothing", "camera 3", "any of these")
        for response in ("stop", "drop", "repair")
    ]
    # Of six collisions two are avoided; a false alarm costs one of six safe drives, and is a stop.
    texts = {key: [cell.text for cell in row] for key, row in rows.items()}
    # Collide and safe undefended, safe defended; avoided, of the attack's, caused, safe again,
    # given up, stopped in.
    assert texts["camera 3", "stop"] == [
        *("100.0", "0.0", "0.0"), *("33.3", "33.3", "–", "0.0", "–", "33.3")
    ]  # fmt: skip
    assert texts["camera 3", "drop"] == [
        *("100.0", "0.0", "33.3"), *("33.3", "33.3", "–", "33.3", "–", "0.0")
    ]  # fmt: skip
    assert texts["nothing", "stop"] == [
        *("0.0", "100.0", "83.3"), *("–", "–", "0.0", "–", "16.7", "16.7")
    ]  # fmt: skip
    assert texts["nothing", "repair"] == [
        *("0.0", "100.0", "100.0"), *("–", "–", "0.0", "–", "0.0", "0.0")
    ]  # fmt: skip
    # Three drives: wider than Wilson's of six frames, [9.7, 70.0].
    assert rows["camera 3", "stop"][3].interval == "[8.8, 72.1]"
    assert [[cell.text for cell in row] for row in alarms.rows] == [
        ["nothing", "16.7", "83.3", "–", "–", "–"],
        ["camera 3", "33.3", "33.3", "33.3", "1 after 1", "33.3"],
    ]
    assert Report(run.path).run() == 0
    page = (run.path / "report.html").read_text()
    said = defence_sentences(summary)
    assert said == [
        "Stereo R-CNN: of 6 cases that collide only because of an attack, 33.3 % (stop),"
        " 33.3 % (drop), 33.3 % (repair) do not collide.",
        "Stereo R-CNN: of 6 cases that are unsafe only because of an attack, 0.0 % (stop),"
        " 33.3 % (drop), 33.3 % (repair) are safe again.",
        "Unattacked, a car that stops at alarms does so in 16.7 % of the frames.",
    ]
    assert all(sentence in page and sentence in markdown_page(report) for sentence in said)
    for hint in (
        "camera 3 attacked, undefended: 0.0 % safe",
        "camera 3 attacked, drops compromised sensors: 33.3 % safe",
        "nothing attacked, stops: 83.3 % safe",
    ):
        assert hint in page
    for title in (worth.title, alarms.title):
        assert title in page
        assert f"## {title}" in markdown_page(report)


def test_attacks_on_several_sensors_have_short_labels() -> None:
    def drawn(*attacks: str) -> str:
        half = SafetyRates(2, 1, 0, {}, NAN, NAN, NAN)
        (drawing,) = draw_defence(
            [DefenceRow("oracle", attack, "stop", half, worth=None) for attack in attacks]
        )
        return drawing

    assert 'viewBox="0 0 400 220"' in drawn("none", "1", "2", "3", "lidar")
    wide = drawn("none", "1", "1+2", "1+3", "2+3", "lidar+1", "lidar+2")
    assert float(wide.split('viewBox="0 0 ')[1].split()[0]) == 46 + 7 * 54
    assert ">LiDAR+2<" in wide
    assert ">nothing<" in wide
    assert "camera 1 and camera 2 attacked, stops: 50.0 % safe" in wide
