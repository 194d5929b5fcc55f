"""What is said of a frame on one line."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.commands.validation_line import validation_line

SOUND: dict[str, Any] = {
    "id": "000107",
    "alarm": False,
    "attacked": [],
    "statuses": {"lidar": "sound", "1": "sound", "3": "sound", "2": "sound"},
    "probabilities": None,
    "exceeded": [],
    "damage": {},
    "seconds": 0.25,
    "locating_seconds": None,
}
BRIGHT = {"sensors": ["lidar", 3, 2], "share": "brightness", "value": 0.0334, "threshold": 0.0021}
DENSE = {"sensors": [1, 3, 2], "share": "densest", "value": 0.01, "threshold": 0.009}


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ({}, "000107  sound  (0.25 s)"),
        (
            {
                "alarm": True,
                "attacked": [3],
                "statuses": {**SOUND["statuses"], "3": "attacked"},
                "exceeded": [BRIGHT, DENSE],
                "damage": {"3": {"share_of_pixels": 0.1234}},
                "locating_seconds": 0.1,
            },
            "000107  ALARM: camera 3 (12.3 % of its pixels)  (other brightness 0.0334 > 0.0021 of "
            "LiDAR against camera 3, seen by camera 2; 1 more beyond their thresholds; 0.25 s; "
            "0.10 s to locate)",
        ),
        (
            {
                "alarm": True,
                "attacked": ["lidar", 2],
                "statuses": {
                    "lidar": "attacked",
                    "1": "cannot tell",
                    "3": "sound",
                    "2": "attacked",
                },
                "exceeded": [DENSE],
                "damage": {
                    "lidar": {"points": 412, "lost_directions": 7},
                    "2": {"unknown": "trusted are: none"},
                },
            },
            "000107  ALARM: LiDAR (412 points, 7 directions lost), camera 2 (too few sensors are "
            "sound to locate it); nothing clears camera 1  (densest window 0.01 > 0.009 "
            "of camera 1 against camera 3, seen by camera 2; 0.25 s)",
        ),
        (
            {
                "statuses": {**SOUND["statuses"], "1": "cannot tell"},
                "probabilities": {"lidar": 0.001, "1": 0.3},
            },
            "000107  no alarm, though nothing clears camera 1  "
            "(P(attacked): LiDAR 0.001, camera 1 0.300; 0.25 s)",
        ),
        (
            {"alarm": True, "attacked": [2], "damage": {"2": {"share_of_pixels": 0.0}}},
            "000107  ALARM: camera 2 (no damage found)  (0.25 s)",
        ),
        (
            {
                "alarm": True,
                "attacked": ["lidar"],
                "damage": {"lidar": {"points": 0, "lost_directions": 120}},
            },
            "000107  ALARM: LiDAR (120 directions lost)  (0.25 s)",
        ),
        (
            {"alarm": True, "statuses": dict.fromkeys(SOUND["statuses"], "cannot tell")},
            "000107  ALARM: some sensor; which one, and where, is open  (0.25 s)",
        ),
    ],
)
def test_it_says_who_where_and_why(row: dict[str, Any], expected: str) -> None:
    assert validation_line(SOUND | row) == expected
