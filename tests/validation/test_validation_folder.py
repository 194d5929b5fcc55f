"""What is kept of a recording, and what it comes to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.validation_folder import ValidationFolder, summary


def row(alarm: bool, attacked: list[int], truly: list[int], sensors: int = 4) -> dict[str, Any]:
    return {
        "alarm": alarm,
        "attacked": attacked,
        "truly_attacked": truly,
        "verdicts": dict.fromkeys(map(str, range(sensors)), "sound"),
        "seconds": 0.5,
    }


def test_alarms_on_moments_as_recorded_are_not_called_false() -> None:
    """Whether somebody attacked while they were recorded, nobody knows."""
    rows = [row(True, [3], []), row(False, [], []), row(True, [3], [3]), row(True, [1], [3])]
    found = summary(dict(zip("abcd", rows, strict=True)))
    assert not [name for name in found if "without" in name or "false" in name]
    assert found["alarms"] == 3
    assert found["alarms_as_recorded"]["count"] == 1
    assert found["alarms_as_recorded"]["of"] == 2
    assert found["attacks_noticed"]["rate"] == 1
    assert (found["attacks_named"]["count"], found["attacks_named"]["of"]) == (1, 2)
    assert found["attacked_sensors"] == {"3": 2, "1": 1}


def test_rows_of_another_format_are_not_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ValidationFolder(tmp_path, {"rate": 0.01}).add({"id": "0"})
    assert list(ValidationFolder(tmp_path, {"rate": 0.01}).rows) == ["0"]
    monkeypatch.setattr("avsec_gym.validation.validation_folder.FORMAT", 99)
    with pytest.raises(DataError, match="other settings"):
        ValidationFolder(tmp_path, {"rate": 0.01})
