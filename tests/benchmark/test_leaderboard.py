"""The leaderboard: which entries are on it, in what order, with which figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.benchmark.adaptive_rows import AdaptiveRow
from avsec_gym.benchmark.connected_instants import ATTACKS, InstantsRow, adaptive_instants
from avsec_gym.benchmark.entry import Entry, EntryRow, Precision, read_entry
from avsec_gym.benchmark.kitti_scenes import KITTI, frozen_labels
from avsec_gym.benchmark.leaderboard import board, left_out
from avsec_gym.benchmark.loop_drives import DrivesRow
from avsec_gym.benchmark.loop_scenes import CLOSED_LOOP, frozen_drives
from avsec_gym.benchmark.making import entered
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.benchmark.scene_sets import frozen_sets
from avsec_gym.cli import run
from avsec_gym.drawing.page_table import Table
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED, SafetyRates, SafetyRecord
from avsec_gym.runs.fingerprints import fingerprint


def records(safe: int, of: int = 10) -> list[SafetyRecord]:
    return [
        SafetyRecord(str(n), "left", SAFE if n < safe else COLLISION, 1.0, 0, 1.0, 1.0)
        for n in range(of)
    ]


def row(scenes: str, setting: str, safe: int, **more: Any) -> EntryRow:
    given = {"collided": Share.of_counts(10 - safe, 10), "stopped": Share.of_counts(0, 10)} | more
    return EntryRow(scenes, setting, SafetyRates.of(records(safe)), **given)


def entry(kind: str, name: str, *rows: EntryRow, **more: Any) -> Entry:
    given = {"quick": False, "white_box": None, "masked": False, "budget": None} | more
    return Entry(
        version=1, kind=Entered(kind), name=name, part=name, scenes=(), rows=rows, world="abc",
        weights={}, made_by={"avsec_gym": "0.1.0"}, **given,
    )  # fmt: skip


def texts(sections: Any) -> dict[str, list[list[str]]]:
    return {s.id: [[cell.text for cell in row] for row in s.parts[0].rows] for s in sections}


def share(count: int) -> Share:
    return Share.of_counts(count, 50)


PRECISION = Precision(Estimate(31.24, (28, 35)), Estimate(30.0), Estimate(60.0), 40, 100.0)


def test_detectors_by_how_safe_contested_drives_are() -> None:
    worse = entry(
        "detector", "worse",
        row("all", "unattacked", 9, precision=PRECISION), row("contested", "unattacked", 4),
        row("contested", "white_box", 1), white_box=True, masked=True,
    )  # fmt: skip
    better = entry("detector", "better", row("contested", "unattacked", 6), white_box=False)
    (section,) = board([worse, better])
    first, second = texts([section])["detectors"]
    assert first[:6] == ["better", "black box", "–", "–", "60.0", "60.0"]
    assert second[:8] == ["worse", "white box", "–", "yes", "10.0", "40.0", "–", "10.0"]
    assert second[10] == "31.2"
    (table,) = section.parts
    assert len(table.columns) == len(first)
    assert {table.columns[index] for index in table.filters} == {
        "known to the attacker", "adaptive attack breaks it", "hides its gradients",
    }  # fmt: skip


def adaptive(measure: str, breaks: bool, setting: str = "adaptive") -> AdaptiveRow:
    return AdaptiveRow(setting, "white_box", measure, Estimate(-0.25, (-0.4, -0.1)), breaks)


def test_what_an_adaptive_attack_breaks_is_flagged() -> None:
    def detector(name: str, *breaks: bool) -> Entry:
        rows = [row("contested", "unattacked", 8), row("contested", "adaptive", 3)]
        tried = [adaptive("safe", each) for each in breaks]
        return entry("detector", name, *rows, white_box=True, adaptive=tried)

    (section,) = board([detector("broken", True), detector("holds", False), detector("unknown")])
    cells = {cells[0].text: cells[2] for cells in section.parts[0].rows}
    assert {name: cell.text for name, cell in cells.items()} == {
        "broken": "yes", "holds": "no", "unknown": "–",
    }  # fmt: skip
    assert cells["broken"].tone == "bad"
    assert "−25.0 points of safe, against white_box" in cells["broken"].hint
    # The worst that is known of it is its robust rate.
    assert [cells[4].text for cells in section.parts[0].rows] == ["30.0"] * 3
    validator = entry(
        "validator", "watch",
        row("contested", "facula adaptive validated", 4, alarms=share(5)),
        adaptive=[
            adaptive("collided", False, "lidar_spoofing adaptive validated"),
            adaptive("collided", True, "facula adaptive validated"),
        ],
    )  # fmt: skip
    (section,) = board([validator])
    (table,) = section.parts
    by_column = dict(zip(table.columns, table.rows[0], strict=True))
    assert by_column["adaptive attack breaks it"].text == "yes"
    assert by_column["alarms, facula, adaptive, %"].text == "10.0"
    assert by_column["collisions, facula, adaptive, %"].text == "60.0"


def test_attacks_validators_and_planners() -> None:
    before, after = records(8), records(2)
    paired = paired_differences(before, after)
    attack = entry(
        "attack", "light", row("contested", "dsgn attacked", 2, paired=paired),
        budget={"change": 4.0, "area": None}, white_box=True,
    )  # fmt: skip
    stops = SafetyRates.of(
        replace(each, outcome=UNPLANNED, reason="stopped") for each in records(0, 4)
    )
    validator = entry(
        "validator", "watch",
        replace(
            row("all", "unattacked validated", 9, alarms=share(1)), rates=stops,
            stopped=Share.of_counts(4, 4),
        ),
        row("all", "facula validated", 9, alarms=share(40), named=share(30)),
        row("contested", "facula validated", 9), row("contested", "facula", 7),
    )  # fmt: skip
    planner = entry("planner", "astar", row("all", "truth", 9), row("contested", "truth", 10))
    found = texts(board([planner, validator, attack]))
    assert [*found] == ["attacks", "validators", "planners"]
    assert found["attacks"] == [
        ["light", "white box", "4.0", "all", "20.0", "–", "−60.0", "–", "–", "–"]
    ]  # fmt: skip
    assert found["validators"] == [
        ["watch", "–", "2.0", "80.0", "–", "60.0", "–", "100.0", "10.0", "30.0", *["–"] * 6]
    ]  # fmt: skip
    assert found["planners"][0][:4] == ["astar", "90.0", "100.0", "10.0"]


def test_the_closed_loop_has_a_table_of_its_own() -> None:
    def car(setting: str, at_fault: int, score: float, **more: Any) -> DrivesRow:
        return DrivesRow(
            setting, 20, share(at_fault), share(at_fault), share(0), share(50 - at_fault),
            Estimate(0.9), Estimate(score, (0.2, 0.8)), **more,
        )  # fmt: skip

    patch = {"name": "patch", "patch": "joint"}
    worse = entry(
        "detector", "worse", row("contested", "unattacked", 6),
        drives=(
            car("unattacked", 5, 0.7),
            car("patch", 30, 0.4, against="unattacked", attack=patch, white_box=False,
                navsim_difference=Estimate(-0.3, (-0.4, -0.2))),
        ),
    )  # fmt: skip
    better = entry(
        "detector", "better", row("contested", "unattacked", 4),
        drives=(car("unattacked", 1, 0.8),),
    )  # fmt: skip
    (section,) = board([worse, better, entry("detector", "none", row("all", "unattacked", 5))])
    _, table = section.parts
    assert isinstance(table, Table)
    assert [[cell.text for cell in cells][:4] for cells in table.rows] == [
        ["better", "unattacked", "–", "2.0"], ["worse", "unattacked", "–", "10.0"],
        ["worse", "patch", "black box", "60.0"],
    ]  # fmt: skip
    assert table.filters == (1, 2)
    assert [cell.text for cell in table.rows[2]][-2:] == ["40.0", "−30.0"]
    assert "joint" in table.rows[2][1].hint
    assert all(len(cells) == len(table.columns) for cells in table.rows)


def test_validators_of_several_vehicles_have_a_table_of_their_own() -> None:
    def judged(name: str, area: float) -> Entry:
        attack = {
            "detected": share(20), "decidable": share(30), "of_decidable": share(20),
            "victim": share(10), "another": share(1), "cannot_tell": share(9),
            "area": Estimate(area, (0.5, 1.0)), "at_rate": share(25),
        }  # fmt: skip
        rows = [InstantsRow("unattacked", 50, share(2), share(1))]
        for kind in (*ATTACKS, adaptive_instants("ghost")):
            rows.append(InstantsRow(kind, 50, share(30), share(1), **attack))
        tried = [adaptive("detected", True, adaptive_instants("ghost"))]
        return entry("validator", name, instants=rows, adaptive=tried)

    (section,) = board([judged("worse", 0.8), judged("better", 0.97)])
    (table,) = section.parts
    assert isinstance(table, Table)
    first, second = ([cell.text for cell in cells] for cells in table.rows)
    assert first[:6] == ["better", "yes", "4.0", "2.0", "97.0", "50.0"]
    assert second[4:10] == ["80.0", "50.0", "40.0", "20.0", "2.0", "18.0"] == second[10:16]
    assert second[16:] == ["40.0", "–"]
    assert len(first) == len(table.columns)
    # One of a single vehicle stands beside it in a table of its own.
    (both,) = board([judged("several", 0.9), entry("validator", "one", row("all", "facula", 9))])
    assert len(both.parts) == 2


def test_what_is_left_out() -> None:
    fine = entry("planner", "astar", row("all", "truth", 9))
    assert left_out(fine) == ""
    assert "--quick" in left_out(replace(fine, quick=True))
    assert "version 2" in left_out(replace(fine, version=2))
    assert "3 scenes" in left_out(replace(fine, failed=3))


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import json

    def kept(name: str, one: Entry) -> Path:
        path = tmp_path / name / "entry.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps(one.to_json()))
        return path

    fine = entry("planner", "astar", row("all", "truth", 9))
    kept("runs/one", fine)
    page = tmp_path / "board.html"
    words = ["benchmark", "board", str(tmp_path / "runs"), "--out", str(page)]
    assert run(words) == 0
    assert "1 entry" in page.read_text()
    assert "90.0" in page.read_text()
    assert run(words) == 1, "a page is not written over"
    kept("runs/two", replace(fine, quick=True))
    assert run([*words, "--overwrite"]) == 3
    assert "left out" in capsys.readouterr().err
    kept("runs/three", fine).write_text("{}")
    assert run([*words, "--overwrite"]) == 3, "one that is damaged leaves the others"
    assert "three" in capsys.readouterr().err
    quick = str(tmp_path / "runs/two/entry.json")
    assert run(["benchmark", "board", quick, "--out", str(tmp_path / "none.html")]) == 1
    assert run(["benchmark", "board", str(tmp_path / "nothing")]) == 1


SHARED = Path(__file__).parents[3] / "shared"
KEPT = sorted((Path(__file__).parents[2] / "leaderboard").glob("*/entry.json"))


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.parent.name)
def test_entries_of_the_repository_are_of_todays_benchmark(path: Path) -> None:
    kept = read_entry(path)
    assert left_out(kept) == ""
    digests = {name: frozen.digest for name, frozen in frozen_sets().items()}
    digests[CLOSED_LOOP] = frozen_drives().digest
    if KITTI in {row.scenes for row in kept.scenes}:
        digests[KITTI] = frozen_labels().digest
    assert {row.scenes: row.digest for row in kept.scenes} == {
        name: digest for name, digest in digests.items() if name not in kept.skipped
    }
    assert "/" not in kept.made_by["platform"]


def of_shared(kept: Entry) -> tuple[dict[str, str], Path]:
    """The results that an entry was made of, and the labels; they are no part of the project."""
    labels = SHARED / "safety_scenarios"
    folders = [*(SHARED / "detections").iterdir()] if labels.is_dir() else []
    for folder in folders:
        if fingerprint(folder) == kept.part["results"]:
            return {"name": "replayed", "detections": str(folder)}, labels
    pytest.skip("../shared with these detections is absent")


def figures_of(value: Any, place: str = "") -> dict[str, Any]:
    """What lists and objects of JSON hold, by its place."""
    if isinstance(value, dict):
        items = list(value.items())
    elif isinstance(value, (list, tuple)):
        items = list(enumerate(value))
    else:
        return {place: value}
    return {
        name: figure
        for key, each in items
        for name, figure in figures_of(each, f"{place}.{key}").items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.parent.name)
def test_entries_of_the_repository_are_made_again(path: Path, tmp_path: Path) -> None:
    kept = read_entry(path)
    labels = None
    if KITTI in {row.scenes for row in kept.scenes}:
        part, labels = of_shared(kept)
    elif kept.kind.sees:
        pytest.skip("takes half an hour")
    else:
        part = kept.part
    made = entered(kept.kind, part, tmp_path, labels=labels, workers=0)
    found, before = (
        figures_of([entry.to_json()[name] for name in ("rows", "drives")]) for entry in (made, kept)
    )
    assert found.keys() == before.keys()
    # Processors differ in the last bits of sums.
    for name, figure in before.items():
        assert found[name] == (pytest.approx(figure) if isinstance(figure, float) else figure), name
