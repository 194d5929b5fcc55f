"""The command line: what it prints, how it ends, and what it refuses."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.geometry import ego_to_camera
from avsec_gym.kitti.labels import write_detections, write_labels
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.road_type import RoadType
from avsec_gym.scenario import scene_sets
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import PlanningScenario

DONE, BAD_DATA, BAD_USAGE, IN_PART = 0, 1, 2, 3
RATES = ("success_rate", "collision_rate", "safe_driving_rate")


def boxes(*poses: tuple[float, float, float], score: float = 0.9) -> Boxes3D:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    return Boxes3D(
        location, np.tile([1.5, 1.6, 4.0], (count, 1)), rotation_y, np.full(count, score),
        np.full(count, "Car"),
    )  # fmt: skip


IN_THE_WAY = (13.0, -1.2, 0.0)
WALL = tuple((9.0, y, np.pi / 2) for y in np.arange(-40.0, 41.0, 3.9))
SCENES = {"000001": (), "000002": (IN_THE_WAY,), "000003": ((40.0, 5.0, 0.0),), "000004": WALL}


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    """Four labelled frames: free, a car in the way, a car far away, a wall."""
    root = tmp_path / "kitti"
    for id, poses in SCENES.items():
        write_labels(root / "training" / "label_2" / f"{id}.txt", boxes(*poses))
    return root


@pytest.fixture
def detections(tmp_path: Path) -> Path:
    """The car in the way is missed; a ghost wall stands in the third frame; the fourth is right."""
    root = tmp_path / "detections"
    for id, poses in {"000001": (), "000002": (), "000003": WALL, "000004": WALL}.items():
        write_detections(root / f"{id}.txt", boxes(*poses))
    return root


@pytest.fixture
def problems(tmp_path: Path) -> Path:
    root = tmp_path / "problems"
    root.mkdir()
    for name, poses in (("a_free", ()), ("b_wall", WALL), ("c_way", (IN_THE_WAY,))):
        problem = build_planning_scenario(
            boxes(*poses), road_type=RoadType.STREET, intention=Intention.STRAIGHT, id=name
        )
        write_commonroad(problem, root / f"{name}.xml")
    return root


def refuse_constant(word: str) -> Any:
    raise AssertionError(f"{word} is not JSON")


def as_json(text: str) -> Any:
    return json.loads(text, parse_constant=refuse_constant)


def ends(arguments: list[Any]) -> int:
    """The exit code, also where the argument parser ends the program itself."""
    try:
        return run([str(argument) for argument in arguments])
    except SystemExit as end:
        return int(end.code or 0)


def evaluated(capsys: pytest.CaptureFixture[str], *arguments: Any, code: int = DONE) -> Any:
    assert ends(["evaluate", *arguments, "--json"]) == code
    return as_json(capsys.readouterr().out)


def test_the_rates_object(kitti: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = evaluated(capsys, "--kitti", kitti)
    assert [row["intention"] for row in report["rates"]] == ["left", "straight", "right"]
    for row in report["rates"]:
        assert (row["planner"], row["input"], row["scenarios"]) == ("astar", "ground_truth", 4)
        assert row["success_rate"] == 0.75
        assert row["collision_rate"] == 0.0
        assert row["safe_driving_rate"] == 0.75
        assert row["failures"] == {"unreachable": 1}
        for name in RATES:
            low, high = row[f"{name}_interval"]
            assert 0 <= low <= row[name] <= high <= 1
    assert report["settings"]["seed"] == 0


def test_a_detectors_results_beside_the_truth(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = evaluated(
        capsys, "--kitti", kitti, "--detections", detections, "--intention", "straight",
        "--planner", "all",
    )  # fmt: skip
    rates = {(row["planner"], row["input"]): row for row in report["rates"]}
    assert set(rates) == {(p, i) for p in ("astar", "gbfs") for i in ("ground_truth", "detections")}
    for planner in ("astar", "gbfs"):
        row = rates[planner, "detections"]
        assert (row["planned"], row["collisions"]) == (2, 1)
        assert (row["success_rate"], row["collision_rate"]) == (0.5, 0.5)
        assert row["safe_driving_rate"] == 0.25
        flips = [flip for flip in report["flips"] if flip["planner"] == planner]
        assert [(flip["scenario"], flip["outcome"], flip["reason"]) for flip in flips] == [
            ("000002", "collision", None),
            ("000003", "unplanned", "unreachable"),
        ]
    difference = report["differences"][0]
    assert difference["safe_driving_rate"] == -0.5
    assert (difference["became_unsafe"], difference["became_safe"]) == (2, 0)
    assert difference["safe_driving_rate_interval"][0] < -0.5
    assert report["settings"]["score_threshold"] == 0.3


def test_a_rate_without_cases_is_null(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_labels(tmp_path / "000001.txt", boxes(*WALL))
    (row,) = evaluated(capsys, "--scenarios", tmp_path, "--intention", "left")["rates"]
    assert (row["success_rate"], row["safe_driving_rate"]) == (0.0, 0.0)
    assert row["collision_rate"] is None
    assert row["collision_rate_interval"] is None
    assert row["mean_path_length"] is None
    assert ends(["evaluate", "--scenarios", tmp_path, "--intention", "left"]) == DONE
    assert "–" in capsys.readouterr().out


def test_the_score_threshold(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["--kitti", kitti, "--detections", detections, "--intention", "straight"]
    low = evaluated(capsys, *common, "--score-threshold", "0.9")["rates"][1]
    high = evaluated(capsys, *common, "--score-threshold", "0.91")["rates"][1]
    assert (low["planned"], high["planned"]) == (2, 4)


def test_a_sweep_over_thresholds(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = evaluated(
        capsys, "--kitti", kitti, "--detections", detections, "--sweep", "3", "--intention", "left"
    )
    assert len(report["sweep"]) == 3
    assert {row["score_threshold"] for row in report["sweep"]} == {0.9}
    assert all(row["safe_driving_rate_interval"] for row in report["sweep"])


def test_missing_frames_are_reported_and_the_rest_is_done(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (detections / "000002.txt").unlink()
    assert ends(["evaluate", "--kitti", kitti, "--detections", detections, "--json"]) == IN_PART
    output = capsys.readouterr()
    assert "1 of 4 frames have no file" in output.err
    assert "000002" in output.err
    report = as_json(output.out)
    assert report["settings"]["frames_without_detections"] == ["000002"]
    assert {row["scenarios"] for row in report["rates"]} == {4}


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("Car -1 -1 -10 0 0 9 9 1.5 1.6 4.0 0 1.65 20 -1.57 0.9 0.1", "17"),
        ("Car -1 -1 -10 0 0 9 9 1.5 1.6 4.0 0 1.65 20 -1.57", "15"),
        ("Car -1 -1 -10 0 0 9 9 1.5 1.6 4.0 0 1.65 nan -1.57 0.9", "finite"),
        ("Car -1 -1 -10 0 0 9 9 1.5 1.6 4.0 0 1.65 1e9 -1.57 0.9", "too large"),
        ("Car -1 -1 -10 0 0 9 9 0 1.6 4.0 0 1.65 20 -1.57 0.9", "measures"),
    ],
)
def test_a_broken_detection_file_is_refused(
    kitti: Path, detections: Path, line: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = detections / "000003.txt"
    path.write_text(path.read_text().splitlines()[0] + "\n" + line + "\n")
    assert ends(["evaluate", "--kitti", kitti, "--detections", detections, "--json"]) == IN_PART
    output = capsys.readouterr()
    report = as_json(output.out)
    assert {row["scenarios"] for row in report["rates"]} == {3}
    assert f"{path}:2: " in report["remarks"][0]
    assert f"{path}:2: " in output.err
    assert problem in output.err


def test_a_broken_label_is_refused(kitti: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = kitti / "training/label_2/000003.txt"
    path.write_text("Car 0 0\n")
    assert ends(["evaluate", "--kitti", kitti]) == IN_PART
    assert f"{path}:1: " in capsys.readouterr().err
    for other in path.parent.iterdir():
        other.write_text("Car 0 0\n")
    assert ends(["evaluate", "--kitti", kitti]) == BAD_DATA
    assert "000001.txt:1: " in capsys.readouterr().err


def test_what_is_left_behind(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "deep" / "out"
    arguments = ["--kitti", kitti, "--detections", detections, "--out", out]
    report = evaluated(capsys, *arguments)
    assert as_json((out / "evaluation.json").read_text()) == report
    assert {path.name for path in out.iterdir()} == {"evaluation.json", "records.csv", "pictures"}
    with (out / "records.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * 3 * 2
    unsafe = {(r["scenario"], r["intention"]) for r in rows if r["outcome"] != "safe"}
    pictures = {tuple(path.stem.split("_")[:2]) for path in (out / "pictures").iterdir()}
    assert pictures == {(f["scenario"], f["intention"]) for f in report["flips"]}
    assert pictures <= unsafe
    for path in (out / "pictures").iterdir():
        assert cv2.imread(str(path)).std() > 5


def test_nothing_is_overwritten(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "evaluation.json").write_text("mine")
    assert ends(["evaluate", "--kitti", kitti, "--out", out]) == BAD_DATA
    assert "nothing is overwritten" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["evaluation.json"]
    assert (out / "evaluation.json").read_text() == "mine"


def test_an_out_that_is_a_file(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("mine")
    assert ends(["evaluate", "--kitti", kitti, "--out", tmp_path / "out"]) == BAD_DATA
    assert str(tmp_path / "out") in capsys.readouterr().err
    # Also a folder below a file, which only shows when something is written.
    assert ends(["evaluate", "--kitti", kitti, "--out", tmp_path / "out" / "deeper"]) == BAD_DATA
    assert str(tmp_path / "out") in capsys.readouterr().err
    assert (tmp_path / "out").read_text() == "mine"


def test_the_seed_and_the_limit(capsys: pytest.CaptureFixture[str]) -> None:
    one, two, other = (
        evaluated(capsys, "--limit", "12", "--seed", seed, "--draw-start-speed")
        for seed in ("3", "3", "4")
    )
    assert one == two
    assert one != other
    assert {row["scenarios"] for row in one["rates"]} == {12}
    assert one["scenario_set"] == "layouts-3"


def test_the_swept_check_stands_beside_the_sampled_one(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    report = evaluated(capsys, "--kitti", kitti, "--out", out)
    for row in report["rates"]:
        assert row["collisions"] <= row["swept_collisions"] <= row["planned"]
        if row["planned"]:
            assert row["swept_collision_rate"] == row["swept_collisions"] / row["planned"]
            low, high = row["swept_collision_rate_interval"]
            assert 0 <= low <= row["swept_collision_rate"] <= high <= 1
    rows = list(csv.DictReader((out / "records.csv").read_text().splitlines()))
    assert {row["swept_collision"] for row in rows if row["outcome"] == "collision"} <= {"True"}
    assert {row["swept_collision"] for row in rows if row["outcome"] == "unplanned"} <= {""}
    assert ends(["evaluate", "--kitti", kitti]) == DONE
    assert "swept" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["--kitti", "/no/such/folder"], BAD_DATA, "/no/such/folder"),
        (["--scenarios", "/no/such/folder"], BAD_DATA, "/no/such/folder"),
        (["--scenarios", "layuots"], BAD_USAGE, 'Did you mean "layouts"?'),
        (["--detections", "/no/such/folder", "--limit", "2"], BAD_USAGE, "KITTI frames"),
        (["--limit", "0"], BAD_USAGE, "--limit"),
        (["--limit", "-2"], BAD_USAGE, "--limit"),
        (["--limit", "many"], BAD_USAGE, "many"),
        (["--planner", "rrt"], BAD_USAGE, "rrt"),
        (["--intention", "back"], BAD_USAGE, "back"),
        (["--motion", "classifier"], BAD_USAGE, "classifier"),
        (["--sweep", "3"], BAD_USAGE, "--detections"),
        (["--sweep", "-3"], BAD_USAGE, "--sweep"),
        (["--pictures", "-1"], BAD_USAGE, "--pictures"),
        (["--score-threshold", "0.5"], BAD_USAGE, "--detections"),
        (["--score-threshold", "nan"], BAD_USAGE, "finite"),
        (["--score-threshold=-inf"], BAD_USAGE, "finite"),
        (["--seed", "-1", "--limit", "2"], BAD_USAGE, "0 or more"),
        (["--colour", "blue"], BAD_USAGE, "--colour"),
    ],
)
def test_wrong_usage_of_evaluate(
    arguments: list[str], code: int, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ends(["evaluate", *arguments]) == code
    output = capsys.readouterr()
    assert says in output.err
    assert output.out == ""


def test_a_negative_seed_for_labels(kitti: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(["evaluate", "--kitti", kitti, "--seed", "-1"]) == BAD_USAGE
    assert "0 or more" in capsys.readouterr().err


def test_results_of_another_split(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_detections(tmp_path / "other" / "007000.txt", boxes())
    assert ends(["evaluate", "--kitti", kitti, "--detections", tmp_path / "other"]) == BAD_DATA
    assert "another split" in capsys.readouterr().err


def test_the_frames_of_a_split(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `avsec ap` has it: results of `val` are judged on the frames of `val` alone."""
    listed = tmp_path / "some.txt"
    listed.write_text("000001\n000003\n")
    (kitti / "ImageSets").mkdir(exist_ok=True)
    (kitti / "ImageSets" / "mine.txt").write_text(listed.read_text())
    arguments = ["--kitti", kitti, "--detections", detections, "--intention", "left"]
    for split in ("mine", listed):
        report = evaluated(capsys, *arguments, "--split", split)
        assert {row["scenarios"] for row in report["rates"]} == {2}
        assert report["settings"]["split"] == str(split)
    assert evaluated(capsys, *arguments, "--scenarios", listed)["rates"] == report["rates"]
    limited = evaluated(capsys, *arguments, "--split", "mine", "--limit", "1")
    assert {row["scenarios"] for row in limited["rates"]} == {1}
    assert ends(["evaluate", "--kitti", kitti, "--split", "vla"]) == BAD_DATA
    assert "vla.txt" in capsys.readouterr().err
    for wrong in (["--split", "mine"], ["--kitti", kitti, "--split", "mine", "--scenarios", kitti]):
        assert ends(["evaluate", *wrong]) == BAD_USAGE
        assert "--split takes frames of --kitti" in capsys.readouterr().err


def test_an_empty_label_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(["evaluate", "--scenarios", tmp_path]) == BAD_DATA
    assert str(tmp_path) in capsys.readouterr().err
    (tmp_path / "training/label_2").mkdir(parents=True)
    assert ends(["evaluate", "--kitti", tmp_path]) == BAD_DATA
    assert str(tmp_path) in capsys.readouterr().err


def test_tables_are_for_people(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ends(["evaluate", "--kitti", kitti, "--detections", detections]) == DONE
    output = capsys.readouterr().out
    for word in (
        "safe driving",
        "ground truth",
        "detections",
        "75.0 (",
        "McNemar",
        "unreachable 1",
    ):
        assert word in output


def test_scenarios_from_commonroad_files(
    problems: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (row,) = evaluated(capsys, "--scenarios", problems)["rates"]
    assert (row["scenarios"], row["planned"], row["intention"]) == (3, 2, "as given")
    broken = problems / "d_broken.xml"
    broken.write_text("<commonRoad>")
    report = evaluated(capsys, "--scenarios", problems, code=IN_PART)
    assert report["rates"][0]["scenarios"] == 3
    assert str(broken) in report["remarks"][0]


def planned(capsys: pytest.CaptureFixture[str], *arguments: Any, code: int = DONE) -> list[Any]:
    assert ends(["plan", *arguments, "--json"]) == code
    return [as_json(line) for line in capsys.readouterr().out.splitlines()]


def test_plan_writes_a_line_for_each_file(
    problems: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    free, wall, way = planned(capsys, problems)
    for row in (free, wall, way):
        assert {"file", "status", "found", "cost", "expanded", "seconds"} <= set(row)
        assert 0 <= row["seconds"] < 30
    assert (free["file"], free["status"], free["found"]) == ("a_free.xml", "found", True)
    # 12.5 m to the goal at 6 to 8 m/s, in tenths of seconds without rounding noise.
    assert free["cost"] in (1.6, 1.7, 1.8, 1.9, 2.0)
    assert free["reason"] is None
    assert (wall["status"], wall["found"], wall["cost"]) == ("exhausted", False, None)
    assert wall["reason"] == "unreachable"
    assert wall["expanded"] > 1
    assert (way["status"], way["file"]) == ("found", "c_way.xml")


def test_plan_plans_each_file_once(
    problems: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    plan = MotionPrimitivePlanner.plan

    def counted(self: MotionPrimitivePlanner, scenario: PlanningScenario) -> Plan:
        asked.append(scenario.id)
        return plan(self, scenario)

    monkeypatch.setattr(MotionPrimitivePlanner, "plan", counted)
    planned(capsys, problems)
    assert asked == ["a_free", "b_wall", "c_way"]


def test_plan_takes_files_in_the_order_given(
    problems: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [problems / "c_way.xml", problems / "a_free.xml"]
    rows = planned(capsys, *files, "--planner", "gbfs")
    assert [row["file"] for row in rows] == ["c_way.xml", "a_free.xml"]


def test_plan_ends_at_a_limit(problems: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (row,) = planned(capsys, problems / "b_wall.xml", "--node-limit", "2")
    assert (row["status"], row["reason"], row["expanded"]) == ("limit", "limit", 2)
    assert row["lower_bound"] > 0


def test_plan_goes_on_after_a_broken_file(
    problems: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken, gone = tmp_path / "broken.xml", tmp_path / "gone.xml"
    broken.write_text("<commonRoad>")
    files = [problems / "a_free.xml", broken, gone, problems / "c_way.xml"]
    assert ends(["plan", *files, "--json"]) == IN_PART
    output = capsys.readouterr()
    rows = [as_json(line) for line in output.out.splitlines()]
    assert [row["status"] for row in rows] == ["found", "error", "error", "found"]
    for row, path in zip(rows[1:3], (broken, gone), strict=True):
        assert set(rows[0]) - set(row) <= {
            "reason",
            "goal_occupied",
            "lower_bound",
            "start_speed",
        }
        assert (row["file"], row["found"], row["cost"]) == (path.name, False, None)
        assert str(path) in row["error"]
        assert str(path) in output.err
    assert ends(["plan", broken]) == BAD_DATA
    assert ends(["plan", problems, broken]) == IN_PART
    assert "broken.xml" in capsys.readouterr().out


def test_plan_names_the_file_that_cannot_be_planned(
    problems: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever is wrong with one of several: a polygon, a speed, an element, a goal's times."""
    text = (problems / "b_wall.xml").read_text()
    polygon = "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in ((0, 0), (4, 2), (4, 0)))
    bow_tie = f"<shape><polygon>{polygon}<point><x>0</x><y>2</y></point></polygon></shape>"
    start, velocity = "(?s)(<planningProblem.*?<velocity>.*?<exact>)", "(</exact>)"
    changes = {
        "bow_tie": ("(?s)<shape>.*?</shape>", bow_tie),
        "backwards": (f"{start}[^<]*{velocity}", r"\1-6.0\2"),
        "fast": (f"{start}[^<]*{velocity}", r"\g<1>1000\2"),
        "misspelt": ("staticObstacle", "staticObstacles"),
    }
    for name, (pattern, replacement) in changes.items():
        count = 0 if name == "misspelt" else 1
        (tmp_path / f"{name}.xml").write_text(re.sub(pattern, replacement, text, count=count))
    assert ends(["plan", tmp_path, problems / "a_free.xml"]) == IN_PART
    complaints = capsys.readouterr().err
    assert all(str(tmp_path / f"{name}.xml") in complaints for name in changes)


@pytest.mark.parametrize("below", ["", "deeper"])
def test_pictures_below_a_file(
    problems: Path, tmp_path: Path, below: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    assert ends(["plan", problems, "--pictures", file / below]) == BAD_DATA
    assert f"{file}: This is a file, where a folder is needed." in capsys.readouterr().err


def test_plan_draws_pictures(
    problems: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ends(["plan", problems, "--pictures", tmp_path / "pictures"]) == DONE
    pictures = sorted((tmp_path / "pictures").iterdir())
    assert [path.name for path in pictures] == ["a_free.png", "b_wall.png", "c_way.png"]
    assert all(cv2.imread(str(path)).std() > 5 for path in pictures)
    output = capsys.readouterr().out
    # Units in square brackets are not swallowed as markup.
    assert "cost [s]" in output
    assert "time [ms]" in output


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ([], BAD_USAGE, "commonroad"),
        (["{folder}"], BAD_DATA, "no commonroad xml file"),
        (["{problems}", "--planner", "rrt"], BAD_USAGE, "rrt"),
        (["{problems}", "--mode", "fast"], BAD_USAGE, "fast"),
        (["{problems}", "--node-limit", "0"], BAD_USAGE, "--node-limit"),
        (["{problems}", "--time-limit", "nan"], BAD_USAGE, "--time-limit"),
        (["{problems}", "--primitives", "{folder}/none.xml"], BAD_DATA, "none.xml"),
        (["{problems}", "--primitives", "{problems}/a_free.xml"], BAD_DATA, "a_free.xml"),
    ],
)
def test_wrong_usage_of_plan(
    arguments: list[str], code: int, says: str, problems: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "empty").mkdir()
    filled = [a.format(folder=tmp_path / "empty", problems=problems) for a in arguments]
    assert ends(["plan", *filled]) == code
    assert says in capsys.readouterr().err.lower()


def test_data_check_of_good_data(kitti: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(["data", "check", kitti]) == DONE
    output = capsys.readouterr()
    assert "nothing is broken" in output.err
    assert "training/label_2" in output.out
    assert ends(["data", "check", kitti, "--json"]) == DONE
    report = as_json(capsys.readouterr().out)
    assert (report["ok"], report["layout"], report["broken"]) == (True, "object", [])


def test_data_check_of_broken_data(kitti: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = kitti / "training/label_2/000002.txt"
    path.write_text("Car 0 0\n")
    assert ends(["data", "check", kitti]) == BAD_DATA
    assert f"broken: {path}:1: " in capsys.readouterr().err
    assert ends(["data", "check", kitti, "--json"]) == BAD_DATA
    (broken,) = as_json(capsys.readouterr().out)["broken"]
    assert (broken["path"], broken["line"]) == (str(path), 1)
    assert broken["remedy"]


def test_data_check_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(["data", "check", tmp_path]) == BAD_DATA
    assert "none of KITTI's layouts" in " ".join(capsys.readouterr().out.split())
    assert ends(["data", "check", tmp_path / "gone"]) == BAD_DATA
    assert str(tmp_path / "gone") in capsys.readouterr().err


def test_data_check_of_a_folder_above_results(
    detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As OpenPCDet writes them; and as `avsec evaluate` finds them."""
    output = tmp_path / "pointpillar"
    data = output / "eval/epoch_80/val/default/final_result/data"
    shutil.copytree(detections, data)
    assert ends(["data", "check", output, "--json"]) == DONE
    report = as_json(capsys.readouterr().out)
    assert report["layout"] == "detections"
    assert [part["files"] for part in report["parts"]] == [len(list(data.iterdir()))]


def test_folders_whose_names_look_like_markup(
    detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = tmp_path / "[" / "bold]"
    odd.parent.mkdir()
    shutil.copytree(detections, odd)
    assert ends(["data", "check", odd]) == DONE
    assert ends(["evaluate", "--scenarios", "layouts", "--limit", "1"]) == DONE
    capsys.readouterr()


def test_draw(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["draw", "000002", "--scenarios", kitti / "training/label_2"]
    assert ends([*common, "--out", tmp_path / "clean.png"]) == DONE
    assert "safe" in capsys.readouterr().err
    attacked = tmp_path / "new" / "attacked.png"
    assert ends([*common, "--detections", detections, "--out", attacked]) == DONE
    assert "collision" in capsys.readouterr().err
    assert cv2.imread(str(attacked)).shape == cv2.imread(str(tmp_path / "clean.png")).shape
    assert ends(["draw", "000099", "--scenarios", kitti / "training/label_2"]) == BAD_USAGE
    assert "000001" in capsys.readouterr().err


def test_draw_takes_a_frame_of_kitti_as_evaluate_does(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["draw", "000002", "--kitti", kitti]
    assert ends([*common, "--out", tmp_path / "a.png"]) == DONE
    labels = kitti / "training/label_2"
    assert ends(["draw", "000002", "--scenarios", labels, "--out", tmp_path / "b.png"]) == DONE
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert ends(["draw", "000099", "--kitti", kitti]) == BAD_USAGE
    assert "has no scene '000099'" in capsys.readouterr().err
    # Where the folder has nothing on the scene, the picture is of a car that sees nothing.
    others = tmp_path / "others"
    others.mkdir()
    shutil.copy(detections / "000003.txt", others)
    assert ends([*common, "--detections", others, "--out", tmp_path / "c.png"]) == DONE
    assert "000002 has no file and counts as without detections" in capsys.readouterr().err


def test_draw_refuses_a_layout_beyond_those_that_are_made(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    counted = scene_sets.procedural_scenes

    def remembered(count: int, *, seed: int = 0) -> Any:
        made.append(count)
        return counted(count, seed=seed)

    monkeypatch.setattr(scene_sets, "procedural_scenes", remembered)
    assert ends(["draw", "street-999999"]) == BAD_USAGE
    assert "has no scene 'street-999999'" in capsys.readouterr().err
    assert max(made) <= 200, "all before it were made, to find that it is none"


def test_draw_names_its_picture_after_the_scene(
    kitti: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    labels = kitti / "training/label_2"
    assert ends(["draw", "000003", "--scenarios", labels, "--intention", "left"]) == DONE
    assert (tmp_path / "000003_left.png").is_file()


def test_the_program_itself(problems: Path) -> None:
    program = Path(sys.executable).with_name("avsec")
    done = subprocess.run(
        [program, "plan", problems / "a_free.xml", problems / "gone.xml", "--json"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == IN_PART
    rows = [as_json(line) for line in done.stdout.splitlines()]
    assert [row["found"] for row in rows] == [True, False]
    assert "gone.xml" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_main_job_in_one_command(shared: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = evaluated(
        capsys, "--kitti", shared / "kitti/object", "--scenarios", shared / "safety_scenarios",
        "--intention", "all", "--planner", "astar",
    )  # fmt: skip
    least = {"left": 0.897, "straight": 0.980, "right": 0.852}
    assert {row["intention"]: row["scenarios"] for row in report["rates"]} == dict.fromkeys(
        least, 600
    )
    for row in report["rates"]:
        assert row["safe_driving_rate"] >= least[row["intention"]]
        assert sum(row["failures"].values()) == 600 - row["planned"]
    assert len(report["remarks"]) == 3
