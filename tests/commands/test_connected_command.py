"""`avsec connected`: lines, summaries, pictures, resumption, and what it refuses."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.cli import run
from avsec_gym.commands.instant_summary import summary
from avsec_gym.drawing import rerun_instant, rerun_stream
from avsec_gym.drawing.connected_picture import draw_connected
from avsec_gym.errors import DataError
from avsec_gym.kitti.sensor_files import write_points
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, make
from avsec_gym.storage.folder_lock import folder_lock
from avsec_gym.validation.connected import fitting, learned_fitting
from avsec_gym.validation.connected.fit import (
    SHIPPED_FIT,
    read_connected_fit,
    write_connected_fit,
)
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.proposals.sectors import SectorProposer
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.sources import connected_source
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import CARS, pose_at, scan_of
from tests.validation.connected.opv2v.opv2v_sample import write_ascii_pcd, write_sample

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)


def _row(
    alarm: bool, accused: list[int], outcome: str | None, id: str = "000000"
) -> dict[str, object]:
    attack = None if outcome is None else {"victim": 1, "kind": "ghost", "outcome": outcome}
    return {
        "id": id,
        "alarm": alarm,
        "accused": accused,
        "attack": attack,
        "attack_possible": True,
        "regions": 10,
        "decidable": 5,
        "bytes": [{"claims": 100}, {"claims": 300, "counts": 50}],
        "refused": [],
        "seconds": {"propose": 0.1, "claim": 0.2},
    }


def test_the_summary_counts_what_was_detected_named_and_named_wrongly() -> None:
    found = summary(
        [
            _row(True, [1], "named"),
            _row(True, [], "detected"),
            _row(False, [], "missed"),
            _row(False, [], "not seen by two"),
            _row(True, [0], "misnamed"),
            _row(False, [], None),
        ]
    )
    assert (found["alarms"]["hits"], found["alarms"]["cases"]) == (3, 6)
    assert (found["attacks_detected"]["hits"], found["attacks_detected"]["cases"]) == (3, 5)
    assert found["attacks_detected_decidable"]["cases"] == 4
    assert (found["victims_named"]["hits"], found["victims_named"]["cases"]) == (1, 3)
    assert found["wrongly_named"]["hits"] == 1
    assert found["bytes_largest"] == 350
    assert found["decidable_share"] == 0.5
    assert found["seconds"] == pytest.approx(0.3)
    assert found["seconds_of"] == {"claim": 0.2, "propose": 0.1}
    with pytest.raises(DataError, match="no instant"):
        summary([])


def test_instants_of_one_drive_count_less() -> None:
    found = [
        summary([_row(part == 0, [], None, name.format(part, n)) for part in (0, 1) for n in "abc"])
        for name in ("{0}{1}", "drive_{0}/{1}")
    ]
    intervals = [each["alarms"]["interval"] for each in found]
    assert intervals == [pytest.approx(wilson_interval(3, 6)), pytest.approx(wilson_interval(1, 2))]
    assert found[0]["alarms"]["rate"] == found[1]["alarms"]["rate"] == 0.5


def test_a_folder_of_opv2v_is_judged_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    write_sample(tmp_path / "data")
    command = ["connected", "--data", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert run([*command, "--json", "--limit", "1"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["schema"] for line in lines] == [
        "avsec.connected.instant/1",
        "avsec.connected.summary/1",
    ]
    assert lines[1]["summary"]["instants"] == 1
    assert run([*command, "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(lines) == 3
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["instants"] == 2
    # Another look at the same instants: what adds up over the drive.
    assert run([*command, "--json", "--sequence", "2"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["schema"].partition("/")[0] for line in lines[2:]] == [
        "avsec.connected.drive",
        "avsec.connected.summary",
    ]
    assert (lines[2]["instants"], lines[2]["windows"]) == (2, 1)
    assert lines[3]["summary"]["sequence"]["drives"]["cases"] == 1
    assert run([*command, "--sequence", "2"]) == 0
    shown = capsys.readouterr().out
    assert f"drive {lines[2]['drive']}: " in shown
    assert "windows of successive instants that alarm" in shown
    # Another question has another folder.
    assert run([*command, "--method", "surfaces"]) == 1
    assert "of something else" in capsys.readouterr().err


def test_only_what_is_asked_for_is_summed_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    write_sample(tmp_path / "data")
    out = tmp_path / "out"
    command = ["connected", "--data", str(tmp_path / "data"), "--out", str(out)]
    for more, instants, kept in ((), 2, 0), (("--limit", "1"), 1, 1), ((), 2, 2):
        assert run([*command, *more]) == 0
        assert json.loads((out / "summary.json").read_text())["instants"] == instants
        told = f"{kept} of {instants} instants are kept from an earlier run"
        assert (told in capsys.readouterr().err) == (kept > 0)


def test_pictures_are_counted_among_the_instants_that_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("yaml")
    monkeypatch.setattr(ConnectedResult, "alarm", True)
    data, out = tmp_path / "data", tmp_path / "out"
    one, other = (write_sample(data), write_sample(tmp_path / "other", ("00050", "00060")))
    command = ["connected", "--data", str(data), "--out", str(out), "--pictures", "1"]
    assert run(command) == 0
    # Other instants stand before them now.
    for vehicle in ("641", "650"):
        for file in (other / vehicle).iterdir():
            file.rename(one / vehicle / file.name)
    assert run([*command, "--limit", "2"]) == 0
    drawn = sorted(path.stem[-5:] for path in (out / "alarms").iterdir())
    assert drawn == ["00050", "00069"]


def test_a_changed_instant_is_judged_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    scenario, out = write_sample(tmp_path / "data"), tmp_path / "out"
    command = ["connected", "--data", str(tmp_path / "data"), "--out", str(out), "--json"]
    assert run(command) == 0
    *before, _ = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    path = scenario / "641" / "00071.pcd"
    write_ascii_pcd(path, np.array([[20.0 + 0.01 * i, 6.0, -1.0] for i in range(40)]))
    assert run(command) == 0
    told = capsys.readouterr()
    *rows, _ = (json.loads(line) for line in told.out.splitlines())
    assert rows[0] == before[0]
    assert rows[1]["recorded"] != before[1]["recorded"]
    assert "1 of 2 instants are kept" in told.err
    assert len((out / "frames.jsonl").read_text().splitlines()) == 2


def test_a_fit_that_was_stopped_goes_on_with_the_same_question_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    write_sample(tmp_path / "data")
    write_sample(tmp_path / "other")
    file = tmp_path / "fit.json"
    samples = tmp_path / "fit.json.samples.jsonl"

    def stopped(*_: Any, samples: Path, **__: Any) -> None:
        samples.touch()
        with pytest.raises(DataError, match="Another process"), folder_lock(tmp_path):
            pass
        raise KeyboardInterrupt

    monkeypatch.setattr(fitting, "fit_connected", stopped)
    command = ["connected", "--fit", str(file), "--data"]
    same = [*command, str(tmp_path / "data")]
    assert run(same) == run(same) == 130
    capsys.readouterr()
    for other, what in (
        ([*command, str(tmp_path / "other")], "data "),
        ([*same, "--seed", "1"], "seed 0, not 1"),
        ([*same, "--poses", "true"], "poses measured, not true"),
    ):
        assert run(other) == 1
        told = capsys.readouterr().err
        assert f"{samples}: What was measured is of something else: " in told
        assert what in told
        assert "Take this file away" in told
    # Something else lies in the place of the data.
    (tmp_path / "data" / "2021_08_22_21_41_24" / "data_protocol.yaml").write_text("{}")
    assert run(same) == 1
    assert "fingerprint" in capsys.readouterr().err
    samples.unlink()
    assert run(same) == 130


def test_a_fit_knows_the_weights_that_proposed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    write_sample(tmp_path / "data")
    monkeypatch.setattr(SectorProposer, "__call__", lambda _, points: ClusterProposer()(points))
    fitted_on: dict[str, Any] = {}

    def measured(*asked: Any, **_: Any) -> None:
        fitted_on.update(asked[2].data)
        raise KeyboardInterrupt

    monkeypatch.setattr(fitting, "fit_connected", measured)
    given = ["connected", "--data", str(tmp_path / "data")]
    assert run([*given, "--fit", str(tmp_path / "clusters.json")]) == 130
    assert "proposals_weights" not in fitted_on
    proposing = [*given, "--proposals", "pixor"]
    assert run([*proposing, "--fit", str(tmp_path / "pixor.json")]) == 130
    today = weights_hash(make(Kind.DETECTOR, "pixor"))
    assert fitted_on["proposals_weights"] == today
    # What was measured with other weights is not gone on with.
    kept = tmp_path / "pixor.json.samples.json"
    kept.write_text(kept.read_text().replace(str(today), "0" * 64))
    (tmp_path / "pixor.json.samples.jsonl").touch()
    assert run([*proposing, "--fit", str(tmp_path / "pixor.json")]) == 1
    assert "proposals_weights" in capsys.readouterr().err
    # What decides is held against the weights that propose.
    shipped = read_connected_fit(SHIPPED_FIT)
    for digest, proposals, reported in (
        ("0" * 64, "pixor", True),
        (today, "pixor", False),
        ("0" * 64, "pointrcnn", False),
    ):
        file = tmp_path / f"{proposals}_{reported}.json"
        data = {**shipped.data, "proposals": proposals, "proposals_weights": digest}
        write_connected_fit(file, replace(shipped, data=data))
        words = ["--constants", str(file), "--limit", "1", "--out", str(tmp_path / file.stem)]
        assert run([*proposing, *words]) == 0
        told = f"proposals of other weights of pixor (00000000) than propose here ({today:.8})"
        assert (told in capsys.readouterr().err) == reported


@pytest.mark.parametrize("method", ["rays", "learned"])
def test_a_fit_that_is_there_is_refused_before_anything_is_measured(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module, name in ((fitting, "fit_connected"), (learned_fitting, "fit_learned")):
        monkeypatch.setattr(module, name, lambda *_, **__: pytest.fail("it was measured"))
    file = tmp_path / "fit.json"
    file.write_text("{}")
    write_sample(tmp_path / "data")
    command = ["connected", "--data", str(tmp_path / "data"), "--method", method]
    assert run([*command, "--fit", str(file)]) == 1
    assert f"{file}: This file exists" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--data", "nowhere"], 1, "no such folder"),
        (["--attack", "burn"], 2, "burn"),
        (["--alarms", "1"], 2, "--alarms cannot be"),
        (["--limit", "0"], 2, "--limit cannot be"),
        (["--fit", "a.json", "--attack", "paste"], 2, "--fit measures"),
        (["--constants", "nothing.json"], 1, "nothing.json"),
        (["--rrd", "alarm.png"], 2, "ends in .rrd"),
        (["--fit", "a.json", "--rrd", "a.rrd"], 2, "without --rrd"),
        (["--sequence", "1"], 2, "--sequence cannot be"),
        (["--sequence", "10", "--method", "surfaces"], 2, "goes with"),
        (["--model", "a.json"], 2, "--method learned"),
        (["--method", "learned", "--model", "nothing.json"], 1, "nothing.json"),
        (["--method", "learned", "--fit", "a.json", "--attack", "paste"], 2, "--fit measures"),
    ],
)
def test_what_cannot_be_is_refused_in_words(
    arguments: list[str],
    code: int,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["connected", *arguments]) == code
    assert words in capsys.readouterr().err


def test_a_folder_that_another_process_writes_is_left_to_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("yaml")
    write_sample(tmp_path / "data")
    out = tmp_path / "out"
    out.mkdir()
    with folder_lock(out):
        assert run(["connected", "--data", str(tmp_path / "data"), "--out", str(out)]) == 1
    assert f"{out}: Another process is writing here" in capsys.readouterr().err
    assert not list(out.iterdir())


def test_registration_is_for_raw_drives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_sample(tmp_path)
    command = ["connected", "--data", str(tmp_path), "--poses", "registration"]
    assert run(command) == 2
    assert "raw drive" in capsys.readouterr().err
    with pytest.raises(DataError, match="no connected vehicles"):
        connected_source(Path(__file__).parent)


def _day(root: Path) -> Path:
    """A day of drives: one without scans, one with a broken scan, one with a whole instant."""
    for number in (1, 2, 3):
        drive = root / "2026_01_01" / f"2026_01_01_drive_{number:04d}_sync"
        (drive / "oxts" / "data").mkdir(parents=True)
        (drive / "oxts" / "data" / "0000000000.txt").touch()
        for index in range(3) if number > 1 else ():
            path = drive / "velodyne_points" / "data" / f"{5 * index:010d}.bin"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_points(path, scan_of(pose_at(index, 0, 0), *CARS).points)
        if number == 2:
            path.write_bytes(b"cut")
    return root / "2026_01_01"


@pytest.mark.slow
def test_drives_that_cannot_be_judged_are_left_out_and_the_rest_is_registered(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["connected", "--data", str(_day(tmp_path)), "--poses", "registration"]
    command += ["--out", str(tmp_path / "out")]
    assert run([*command, "--json"]) == 3
    captured = capsys.readouterr()
    row, total = (json.loads(line) for line in captured.out.splitlines())
    assert row["id"] == "2026_01_01_drive_0003_sync/0000000005"
    before, middle, after = row["registrations"]
    assert middle is None
    for each in (before, after):
        assert each["residual"] < 0.05
        assert each["overlap"] > 0.5
    assert total["summary"]["left_out"] == 2
    assert "left out: 2026_01_01_drive_0001_sync: " in captured.err
    assert "left out: 2026_01_01_drive_0002_sync/0000000005: " in captured.err
    # What is known already is told again, with its residuals.
    assert run(command) == 3
    line = capsys.readouterr().out.splitlines()[0]
    assert f"registered to {before['residual']:.3f} m, {after['residual']:.3f} m" in line


def test_where_no_drive_can_be_judged_that_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = _day(tmp_path) / "2026_01_01_drive_0001_sync"
    assert run(["connected", "--data", str(drive), "--out", str(tmp_path / "out")]) == 1
    assert "no 3 scans" in capsys.readouterr().err


def test_a_recording_is_of_the_first_alarm_or_of_the_first_instant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("yaml")
    written: list[tuple[str, int]] = []

    def kept(scans: Sequence[VehicleScan], path: Path, result: ConnectedResult) -> None:
        assert path == tmp_path / "alarm.rrd"
        written.append((result.id, len(scans)))

    # The extra may be absent; what a recording holds is tested beside the writer.
    monkeypatch.setattr(rerun_stream, "check_rerun", lambda: None)
    monkeypatch.setattr(rerun_instant, "write_instant_recording", kept)
    names = connected_source(write_sample(tmp_path / "data")).names
    command = ["connected", "--data", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    command += ["--rrd", str(tmp_path / "alarm.rrd")]
    assert run(command) == 0
    assert [name for name, _ in written] == [names[0]]
    assert written[0][1] > 1
    # The same instants, known by now; the second one with an alarm.
    rows = tmp_path / "out" / "frames.jsonl"
    first, second = rows.read_text().splitlines()
    rows.write_text(f"{first}\n{json.dumps(json.loads(second) | {'alarm': True})}\n")
    assert run(command) == 0
    assert [name for name, _ in written[1:]] == [*names]


def test_a_picture_shows_the_alarm() -> None:
    poses = (pose_at(0, 0, 0), pose_at(30, 2, np.pi), pose_at(14, -12, np.pi / 2))
    scans = [scan_of(pose, _CAR) for pose in poses]
    scans[1] = scan_of(poses[1], _CAR, _GHOST)
    result = ConnectedValidator().validate(scans, id="000004")
    figure = draw_connected(result, scans)
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[1].startswith("A: ghost, vehicle 1")
    # Claims of the victim and rays of both others that pass through them.
    lines = [line for line in figure.axes[1].lines if line.get_color() == "#D7263D"]
    assert len(lines) > 10
    assert figure.axes[1].get_legend().texts[0].get_text() == "claimed by 1"
