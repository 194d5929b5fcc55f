"""What is kept of a recording, and what it comes to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
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
    ValidationFolder(tmp_path, {"rate": 0.01}).add({"id": "0"})
    assert list(ValidationFolder(tmp_path, {"rate": 0.01}).rows) == ["0"]
    monkeypatch.setattr("avsec_gym.validation.validation_folder.FORMAT", 99)
    with pytest.raises(DataError, match=f"something else: rows {FORMAT}, not 99"):
        ValidationFolder(tmp_path, {"rate": 0.01})


def test_it_is_said_in_what_others_differ_and_an_empty_folder_belongs_to_no_one(
    tmp_path: Path,
) -> None:
    ValidationFolder(tmp_path, {"rate": 0.01, "seed": 1})
    (tmp_path / ROWS).unlink()
    # Nothing was kept: a mistyped option is no reason to name another folder.
    ValidationFolder(tmp_path, {"rate": 0.02, "seed": 1}).add({"id": "0"})
    with pytest.raises(DataError, match=r"something else: rate 0\.02, not 0\.03; seed 1, not None"):
        ValidationFolder(tmp_path, {"rate": 0.03})


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
    folder = ValidationFolder(tmp_path, {})
    for id in "012":
        folder.add({"id": id})
    lines = (tmp_path / ROWS).read_text().splitlines()
    (tmp_path / ROWS).write_text("\n".join([lines[0], lines[1][:5], lines[2]]) + "\n")
    with pytest.raises(DataError, match=r"frames\.jsonl: Line 2 is damaged"):
        ValidationFolder(tmp_path, {})
    # A last line that was cut off is done again.
    (tmp_path / ROWS).write_text("\n".join([lines[0], lines[1][:5]]))
    assert list(ValidationFolder(tmp_path, {}).rows) == ["0"]


def test_a_likelihood_names_one_of_three_sensors() -> None:
    named = row(True, [3], [3], sensors=3)
    found = summary({"a": named, "b": {**named, "probabilities": {"3": 1.0}}})
    assert (found["attacks_named"]["count"], found["attacks_named"]["of"]) == (1, 1)
