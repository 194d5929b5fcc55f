"""What `avsec/ClosedLoop-v0` reports of a drive in `info`: always all keys, scalars only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from avsec_gym.closed_loop.drive_record import DriveRecord, Outcome

RESET, DRIVING = "reset", "driving"
"""Stand where the outcome would, before a drive's end."""
_BEFORE_THE_END = {
    "smallest_distance": math.inf,
    "cost_sm1": 0.0,
    "at_fault": 0.0,
    "time_to_collision": math.inf,
}
"""Metrics that are known at the end.  Before, they are no nan: Gymnasium's checker compares the
infos of a step that is repeated, and nan equals nothing."""
_PARTS = {
    "navsim_score": "total",
    "no_collision": "no_collision",
    "drivable": "drivable",
    "ttc_bound": "time_to_collision",
    "progress_share": "progress",
    "comfort": "comfort",
}


@dataclass(frozen=True)
class SoFar:
    """The metrics of a drive before its end.

    Args:
        duration: The time that was driven, seconds.
        path_length: Length of the driven path, metres.
        progress: Metres along the road.
    """

    duration: float = 0.0
    path_length: float = 0.0
    progress: float = 0.0


def drive_info(
    record: DriveRecord | None, scenario: str, intention: str, so_far: SoFar
) -> dict[str, Any]:
    """The outcome and the metrics of a drive.

    Args:
        record: What became of the drive; None before its end.
        scenario: The id of the scene.
        intention: The lane that the car wants to reach.
        so_far: The metrics that stand in for what is known at the end only.
    """
    safe = record is not None and record.outcome == Outcome.GOAL
    collision = record is not None and record.outcome == Outcome.COLLISION
    planned = safe or collision
    reached = record is None or planned
    last = so_far if record is None else record
    info: dict[str, Any] = {
        "planned": planned,
        "success": planned,
        "collision": collision,
        "safe": safe,
        "is_success": safe,
        "cost": float(last.duration) if reached else math.nan,
        "path_length": float(last.path_length),
        "progress": float(last.progress),
        "outcome": _outcome(record, so_far),
        "scenario": scenario,
        "intention": intention,
    }
    for name, before in _BEFORE_THE_END.items():
        info[name] = before if record is None else float(getattr(record, name))
    for name, part in _PARTS.items():
        info[name] = 0.0 if record is None else float(getattr(record.score, part))
    return info


def _outcome(record: DriveRecord | None, so_far: SoFar) -> str:
    if record is not None:
        return str(record.outcome)
    return DRIVING if so_far.duration > 0 else RESET
