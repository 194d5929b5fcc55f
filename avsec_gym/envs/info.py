"""What every environment reports of a drive in `info`: always all keys, scalars only."""

from __future__ import annotations

import math
from typing import Any

from avsec_gym.metrics.safety import SafetyRecord


def drive_info(record: SafetyRecord | None, scenario: str, intention: str) -> dict[str, Any]:
    """`planned`, `collision`, `safe`, `cost` (s, nan if unplanned), `outcome`, and where.

    Args:
        record: The collision check of the drive; None at reset, whose outcome is ``reset``.
        scenario: The id of the scene.
        intention: The lane that the car wants to reach.
    """
    return {
        "planned": record is not None and record.planned,
        "collision": record is not None and record.collision,
        "safe": record is not None and record.safe,
        "cost": math.nan if record is None else float(record.cost),
        "outcome": "reset" if record is None else record.outcome,
        "scenario": scenario,
        "intention": str(intention),
    }
