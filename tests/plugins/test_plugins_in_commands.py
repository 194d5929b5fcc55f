"""Every command takes the parts and the experiment of another package by their names."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.report.run_report import run_report
from avsec_gym.runs.run_folder import RunFolder

DETECTOR = json.dumps({"name": "stereo_clusters", "disparities": 32})
ATTACK = json.dumps({"name": "shifted_image", "pixels": 5})
STEADY = json.dumps({"name": "lane_change", "hardest": 0.0})
"""It keeps its 6 m/s, and is in the goal region, which begins at 12.5 m, after 2.1 s."""


def depths(folder: Path) -> list[list[float]]:
    """How far ahead the boxes of each frame are, the nearest first."""
    texts = [file.read_text() for file in sorted(folder.glob("0*.txt"))]
    return [sorted(float(line.split()[13]) for line in text.splitlines()) for text in texts]


def test_a_planner_in_evaluate(avsec: Any, data: Path, tmp_path: Path) -> None:
    common = ["evaluate", "--scenarios", data / "training/label_2", "--intention", "straight"]
    (row,) = json.loads(avsec(*common, "--planner", "lane_change", "--json").stdout)["rates"]
    assert (row["planner"], row["planned"], row["scenarios"]) == ("lane_change", 3, 3)
    # On detections, with pictures of what was planned, at several thresholds.
    avsec("detect", "--kitti", data, "--detector", DETECTOR, "--out", tmp_path / "seen")
    more = ["--detections", tmp_path / "seen", "--out", tmp_path / "out", "--sweep", "2"]
    report = json.loads(avsec(*common, *more, "--planner", STEADY, "--json").stdout)
    assert {row["planner"] for row in report["rates"]} == {"lane_change"}
    assert {row["planner"] for row in report["sweep"]} == {"lane_change"}
    assert (tmp_path / "out" / "evaluation.json").is_file()


def test_a_planner_in_plan_and_draw(avsec: Any, data: Path, tmp_path: Path) -> None:
    row = json.loads(avsec("plan", data / "free.xml", "--planner", "lane_change", "--json").stdout)
    assert (row["status"], row["cost"]) == ("found", pytest.approx(2.2))
    words = ["plan", data / "free.xml", "--planner", STEADY, "--pictures", tmp_path / "p"]
    assert json.loads(avsec(*words, "--json").stdout)["cost"] == pytest.approx(2.1)
    assert (tmp_path / "p" / "free.png").is_file()
    refused = avsec(*words[:4], "--mode", "reference", code=2)
    assert "--mode belongs to --planner astar and gbfs; lane_change takes" in refused.stderr
    labels = data / "training/label_2"
    drawn = avsec("draw", "000002", "--scenarios", labels, "--planner", "lane_change")
    assert "reached the goal after 2.2 s" in drawn.stderr
    assert (tmp_path / "000002_straight.png").is_file()


def test_a_name_that_nothing_has_is_asked_about(avsec: Any, data: Path) -> None:
    for words, meant in (
        (["evaluate", "--planner", "lane_chnage"], "lane_change"),
        (["plan", data / "free.xml", "--planner", "lane-chang"], "lane_change"),
        (["draw", "street-000003", "--planner", "lanechange"], "lane_change"),
        (["validate", "--kitti", data, "--validator", "stereo_scan"], "stereo_and_scan"),
        (
            ["detect", "--kitti", data, "--detector", "stereo_cluster", "--out", "o"],
            "stereo_clusters",
        ),
        (
            ["validate", "--kitti", data, "--validator", "stereo_and_scan", "--attack", "shifted"],
            "shifted_image",
        ),
        (["run", "pipeline", "--scenarios", data, "--planner", "lane_chang"], "lane_change"),
        (["run", "passing_distnce"], "passing_distance"),
        (["experiments", "passing-distances"], "passing_distance"),
    ):
        assert f'Did you mean "{meant}"?' in avsec(*words, code=2).stderr


@pytest.mark.parametrize("workers", [1, 2])
def test_a_detector_under_an_attack_in_detect(
    avsec: Any, data: Path, tmp_path: Path, workers: int
) -> None:
    common = ["detect", "--kitti", data, "--detector", DETECTOR, "--workers", workers, "--json"]
    assert json.loads(avsec(*common, "--out", tmp_path / "clean").stdout)["written"] == 3
    for (car,) in depths(tmp_path / "clean"):
        # f b / d = 200 * 0.5 / 10 m, to a cell of 0.5 m, and half a car more to its middle.
        assert car == pytest.approx(10.0 + 2.0, abs=0.5)
    avsec(*common, "--attack", ATTACK, "--out", tmp_path / "attacked")
    for car, wall in depths(tmp_path / "attacked"):
        assert car == pytest.approx(100 / (10 + 5) + 2.0, abs=0.5)
        assert wall == pytest.approx(100 / (2 + 5) + 2.0, abs=0.5)


def test_an_attack_that_knows_its_victim(avsec: Any, data: Path, tmp_path: Path) -> None:
    """Of all shifts up to 2 pixels that to the right misplaces the car most: by 2.5 m, not 1.7."""
    common = ["--detector", DETECTOR, "--attack", "worst_shift"]
    avsec("detect", "--kitti", data, *common, "--out", tmp_path / "attacked")
    for (car,) in depths(tmp_path / "attacked"):
        assert car == pytest.approx(100 / (10 - 2) + 2.0, abs=0.5)
    out = tmp_path / "run"
    avsec("run", "pipeline", "--scenarios", data, *common, "--out", out, "--workers", "0")
    (found,) = RunFolder.open(out).detections("pipeline attacked")["000001"].location
    assert found[2] == pytest.approx(14.5, abs=0.5)
    refused = avsec("validate", "--kitti", data, "--validator", "stereo_and_scan",
                    "--attack", "worst_shift", code=2)  # fmt: skip
    assert "worst_shift" in refused.stderr


def test_a_validator_and_an_attack_in_validate(avsec: Any, data: Path, tmp_path: Path) -> None:
    common = ["validate", "--kitti", data, "--validator", "stereo_and_scan", "--json"]
    *rows, _ = map(json.loads, avsec(*common, "--out", tmp_path / "clean").stdout.splitlines())
    assert [row["alarm"] for row in rows] == [False] * 3
    done = avsec(*common, "--attack", "shifted_image", "--out", tmp_path / "attacked")
    *rows, last = map(json.loads, done.stdout.splitlines())
    assert [(row["alarm"], row["attacked"], row["truly_attacked"]) for row in rows] == [
        (True, [], [3])
    ] * 3
    assert last["summary"]["attacks_detected"]["count"] == 3
    assert len(list((tmp_path / "attacked" / "alarms").iterdir())) == 3
    # Arguments of its own, as JSON; this command's sensitivity is none of them.
    deaf = json.dumps({"name": "stereo_and_scan", "most": 1.0})
    words = [*common[:4], deaf, "--attack", "shifted_image", "--json", "--out", tmp_path / "deaf"]
    *rows, _ = map(json.loads, avsec(*words).stdout.splitlines())
    assert [row["alarm"] for row in rows] == [False] * 3
    assert "--rate" in avsec(*common, "--rate", "0.1", code=2).stderr
    assert "lidar 3 2" in avsec(*common, "--sensors", "3", "2", code=2).stderr


@pytest.mark.parametrize("workers", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_all_of_them_in_run_and_report(
    avsec: Any, data: Path, tmp_path: Path, workers: int
) -> None:
    out = tmp_path / "run"
    words = ["run", "pipeline", "--scenarios", data, "--workers", workers, "--out", out, "--json"]
    done = avsec(
        *words, "--detector", DETECTOR, "--planner", "lane_change", "--attack", ATTACK,
        "--validator", "stereo_and_scan", "--options", "response=stop",
    )  # fmt: skip
    assert json.loads(done.stdout)["failed"] == 0
    there = RunFolder.open(out)
    assert {row.planner for row in there.episodes()} == {"lane_change"}
    straight = {
        setting.removeprefix("pipeline "): [row.record.outcome for row in rows]
        for setting, _ in there.settings()
        if (rows := there.episodes(setting=setting, intention="straight"))
    }
    # Under the attack there is an alarm, and the car stops.
    stops = straight.pop("attacked")
    assert straight == {"truth": ["safe"] * 3, "unattacked": ["safe"] * 3}
    assert len(stops) == 3
    assert all(len(boxes) == 1 for boxes in there.detections("pipeline unattacked").values())
    assert all(len(boxes) == 0 for boxes in there.detections("pipeline attacked").values())
    avsec("report", out)
    page = (out / "report.html").read_text()
    for words in ("stereo_clusters", "shifted_image", "lane_change", "stereo_and_scan"):
        assert words in page
    assert "avsec-others 1.0" in page


def test_the_experiment_is_listed_run_and_reported(avsec: Any, tmp_path: Path) -> None:
    listed = json.loads(avsec("experiments", "--json").stdout)["experiments"]
    (entry,) = [row for row in listed if row["name"] == "passing_distance"]
    assert entry["options"]["planners"] == ["astar", "lane_change"]
    out = tmp_path / "run"
    avsec("run", "passing_distance", "--out", out, "--workers", "0")
    found = json.loads(avsec("report", out, "--markdown", "tables.md", "--json").stdout)
    nearest = found["passing_distance"]
    assert nearest.keys() == {"astar", "lane_change"}
    assert all(8.0 < distance <= 10.0 for distance in nearest.values())
    page = (out / "report.html").read_text()
    section = page.partition('<section id="passing">')[2].partition("</section>")[0]
    assert "<h2>Which planner passes the nearest car?</h2>" in section
    assert f"lane_change passes a car {nearest['lane_change']:g} m ahead." in section
    assert "Nearest car that is passed" in section
    assert "A section is missing" not in page
    assert "| planner | distance, m |" in (tmp_path / "tables.md").read_text()
    assert RunFolder.open(out).manifest["sittings"][0]["versions"]["avsec-others"] == "1.0"


@pytest.mark.slow
def test_a_shell_and_its_workers_find_all_of_it(
    installed: None, data: Path, tmp_path: Path
) -> None:
    def shell(*words: Any) -> str:
        command = [sys.executable, "-m", "avsec_gym", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
        return done.stdout

    planned = json.loads(shell("plan", data / "free.xml", "--planner", "lane_change", "--json"))
    assert planned["status"] == "found"
    short = ["--options", "distances=[10.0]", "--workers", "2", "--json"]
    done = json.loads(shell("run", "passing_distance", "--out", "run", *short))
    assert (done["done"], done["failed"]) == (2, 0)


def test_a_broken_experiment_does_not_take_the_others_with_it(
    avsec: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "run"
    short = ["--options", "distances=[10.0]", "--workers", "0"]
    avsec("run", "passing_distance", "--out", out, *short)
    about = tmp_path / "site" / "broken-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[avsec_gym.experiments]\nbroken = broken_experiment:NONE\ndemo = broken_experiment:DEMO\n"
    )
    (about.parent / "broken_experiment.py").write_text("raise RuntimeError('half installed')")
    monkeypatch.syspath_prepend(about.parent)
    done = avsec("experiments")
    assert "the experiment broken of another package is left out: half installed" in done.stderr
    assert "passing_distance" in done.stdout + done.stderr
    avsec("report", out)
    page = (out / "report.html").read_text()
    assert "the experiment broken of another package is left out" in page
    assert '<section id="passing">' in page
    report = run_report(RunFolder.open(out))
    assert report.data["passing_distance"]["astar"] == 10.0


def test_an_experiment_that_takes_no_such_part_says_so(avsec: Any, data: Path) -> None:
    done = avsec("run", "unattacked", "--scenarios", data, "--planner", "lane_change", code=2)
    assert "there is no option 'planner'" in done.stderr
    done = avsec("run", "pipeline", "--scenarios", data, "--options", "planer=mine", code=2)
    assert 'Did you mean "planner"?' in done.stderr
