"""`avsec connected`: lines, summaries, pictures, resumption, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.cli import run
from avsec_gym.commands.judged_instants import summary
from avsec_gym.drawing.connected_picture import draw_connected
from avsec_gym.errors import DataError
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.validation.connected.sources import connected_source
from avsec_gym.validation.connected.validator import ConnectedValidator
from tests.validation.connected.conftest import pose_at, scan_of
from tests.validation.connected.opv2v.opv2v_sample import write_sample

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
    # Another question has another folder.
    assert run([*command, "--method", "surfaces"]) == 1
    assert "of something else" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--data", "nowhere"], 1, "no such folder"),
        (["--attack", "burn"], 2, "burn"),
        (["--alarms", "1"], 2, "--alarms cannot be"),
        (["--limit", "0"], 2, "--limit cannot be"),
        (["--fit", "a.json", "--attack", "paste"], 2, "--fit measures"),
        (["--constants", "nothing.json"], 1, "nothing.json"),
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


def test_registration_is_for_raw_drives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_sample(tmp_path)
    command = ["connected", "--data", str(tmp_path), "--poses", "registration"]
    assert run(command) == 2
    assert "raw drive" in capsys.readouterr().err
    with pytest.raises(DataError, match="no connected vehicles"):
        connected_source(Path(__file__).parent)


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
