"""What is kept of a recording, and what it comes to."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.repair.damage import Damage
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validation_folder import (
    FORMAT,
    ROWS,
    ValidationFolder,
    row_of,
    summary,
)
from avsec_gym.validation.validator import Validation

SENSORS = {"sensors": [LIDAR, 3, 2]}
KEPT: dict[str, Any] = {
    "id": "0", "alarm": True, "attacked": [3], "truly_attacked": [], "probabilities": None,
    "statuses": {"lidar": "sound", "3": "attacked", "2": "cannot tell"},
    "shares": {"lidar,3,2": {"error": 0.1}}, "damage": {"3": {"share_of_pixels": 0.5}},
    "exceeded": [
        {"sensors": ["lidar", 3, 2], "share": "densest", "value": 0.4, "threshold": 0.2}
    ],
    "seconds": 0.5, "locating_seconds": 0.1,
}  # fmt: skip


def row(alarm: bool, attacked: list[int], truly: list[int], sensors: int = 4) -> dict[str, Any]:
    return {
        "alarm": alarm,
        "attacked": attacked,
        "truly_attacked": truly,
        "statuses": dict.fromkeys(map(str, range(sensors)), "sound"),
        "probabilities": None,
        "seconds": 0.5,
    }


def test_alarms_on_frames_as_recorded_are_not_called_false() -> None:
    """Whether there was an attack while they were recorded is unknown."""
    rows = [row(True, [3], []), row(False, [], []), row(True, [3], [3]), row(True, [1], [3])]
    found = summary(dict(zip("abcd", rows, strict=True)))
    assert not [name for name in found if "without" in name or "false" in name]
    assert found["alarms"] == 3
    assert found["alarms_as_recorded"]["count"] == 1
    assert found["alarms_as_recorded"]["of"] == 2
    assert found["attacks_detected"]["rate"] == 1
    assert (found["attacks_named"]["count"], found["attacks_named"]["of"]) == (1, 2)
    assert found["attacked_sensors"] == {"3": 2, "1": 1}


def test_rows_of_another_format_are_not_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = {**SENSORS, "rate": 0.01}
    ValidationFolder(tmp_path, record).add(KEPT)
    assert ValidationFolder(tmp_path, record).rows == {"0": KEPT}
    monkeypatch.setattr("avsec_gym.validation.validation_folder.FORMAT", 99)
    with pytest.raises(DataError, match=f"something else: rows {FORMAT}, not 99"):
        ValidationFolder(tmp_path, record)


def test_it_is_said_in_what_others_differ_and_an_empty_folder_belongs_to_no_one(
    tmp_path: Path,
) -> None:
    ValidationFolder(tmp_path, {**SENSORS, "rate": 0.01, "seed": 1})
    (tmp_path / ROWS).unlink()
    # Nothing was kept: a mistyped option is no reason to name another folder.
    ValidationFolder(tmp_path, {**SENSORS, "rate": 0.02, "seed": 1}).add(KEPT)
    with pytest.raises(DataError, match=r"something else: rate 0\.02, not 0\.03; seed 1, not None"):
        ValidationFolder(tmp_path, {**SENSORS, "rate": 0.03})


def test_the_time_to_locate_damage_is_kept_where_damage_was_located(
    wall_of: Callable[[int], SensorFrame],
) -> None:
    system = SensorSystem((LIDAR, 1, 0))
    errors = DisparityErrors(DisparityMaps(wall_of(0), system))
    statuses = {LIDAR: SensorStatus.SOUND, 0: SensorStatus.ATTACKED, 1: SensorStatus.SOUND}
    validation = Validation(True, statuses, errors)
    half = np.arange(240) < 120
    damage = {0: Damage(pixels=np.tile(half, (120, 1)))}
    located, alone = (
        row_of("7", validation, frozenset({0}), found, (0.25, 0.125)) for found in (damage, {})
    )
    assert located["attacked"] == located["truly_attacked"] == [0]
    assert (located["seconds"], located["locating_seconds"]) == (0.25, 0.125)
    assert located["damage"] == {"0": {"share_of_pixels": 0.5}}
    assert alone["locating_seconds"] is None
    assert alone["damage"] == {}


def test_a_damaged_line_tells_its_number(tmp_path: Path) -> None:
    folder = ValidationFolder(tmp_path, SENSORS)
    for id in "012":
        folder.add({**KEPT, "id": id})
    lines = (tmp_path / ROWS).read_text().splitlines()
    (tmp_path / ROWS).write_text("\n".join([lines[0], lines[1][:5], lines[2]]) + "\n")
    with pytest.raises(DataError, match=r"frames\.jsonl: Line 2 is damaged"):
        ValidationFolder(tmp_path, SENSORS)
    # A last line that was cut off is done again.
    (tmp_path / ROWS).write_text("\n".join([lines[0], lines[1][:5]]))
    assert list(ValidationFolder(tmp_path, SENSORS).rows) == ["0"]


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("alarm", 1, "alarm is 1"),
        ("statuses", {"3": "sonud"}, "statuses is"),
        ("statuses", {"4": "sound"}, "names ['4']"),
        ("attacked", ["left"], "names ['left']"),
        ("attacked", 3, "attacked is 3"),
        ("truly_attacked", [7], "names ['7']"),
        ("probabilities", {"x": 0.5}, "names ['x']"),
        ("probabilities", {"3": "high"}, "probabilities is"),
        ("damage", {"3": {"points": "many"}}, "damage is"),
        ("damage", {"0": {"points": 3}}, "names ['0']"),
        ("exceeded", [{"sensors": ["lidar", 3, 2], "share": "densest"}], "exceeded is"),
        ("exceeded", [{**KEPT["exceeded"][0], "share": "E"}], "exceeded is"),
        ("exceeded", [{**KEPT["exceeded"][0], "sensors": [3, 2]}], "three sensors"),
        ("seconds", None, "seconds is None"),
        ("seconds", 1e308, "no frame takes"),
        ("locating_seconds", -1.0, "no frame takes"),
        ("shares", [], "shares is"),
    ],
)
def test_a_row_is_what_the_summary_needs(
    name: str, value: Any, problem: str, tmp_path: Path
) -> None:
    ValidationFolder(tmp_path, SENSORS).add({**KEPT, name: value})
    with pytest.raises(DataError, match=rf"frames\.jsonl.*{re.escape(problem)}"):
        ValidationFolder(tmp_path, SENSORS)


def test_a_likelihood_names_one_of_three_sensors() -> None:
    named = row(True, [3], [3], sensors=3)
    found = summary({"a": named, "b": {**named, "probabilities": {"3": 1.0}}})
    assert (found["attacks_named"]["count"], found["attacks_named"]["of"]) == (1, 1)


def test_frames_of_one_drive_count_less() -> None:
    rows = {f"{drive}/{n}": row(drive == "a", [], []) for drive in "ab" for n in range(10)}
    apart, together = summary(rows), summary(rows, {id: id[0] for id in rows})
    assert apart["alarms_as_recorded"]["interval"] == pytest.approx(wilson_interval(10, 20))
    assert together["alarms_as_recorded"]["interval"] == pytest.approx(wilson_interval(1, 2))
    assert together["alarms_as_recorded"]["rate"] == apart["alarms_as_recorded"]["rate"] == 0.5
