"""What adds up over the instants of a drive, by hand."""

from __future__ import annotations

from typing import Any

from avsec_gym.commands.instant_rows import drive_of
from avsec_gym.commands.judged_sequences import JudgedSequences, drive_line
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.validation.connected.rays.sequential import SequentialTest
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.export import ConnectedInstant

_DRIVES = JudgedSequences(SequentialTest(limit=6.0, clip=5.0), 3)


def _row(id: str, score: float | None, attacked: bool = False) -> dict[str, Any]:
    return {"id": id, "score": score, "attack": {"victim": 1} if attacked else None}


def test_each_drive_adds_up_by_windows_of_its_own() -> None:
    scores = {"a": [2.0, None, 2.0, 2.0], "b": [-4.0, 4.0, 4.0, 9.0, 9.0]}
    rows = [
        _row(f"{drive}/{number}", score, drive == "b")
        for drive, values in scores.items()
        for number, score in enumerate(values)
    ]
    # The drives take turns in a folder of several; each is added up by itself.
    rows = sorted(rows, key=lambda row: row["id"][::-1])
    drives = {row["id"]: row["id"][0] for row in rows}
    first, second = _DRIVES.rows(rows, drives)
    # 2 + nothing + 2, and a window of its own for the fourth instant: never 6.
    assert (first.windows, first.alarms, first.alarm, first.highest) == (2, 0, None, 4.0)
    assert (second.windows, second.alarms, second.alarm) == (2, 2, "b/2")
    assert second.highest == 10.0
    assert (first.attacked, second.attacked) == (False, True)
    assert "no alarm" in drive_line(first)
    assert "ALARM from b/2 on" in drive_line(second)
    found = _DRIVES.summary([first, second])
    assert (found["windows"]["hits"], found["windows"]["cases"]) == (2, 4)
    expected = share_of([False, False, True, True], ["a", "a", "b", "b"])
    assert found["windows"]["interval"] == list(expected.interval or ())
    assert (found["drives"]["hits"], found["drives"]["cases"]) == (1, 2)


def test_the_drive_of_an_instant() -> None:
    truth = ConnectedInstant(3, 7, (), ())
    assert drive_of(RecordedInstant("000067", (), truth)) == "3"
    assert drive_of(RecordedInstant("2011_09_26/0005/000001", ())) == "2011_09_26/0005"
    assert drive_of(RecordedInstant("scenario/000069", (), truth)) == "scenario"
    assert drive_of(RecordedInstant("000004", ())) == "000004"
