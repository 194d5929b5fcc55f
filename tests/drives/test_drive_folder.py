"""The folder of drives, gone on with: what is damaged in it is named before anything is done."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_type_hints

import pytest

from avsec_gym.drives.drive_folder import ROWS, SECONDS, DriveFolder
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.errors import DataError

RECORD = {"settings": {"truth": {}, "blind": {}}, "seed": 0}
ROW: dict[str, Any] = {
    "id": "truth/a/left", "setting": "truth", "scenario": "a", "intention": "left", "seed": 0,
    "steps": 20, "duration": 2, "outcome": "goal", "at_fault": False, "collision": False,
    "safe": True, "path_length": 15.1, "progress": 15.1, "smallest_distance": None,
    "time_to_collision": None, "cost_sm1": 4.2, "navsim_score": 0.8, "no_collision": 1.0,
    "drivable": 1.0, "ttc_bound": 1.0, "progress_share": 1.0, "comfort": 0.0, "touched": "",
    "hardest_braking": 0.0, "emergency_stops": 0, "alarms": 0, "first_plan": "safe",
}  # fmt: skip


def write(folder: Path, row: dict[str, Any], seconds: Any = 0.5) -> None:
    DriveFolder(folder, RECORD)
    (folder / ROWS).write_text(json.dumps(row) + "\n")
    (folder / SECONDS).write_text(json.dumps({"id": row.get("id"), "seconds": seconds}) + "\n")


def test_what_was_kept_is_there_again(tmp_path: Path) -> None:
    write(tmp_path, ROW)
    folder = DriveFolder(tmp_path, RECORD)
    assert folder.rows == {ROW["id"]: ROW}
    assert folder.seconds == {ROW["id"]: 0.5}


@pytest.mark.parametrize("name", get_type_hints(DriveRow))
def test_a_row_without_a_value_is_damaged(name: str, tmp_path: Path) -> None:
    write(tmp_path, {key: value for key, value in ROW.items() if key != name})
    with pytest.raises(DataError, match=r"drives\.jsonl: Line 1 is damaged"):
        DriveFolder(tmp_path, RECORD)


@pytest.mark.parametrize("name", get_type_hints(DriveRow))
@pytest.mark.parametrize("value", [[1], {"a": 1}, "gaol", 1e30])
def test_so_is_one_with_something_else(name: str, value: Any, tmp_path: Path) -> None:
    as_asked = isinstance(value, float) and isinstance(ROW[name], (float, int, type(None)))
    is_text = isinstance(value, str) and name == "touched"
    if (as_asked and type(ROW[name]) is not bool and name not in ("seed", "steps")) or is_text:
        pytest.skip("a value that it can have")
    write(tmp_path, {**ROW, name: value})
    with pytest.raises(DataError, match=r"drives\.jsonl"):
        DriveFolder(tmp_path, RECORD)


def test_a_row_is_of_a_drive_that_was_asked_for(tmp_path: Path) -> None:
    far, other = tmp_path / "far", tmp_path / "other"
    write(far, {**ROW, "setting": "far", "id": "far/a/left"})
    with pytest.raises(DataError, match="is of the setting 'far'"):
        DriveFolder(far, RECORD)
    write(other, {**ROW, "scenario": "b"})
    with pytest.raises(DataError, match="the scene 'b'"):
        DriveFolder(other, RECORD)


def test_a_row_has_its_seconds(tmp_path: Path) -> None:
    write(tmp_path, ROW)
    (tmp_path / SECONDS).write_text("")
    with pytest.raises(DataError, match=r"seconds\.jsonl: The seconds of 1 drives are missing"):
        DriveFolder(tmp_path, RECORD)
    (tmp_path / ROWS).write_text("")
    assert not DriveFolder(tmp_path, RECORD).rows


@pytest.mark.parametrize("seconds", [None, "0.5", [1], True])
def test_times_are_numbers(seconds: Any, tmp_path: Path) -> None:
    write(tmp_path, ROW, seconds)
    with pytest.raises(DataError, match=r"seconds\.jsonl: Line 1 is damaged"):
        DriveFolder(tmp_path, RECORD)
