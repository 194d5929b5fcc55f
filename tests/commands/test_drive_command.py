"""`avsec drive`: its figures, and that nothing is lost or changed by who makes the drives, when."""

from __future__ import annotations

import json
import re
import shutil
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import gymnasium as gym
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.closed_loop.error_model.model import ErrorModel, Ghosts, write_error_model
from avsec_gym.commands.drive_settings import DriveParts
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion

SCENES = 4
TIMES = "seconds.jsonl"
"""The only file that is another one each time."""


def drive(out: Path, *more: str, code: int = 0, scenes: int = SCENES) -> None:
    words = ["drive", "--out", str(out), "--limit", str(scenes), "--duration", "3"]
    assert run([*words, "--scenarios", "layouts", *more]) == code


def content(out: Path) -> dict[str, bytes]:
    return {
        path.relative_to(out).as_posix(): path.read_bytes()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.name != TIMES
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("drive") / "out"
    drive(out)
    return out


def by_hand(perception: str) -> list[dict[str, Any]]:
    """The drives once more, by the environment alone."""
    scenarios = {"source": "layouts", "count": SCENES}
    env = gym.make("avsec/ClosedLoop-v0", scenarios=scenarios, perception=perception, duration=3.0)
    played: Any = env.unwrapped
    driver, found = PlannerDriver(env), []
    for seed, id in enumerate(played.scenes.ids):
        options = {"scenario": id, "intention": "straight"}
        observation, info = env.reset(seed=seed, options=options)
        ended, steps, speeds = False, 0, [played.vehicle.speed]
        while not ended:
            action, _ = driver.predict(observation)
            observation, _, terminated, truncated, info = env.step(action)
            ended, steps = terminated or truncated, steps + 1
            speeds.append(played.vehicle.speed)
        slowed = max(a - b for a, b in pairwise(speeds)) / 0.1
        found.append({**info, "steps": steps, "slowed": slowed})
    return found


@pytest.mark.parametrize("perception", ["truth", "blind"])
def test_the_figures_are_those_counted_by_hand(made: Path, perception: str) -> None:
    drives = by_hand(perception)
    report = json.loads((made / "summary.json").read_text())
    (own,) = [each for each in report["settings"] if each["setting"] == perception]
    assert own["drives"] == SCENES
    assert own["steps"] == sum(each["steps"] for each in drives)
    counted = {
        "at_fault": sum(bool(each["at_fault"]) for each in drives),
        "collision": sum(each["collision"] for each in drives),
        "goal": sum(each["outcome"] == "goal" for each in drives),
        "hard_braking": sum(each["slowed"] > 4.05 for each in drives),
        "alarm": 0,
    }
    assert {name: share["count"] for name, share in own["rates"].items()} == counted
    for share in own["rates"].values():
        assert share["rate"] == share["count"] / SCENES
        assert share["interval"] == pytest.approx(wilson_interval(share["count"], SCENES))
    mean = sum(each["navsim_score"] for each in drives) / SCENES
    assert own["navsim_score"]["value"] == pytest.approx(mean)


def test_what_was_killed_goes_on_to_the_same_bytes(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(made, out)
    for name in ("summary.json", "drives.html", "drive.gif"):
        (out / name).unlink()
    # Killed in the middle of the fourth line.
    lines = (out / "drives.jsonl").read_text().splitlines(keepends=True)
    (out / "drives.jsonl").write_text("".join(lines[:3]) + lines[3][:40])
    for line in lines[4:]:
        (out / "films" / f"{json.loads(line)['id'].replace('/', '_')}.npz").unlink()
    drive(out, code=1)
    drive(out, "--resume")
    assert content(out) == content(made)


@pytest.mark.slow
def test_two_processes_make_the_same_drives(made: Path, tmp_path: Path) -> None:
    drive(tmp_path / "out", "--jobs", "2")
    assert content(tmp_path / "out") == content(made)


def test_a_line_for_each_drive_and_a_picture_of_each_second(made: Path) -> None:
    rows = [json.loads(line) for line in (made / "drives.jsonl").read_text().splitlines()]
    assert len(rows) == 2 * SCENES
    assert {row["schema"] for row in rows} == {"avsec.drive.row/2"}
    assert len({(row["scenario"], row["seed"]) for row in rows}) == SCENES
    assert len(list((made / "films").iterdir())) == len(rows)
    assert (made / "drive.gif").read_bytes().startswith(b"GIF89a")
    page = (made / "drives.html").read_text()
    assert page.count("data:image/webp") >= 2
    assert all(row["scenario"] in page for row in rows)


@pytest.mark.slow
def test_an_error_model_and_own_settings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "ghosts.json"
    ghost = (12.0, 0.0, 0.0, 1.5, 1.8, 4.0)
    write_error_model(model, ErrorModel(ghosts=Ghosts(50.0, (ghost,), 5.0)))
    words = ["--error-model", str(model), "--pictures", "0", "--json"]
    own = '{"name": "late", "perception": "truth", "planner": "gbfs"}'
    drive(tmp_path / "out", *words, "--settings", "truth", "error-model", own, scenes=2)
    report = json.loads(capsys.readouterr().out)
    assert [each["setting"] for each in report["settings"]] == ["truth", "error-model", "late"]
    truth, ghosts, _ = report["settings"]
    # A ghost 12 m ahead in every frame is braked for.
    assert ghosts["rates"]["hard_braking"]["count"] > truth["rates"]["hard_braking"]["count"]
    assert not list((tmp_path / "out").glob("drive.*"))
    other = tmp_path / "nothing_wrong.json"
    write_error_model(other, ErrorModel())
    several = ["--error-model", str(other), str(model), "--pictures", "0", "--json"]
    drive(tmp_path / "both", *several, "--settings", "truth", "error-model", scenes=2)
    of_both = json.loads(capsys.readouterr().out)["settings"]
    assert [each["setting"] for each in of_both] == ["truth", "nothing_wrong", "ghosts"]
    assert of_both[2]["rates"] == ghosts["rates"]
    model.unlink()
    write_error_model(model, ErrorModel())
    settings = ["--settings", "truth", "error-model", own]
    drive(tmp_path / "out", *words, "--resume", *settings, code=1, scenes=2)
    assert "error_model" in capsys.readouterr().err


def test_a_setting_may_have_a_driver_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rows of highway-env's own driver have no first plan; the record states who drove."""
    own = '{"name": "follower", "perception": "truth", "driver": "idm"}'
    words = ["--pictures", "1", "--json", "--traffic", '{"name": "reacting", "share": 0.5}']
    drive(tmp_path / "one", *words, "--settings", "truth", own, scenes=2)
    drive(tmp_path / "all", *words, "--settings", "truth", "--driver", "idm", scenes=2)
    capsys.readouterr()
    one, both = (
        [json.loads(line) for line in (tmp_path / name / "drives.jsonl").read_text().splitlines()]
        for name in ("one", "all")
    )
    follower = [row for row in one if row["setting"] == "follower"]
    assert [row["first_plan"] for row in follower] == ["unplanned"] * 2
    for row, other in zip(follower, both, strict=True):
        assert {**row, "id": "", "setting": ""} == {**other, "id": "", "setting": ""}
    settings = json.loads((tmp_path / "one" / "drives.json").read_text())["settings"]
    assert "driver" not in settings["truth"]
    assert settings["follower"]["driver"] == "idm"
    assert settings["follower"]["traffic"] == {"name": "reacting", "share": 0.5}


def test_cars_with_a_classifier_hear_it() -> None:
    """The default of all settings would leave it unheard."""
    parts = DriveParts(sensing={"classifier": "small"}, shared={"motion": "truth"})
    own = '{"name": "own", "perception": "stereo", "classifier": "small"}'
    for setting in parts.settings(("truth", "detector", own)):
        heard = "classifier" in setting.arguments
        assert setting.arguments.get("motion") == (None if heard else "truth")
        made = gym.make("avsec/ClosedLoop-v0", **setting.arguments)
        motion = Motion.CLASSIFIER if heard else Motion.TRUTH
        assert made.unwrapped.motion == motion  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("--driver idn", 2, 'Did you mean "idm"'),
        ("--traffic reactng", 2, 'Did you mean "reacting"'),
        ("--scenarios layuots", 2, 'Did you mean "layouts"?'),
        ("--settings truht", 2, 'Did you mean "truth"?'),
        ("--settings truth truth", 2, "two settings are called truth"),
        ("--settings attacked", 2, "needs --attack"),
        ("--settings error-model", 2, "needs --error-model"),
        ('--settings {"name":"a/b"}', 2, "letters, digits"),
        ('--settings {"name":"a","perceptoin":"blind"}', 2, 'setting a: .*"perception"'),
        ("--settings truth --attack thesis_pgd", 2, "add attacked"),
        ("--settings truth --classifier small", 2, "--classifier .* add detector"),
        ("--settings lidar --selector small", 2, "--selector .* add detector"),
        ("--settings truth --error-model stereo_rcnn", 2, "--error-model .* add error-model"),
        ("--selector smal", 2, 'Did you mean "small"?'),
        ("--response drop", 2, "--response belongs to --validator"),
        ("--handover 1", 2, "--handover is used by none"),
        ("--attack facual", 2, 'Did you mean "facula"?'),
        ("--planner astr", 2, 'Did you mean "astar"?'),
        ("--ids nothing", 2, "there is no scenario 'nothing'"),
        ("--limit 0", 2, "--limit cannot be 0"),
        ("--jobs 0", 2, "--jobs cannot be 0"),
        ("--out {file}", 1, "Name a folder"),
    ],
)
def test_what_cannot_work_is_refused_at_once(
    words: str, code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    out = tmp_path / "out"
    typed = [word.replace("{file}", str(tmp_path / "file")) for word in words.split()]
    assert run(["drive", "--out", str(out), *typed]) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(said, line), line
    assert not out.exists()


def test_drives_of_something_else_are_left_alone(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    shutil.copytree(made, out)
    drive(out, "--seed", "1", "--resume", code=1)
    assert "seed 0, not 1" in capsys.readouterr().err
    drive(out, code=1)
    assert "--resume" in capsys.readouterr().err
    assert content(out) == content(made)


def test_without_a_name_it_resumes_the_same_drives_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["drive", "--scenarios", "layouts", "--limit", "1", "--duration", "1", "--resume"]
    words += ["--pictures", "0", "--settings", "blind"]
    for _ in range(2):  # Begun, where there are none; then gone on with.
        assert run(words) == 0
    shutil.copytree("runs/drive", "runs/drive_2")
    record = json.loads(Path("runs/drive_2/drives.json").read_text())
    Path("runs/drive_2/drives.json").write_text(json.dumps(record | {"intention": "left"}))
    capsys.readouterr()
    assert run([*words, "--seed", "1"]) == 1
    told = capsys.readouterr().err
    assert f"{Path('runs/drive_2')}: The newest drives are others: " in told
    assert "intention left, not straight; seed 0, not 1" in told
    assert "without --resume" in told
    assert sorted(path.name for path in Path("runs").iterdir()) == ["drive", "drive_2"]
    assert run(words) == 0


def test_other_scenes_in_the_same_folder_are_other_drives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, out = tmp_path / "scenes", tmp_path / "out"
    folder.mkdir()
    words = ["drive", "--scenarios", str(folder), "--out", str(out), "--duration", "1"]
    words += ["--resume", "--pictures", "0", "--settings", "blind"]
    for code, road in enumerate((RoadType.STREET, RoadType.HIGHWAY)):
        scene = build_planning_scenario(
            Boxes3D.empty(), road_type=road, intention=Intention.STRAIGHT, id="free"
        )
        (folder / "free.xml").unlink(missing_ok=True)
        write_commonroad(scene, folder / "free.xml")
        assert run(words) == code
    assert "files {" in capsys.readouterr().err


def test_drives_whose_rows_were_emptied_are_driven_again(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    shutil.copytree(made, out)
    (out / "seconds.jsonl").write_text("")
    drive(out, "--resume", code=1)
    assert "seconds.jsonl" in capsys.readouterr().err
    (out / "drives.jsonl").write_text("")
    drive(out, "--resume")
    assert content(out) == content(made)


@pytest.mark.parametrize(
    ("words", "module", "extra"), [("--video mp4", "av", "video"), ("--rrd", "rerun", "rerun")]
)
def test_a_missing_package_is_named(
    words: str,
    module: str,
    extra: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    drive(tmp_path / "out", *words.split(), code=2)
    assert f"pip install 'avsec-gym[{extra}]'" in capsys.readouterr().err
