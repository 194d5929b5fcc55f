"""`avsec validate` on drives of a wall of dots, whole and in part."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from avsec_gym.cli import run
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.registry import make
from avsec_gym.rig import camera_rig
from avsec_gym.storage.folder_lock import folder_lock
from avsec_gym.validation import fitting
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.likelihood.maximum_likelihood import read_likelihood_model
from avsec_gym.validation.thresholds import read_threshold_table, shares_of
from avsec_gym.world import export

RIG = camera_rig([0.0, 0.4, 0.6], focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))
COVERED = 11


def wall(number: int) -> SensorFrame:
    """Random dots 8 m ahead; in frame 11 other dots cover a part of camera 1."""
    rng = np.random.default_rng(number % 4)
    dots = rng.integers(0, 256, (120, 300, 1), np.uint8).repeat(3, axis=2)
    images = {camera: dots[:, 5 * shift :][:, :240] for camera, shift in enumerate((0, 2, 3))}
    if number == COVERED:
        images[1] = images[1].copy()
        images[1][:, 80:180] = rng.integers(0, 256, (120, 100, 1), np.uint8)
    x, y = np.meshgrid(np.linspace(-5, 5, 150), np.linspace(-2, 2, 40))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, 8.0), np.ones(x.size)], axis=1)
    points = (places @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:010d}", RIG.calibration, images, points)


def drive_of_walls(root: Path, count: int) -> Path:
    drive = root / "2026_01_01" / "2026_01_01_drive_0001_sync"
    write_raw_calibration(drive.parent, RIG.calibration, image_size=(240, 120))
    for number in range(count):
        write_raw_frame(drive, number, wall(number))
    return drive


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drive_of_walls(tmp_path_factory.mktemp("raw"), 12).parent


Lines = Callable[..., list[dict]]


@pytest.fixture
def validated(day: Path, capsys: pytest.CaptureFixture[str]) -> Lines:
    def command(*more: str, code: int = 0, drive: Path = day) -> list[dict]:
        assert run(["validate", "--kitti-raw", str(drive), "--rate", "0", "--json", *more]) == code
        return [json.loads(line) for line in capsys.readouterr().out.splitlines()]

    return command


def test_the_covered_camera_is_named_and_shown(validated: Lines, tmp_path: Path) -> None:
    out = tmp_path / "out"
    *rows, last = validated("--out", str(out), "--clean", "0.4")
    # Five clean frames of four walls, so that nothing else can exceed the thresholds.
    assert [row["attacked"] for row in rows] == [[]] * 6 + [[1]]
    assert rows[-1]["statuses"]["1"] == "attacked"
    assert last["summary"]["alarms"] == 1
    assert last["summary"]["frames"] == 7
    assert [path.name for path in (out / "alarms").iterdir()] == [f"{COVERED:010d}.png"]
    assert (out / "alarms" / f"{COVERED:010d}.png").read_bytes().startswith(b"\x89PNG")
    assert not any(row["exceeded"] or row["damage"] for row in rows[:-1])
    assert set(rows[-1]["shares"]) == {"lidar,2,0", "lidar,1,0", "2,1,0"}
    assert set(rows[-1]["shares"]["2,1,0"]) == set(MEASURES)
    beyond = rows[-1]["exceeded"]
    assert {1} <= set.intersection(*(set(error["sensors"]) for error in beyond))
    for error in beyond:
        shares = rows[-1]["shares"][",".join(map(str, error["sensors"]))]
        assert shares[error["share"]] == error["value"] > error["threshold"]
    assert list(rows[-1]["damage"]) == ["1"]
    assert rows[-1]["locating_seconds"] > 0


def test_it_goes_on_where_it_was_stopped(validated: Lines, tmp_path: Path) -> None:
    out = tmp_path / "out"
    options = ["--out", str(out), "--clean", "0.4"]
    whole = validated(*options)
    rows = (out / "frames.jsonl").read_text().splitlines(keepends=True)
    # Killed in the middle of a line.
    (out / "frames.jsonl").write_text("".join(rows[:3]) + rows[3][:20])
    untimed = {"seconds": 0, "locating_seconds": 0}
    again = validated(*options)
    assert [row | untimed for row in again[:-1]] == [row | untimed for row in whole[:-1]]
    assert (out / "frames.jsonl").read_text().splitlines(keepends=True)[:3] == rows[:3]
    validated("--out", str(out), "--clean", "0.5", code=1)


def test_a_folder_that_another_process_writes_is_left_to_it(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with folder_lock(tmp_path):
        assert run(["validate", "--kitti-raw", str(day), "--out", str(tmp_path)]) == 1
    assert f"{tmp_path}: Another process is writing here" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_thresholds_of_an_earlier_run_and_an_attack(validated: Lines, tmp_path: Path) -> None:
    validated("--out", str(tmp_path / "one"), "--clean", "0.4")
    facula = '{"name": "facula", "camera": 2, "radius": 60, "saturation": 0.9}'
    table = str(tmp_path / "one" / "thresholds.json")
    *rows, last = validated(
        "--out", str(tmp_path / "two"), "--thresholds", table, "--limit", "4", "--attack", facula
    )
    assert [row["truly_attacked"] for row in rows] == [[2]] * 4
    detected = last["summary"]["attacks_detected"]
    assert detected["count"] == sum(row["alarm"] for row in rows)
    assert detected["of"] == 4
    assert last["summary"]["alarms_as_recorded"]["rate"] is None


def test_a_fitted_file_tells_the_sensors(
    day: Path, validated: Lines, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    three = ["--sensors", "lidar", "2", "0"]
    validated("--out", str(tmp_path / "one"), "--clean", "0.4", *three)
    table = tmp_path / "one" / "thresholds.json"
    fitted = ["--thresholds", str(table), "--limit", "2"]
    for number, asked in enumerate(([], three)):
        rows = validated("--out", str(tmp_path / f"two{number}"), *fitted, *asked)[:-1]
        assert [list(row["statuses"]) for row in rows] == [["lidar", "2", "0"]] * 2
    arguments = ["validate", "--kitti-raw", str(day), "--out", str(tmp_path / "three"), *fitted]
    assert run([*arguments, "--sensors", "lidar", "2", "1", "0"]) == 2
    told = capsys.readouterr().err
    assert f"{table} was fitted on the sensors lidar 2 0, not lidar 2 1 0" in told
    assert "leave --sensors out" in told


def test_a_rare_sensor_few_clean_frames_and_alarms_of_an_unknown_drive_are_said(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = tmp_path / day.name / f"{day.name}_drive_0001_sync"
    shutil.copytree(day, drive.parent)
    for number in range(1, 12):
        (drive / "image_02" / "data" / f"{number:010d}.png").unlink()
    arguments = ["validate", "--kitti-raw", str(drive), "--out", str(tmp_path / "out")]
    assert run([*arguments, "--clean", "0.4", "--no-locate"]) == 0
    told = capsys.readouterr()
    assert "camera 2: 1 frames could be judged with it, 12 can without" in told.err
    assert "more false alarms than r = 0.01: of 5 clean frames, the thresholds of E" in told.err
    assert "alarms as recorded (false, if unattacked)" in told.out
    assert "without" not in told.out
    # Three sensors name none of them; they state what was beyond.
    assert "ALARM: some sensor; which one, and where, is open  (" in told.out
    assert "of LiDAR against camera 1, seen by camera 0" in told.out


def test_who_does_not_ask_where_is_not_told(validated: Lines, tmp_path: Path) -> None:
    *_, row, _ = validated("--out", str(tmp_path / "out"), "--clean", "0.4", "--no-locate")
    assert row["attacked"] == [1]
    assert row["damage"] == {}
    assert row["locating_seconds"] is None


@pytest.mark.slow
def test_light_that_e_overlooks_is_detected_by_the_other_shares(
    validated: Lines, tmp_path: Path
) -> None:
    facula = {"name": "facula", "camera": 1, "radius": 200, "strength": 400, "centre": [120, 60]}
    options = ["--clean", "0.4", "--limit", "10", "--attack", json.dumps(facula)]
    alarms = {}
    for criterion in ("error", "any"):
        out = str(tmp_path / criterion)
        *rows, _ = validated("--out", out, *options, "--criterion", criterion)
        alarms[criterion] = [row["alarm"] for row in rows]
    assert sum(alarms["error"]) < 6
    assert all(alarms["any"])
    # What E alone said is no part of what all shares say.
    validated("--out", out, *options, "--criterion", "error", code=1)


def test_what_lacks_is_said(
    day: Path, validated: Lines, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = drive_of_walls(tmp_path, 6)
    (drive / "velodyne_points" / "data" / "0000000002.bin").unlink()
    (drive / "image_01" / "data" / "0000000005.png").write_bytes(b"no picture")
    arguments = ["validate", "--kitti-raw", str(drive), "--out", str(tmp_path / "out")]
    assert run([*arguments, "--clean", "0.5"]) == 3
    told = capsys.readouterr()
    assert "0000000002: it lacks velodyne_points" in told.err
    assert "0000000005.png" in told.err
    assert "0000000004  sound" in told.out
    for camera in (0, 1):
        for file in (drive / f"image_{camera:02d}" / "data").iterdir():
            file.unlink()
    assert run([*arguments[:-1], str(tmp_path / "other")]) == 1
    assert "Three sensors" in capsys.readouterr().err


def test_broken_clean_frames_are_told_again_when_it_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = drive_of_walls(tmp_path, 6)
    (drive / "image_01" / "data" / "0000000001.png").write_bytes(b"no picture")
    (drive / "velodyne_points" / "data" / "0000000005.bin").unlink()
    out = tmp_path / "out"
    arguments = ["validate", "--kitti-raw", str(drive), "--out", str(out), "--clean", "0.5"]
    # Of the last frame nothing is asked.
    arguments += ["--limit", "5"]
    for _ in range(2):
        assert run(arguments) == 3
        told = capsys.readouterr().err
        assert "0000000001.png" in told
        assert "0000000005" not in told
        assert json.loads((out / "summary.json").read_text())["left_out"] == 1
    assert json.loads((out / "thresholds.json").read_text())["fitted_on"]["data"]["frames"] == 1


@pytest.mark.slow
def test_one_command_makes_a_likelihood_file(
    validated: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "fit"
    options = ["--out", str(out), "--clean", "0.9", "--fit-likelihood"]
    (row, last) = validated(*options)
    # The last wall is covered: like none of the clean ones, and unlike those with a facula.
    assert row["alarm"]
    assert set(row["probabilities"]) == {"lidar", "2", "1", "0"}
    assert last["summary"]["frames"] == 1
    samples = (out / "samples.jsonl").read_text().splitlines()
    assert [json.loads(line)["id"] for line in samples] == [f"{n:010d}" for n in range(11)]
    model = read_likelihood_model(out / "likelihood.json")
    assert len(model.clean_scores) == 11
    assert model.on.data["frames"] == 11
    # Stopped while it was attacking frames: those that are done are not attacked again.
    (out / "likelihood.json").rename(tmp_path / "likelihood.json")
    (out / "samples.jsonl").write_text("\n".join(samples[:9]) + "\n" + samples[9][:100])
    attacked = []
    find = StateEvidence.evidence
    monkeypatch.setattr(
        StateEvidence,
        "evidence",
        lambda self, states: attacked.append(self._clean.id) or find(self, states),
    )
    assert validated(*options)[0] == row
    assert attacked == [f"{n:010d}" for n in (9, 10)]
    again = read_likelihood_model(out / "likelihood.json")
    np.testing.assert_allclose(again.clean_scores, model.clean_scores)
    # The file serves other drives, and whoever makes validators by name.
    file = str(tmp_path / "likelihood.json")
    rows = validated("--out", str(tmp_path / "judged"), "--likelihood", file)[:-1]
    assert len(rows) == 12
    assert rows[-1]["statuses"] == row["statuses"]
    by_name = make("validator", {"name": "likelihood", "model": file, "rate": 0.0})
    said = by_name.validate(wall(COVERED)).statuses
    assert {str(sensor): str(status) for sensor, status in said.items()} == row["statuses"]


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--clean", "1"], 2),
        (["--rate", "2"], 2),
        (["--limit", "0"], 2),
        (["--thresholds", "no.json"], 1),
        (["--attack", "{"], 2),
        (["--depth", "none"], 2),
        (["--criterion", "error", "--likelihood", "no.json"], 2),
        (["--fit-likelihood", "--likelihood", "no.json"], 2),
        (["--fit-likelihood", "--criterion", "error"], 2),
        (["--fit-likelihood", "--clean", "0.5"], 2),
        (["--sensors", "1", "0"], 2),
        (["--sensors", "lidar", "0", "1"], 2),
    ],
)
def test_what_cannot_be_is_refused(
    day: Path, tmp_path: Path, options: list[str], code: int
) -> None:
    arguments = ["validate", "--kitti-raw", str(day), "--out", str(tmp_path / "out")]
    assert run([*arguments, *options]) == code


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--attack", '{"name": "faculla", "camera": 1}'], "no optical attack named 'faculla'"),
        (["--attack", '{"name": "facula", "camera": 7}'], "attacks 7; the sensors lidar 2 1 0"),
        (["--attack", '{"name": "thesis", "sensors": []}'], "attacks no sensor"),
        (["--attack", ""], "avsec validate --attack: a path or value is empty"),
        (["--depth", '{"name": "sgbm", "blocks": 1}'], "no argument 'blocks'"),
        (["--depth", '{"name": "sgbm", "nearest": -1}'], "nearest takes a number from 0.01"),
    ],
)
def test_what_is_mistyped_is_told_before_anything_is_measured(
    day: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
    complaint: str,
) -> None:
    arguments = ["validate", "--kitti-raw", str(day), "--out", str(tmp_path / "out")]
    assert run([*arguments, *options]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_without_a_name_each_question_has_a_folder_of_its_own(
    validated: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    attack = ["--attack", '{"name": "facula", "camera": 1}', "--limit", "6", "--no-locate"]
    for more in (
        ["--limit", "6"],
        attack,
        ["--attack", '{"camera":1,"name":"facula"}', *attack[2:]],
    ):
        validated("--clean", "0.5", *more)
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == ["validate", "validate_2"]


def test_a_frame_of_other_images_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = drive_of_walls(tmp_path, 8)
    for number in (1, 6):
        path = drive / "image_01" / "data" / f"{number:010d}.png"
        cv2.imwrite(str(path), np.zeros((100, 240, 3), np.uint8))
    out = tmp_path / "out"
    arguments = ["validate", "--kitti-raw", str(drive), "--out", str(out), "--clean", "0.5"]
    assert run([*arguments, "--no-locate"]) == 3
    told = capsys.readouterr()
    for id in ("0000000001", "0000000006"):
        assert f"left out: {id}: " in told.err
    assert "0000000007  sound" in told.out
    assert json.loads((out / "summary.json").read_text())["frames"] == 3


def test_measuring_clean_frames_goes_on_where_it_was_stopped(
    validated: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a stop after two of four: what was measured is neither lost nor measured again."""
    out, measured = tmp_path / "out", []

    def stopped_at(most: float) -> Callable[..., Any]:
        def shares(frame: SensorFrame, *others: Any) -> Any:
            if len(measured) == most:
                raise KeyboardInterrupt
            measured.append(frame.id)
            return shares_of(frame, *others)

        return shares

    options = ["--out", str(out), "--clean", "0.34", "--limit", "12", "--no-locate"]
    monkeypatch.setattr(fitting, "shares_of", stopped_at(2))
    validated(*options, code=130)
    monkeypatch.setattr(fitting, "shares_of", stopped_at(np.inf))
    validated(*options)
    assert measured == [f"{number:010d}" for number in range(4)]
    table = read_threshold_table(out / "thresholds.json")
    monkeypatch.undo()
    validated("--out", str(tmp_path / "whole"), *options[2:])
    whole = read_threshold_table(tmp_path / "whole" / "thresholds.json")
    np.testing.assert_array_equal(table.shares, whole.shares)
    assert table.on.data == whole.on.data


def test_only_what_is_asked_for_is_summed_up(validated: Lines, tmp_path: Path) -> None:
    first, out = tmp_path / "first", str(tmp_path / "out")
    validated("--out", str(first), "--clean", "0.5", "--no-locate")
    table = ["--thresholds", str(first / "thresholds.json"), "--out", out, "--no-locate"]
    assert [len(validated(*table, "--limit", count)) for count in ("5", "2", "5")] == [6, 3, 6]
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["frames"] == 5


@pytest.mark.slow
def test_who_judges_what_thresholds_were_made_of_is_told(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = ["validate", "--kitti-raw", str(day), "--no-locate", "--rate", "0"]
    assert run([*first, "--out", str(tmp_path / "first"), "--clean", "0.25"]) == 0
    assert "says little" not in capsys.readouterr().err
    table = ["--thresholds", str(tmp_path / "first" / "thresholds.json")]
    assert run([*first, *table, "--out", str(tmp_path / "again")]) == 0
    assert "3 of the 12 frames were among those that" in capsys.readouterr().err
    # Nor does one drive of that day say more.
    (drive,) = day.glob("*_sync")
    judged = ["validate", "--kitti-raw", str(drive), "--no-locate", "--rate", "0"]
    assert run([*judged, *table, "--out", str(tmp_path / "drive")]) == 0
    assert "3 of the 12 frames were among those that" in capsys.readouterr().err
    # Others of the same name do.
    other = tmp_path / "elsewhere" / day.name
    shutil.copytree(day, other)
    (other / drive.name).rename(other / drive.name.replace("0001", "0007"))
    judged[2] = str(other)
    assert run([*judged, *table, "--out", str(tmp_path / "other")]) == 0
    assert "among those" not in capsys.readouterr().err


def test_a_damaged_line_is_named(validated: Lines, tmp_path: Path, capsys: Any) -> None:
    out = tmp_path / "out"
    options = ["--out", str(out), "--clean", "0.5", "--no-locate"]
    validated(*options)
    rows = (out / "frames.jsonl").read_text().split("\n")
    (out / "frames.jsonl").write_text("\n".join(["{", *rows[1:]]))
    validated(*options, code=1)


def test_a_changed_frame_is_judged_anew_and_appended_ones_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, drive = drive_of_walls(tmp_path / "first", 6), drive_of_walls(tmp_path, 3)
    fitted, out = tmp_path / "fitted", tmp_path / "out"
    common = ["validate", "--no-locate", "--rate", "0"]
    clean = ["--kitti-raw", str(first), "--out", str(fitted), "--clean", "0.7"]
    assert run([*common, *clean]) == 0
    capsys.readouterr()
    table = ["--thresholds", str(fitted / "thresholds.json")]
    judged = [*common, *table, "--kitti-raw", str(drive), "--out", str(out), "--json"]

    def lines(code: int = 0) -> tuple[list[dict], str]:
        assert run(judged) == code
        told = capsys.readouterr()
        return [json.loads(line) for line in told.out.splitlines()], told.err

    *before, _ = lines()[0]
    write_raw_frame(drive, 3, wall(COVERED))
    (*rows, _), told = lines()
    assert rows[:3] == before
    assert rows[3]["alarm"]
    assert "3 of 4 frames are kept from an earlier run" in told
    assert [path.stem for path in (out / "alarms").iterdir()] == ["0000000003"]
    # The frames change places: one is covered now, and the other one no longer.
    for sensor in ("image_00", "image_01", "image_02", "velodyne_points"):
        one, other = (next((drive / sensor / "data").glob(f"{number:010d}.*")) for number in (1, 3))
        held = one.read_bytes()
        one.write_bytes(other.read_bytes())
        other.write_bytes(held)
    (*rows, last), told = lines()
    assert {row["id"]: row["alarm"] for row in rows} == {
        f"{number:010d}": number == 1 for number in range(4)
    }
    assert last["summary"]["alarms"] == 1
    assert "2 of 4 frames are kept from an earlier run" in told
    assert [path.stem for path in (out / "alarms").iterdir()] == ["0000000001"]
    assert len((out / "frames.jsonl").read_text().splitlines()) == 4
    # What cannot be read any more has no result either.
    (drive / "image_01" / "data" / "0000000001.png").write_bytes(b"no picture")
    (*rows, last), _ = lines(code=3)
    assert last["summary"]["frames"] == len(rows) == 3
    # Of another calibration nothing is kept.
    for path in drive.parent.glob("calib_*.txt"):
        path.unlink()
    rig = camera_rig([0.0, 0.4, 0.6], focal_length=201.0, centre=(120.0, 60.0), size=(240, 120))
    write_raw_calibration(drive.parent, rig.calibration, image_size=(240, 120))
    _, told = lines(code=3)
    assert "are kept" not in told


def test_changed_clean_frames_are_another_fit(validated: Lines, tmp_path: Path) -> None:
    drive = drive_of_walls(tmp_path, 6)
    options = ["--out", str(tmp_path / "out"), "--clean", "0.5", "--no-locate"]
    validated(*options, drive=drive)
    image = drive / "image_01" / "data" / "0000000001.png"
    shutil.copy(drive / "image_01" / "data" / "0000000002.png", image)
    validated(*options, drive=drive, code=1)


def test_a_file_that_json_names_counts_by_its_content(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["validate", "--kitti-raw", str(day), "--no-locate"]
    for name, share in (("a", "0.4"), ("b", "0.5")):
        assert run([*common, "--rate", "0", "--clean", share, "--out", str(tmp_path / name)]) == 0
    table = tmp_path / "a" / "thresholds.json"
    named = json.dumps({"name": "thresholds", "thresholds": str(table), "rate": 0.0})
    judged = [*common, "--validator", named, "--limit", "2", "--out", str(tmp_path / "out")]
    assert run(judged) == 0
    shutil.copy(tmp_path / "b" / "thresholds.json", table)
    capsys.readouterr()
    assert run(judged) == 1
    assert "of something else: files" in capsys.readouterr().err


def test_a_default_suite_of_another_world_is_another_recording(
    day: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["validate", "--no-locate", "--clean", "0.4", "--limit", "6"]
    words += ["--out", str(tmp_path / "out")]
    for code, name in enumerate(("raw-0123", "raw-4567")):
        suite = shutil.copytree(day, tmp_path / name / day.name).parent
        monkeypatch.setattr(export, "default_suite", lambda *_, suite=suite: suite)
        assert run(words) == code
    told = capsys.readouterr().err
    assert "recording default suite raw-0123, not default suite raw-4567" in told
