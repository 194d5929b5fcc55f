"""What every environment tells of a drive in `info`: always all keys, scalars only."""

from __future__ import annotations

import math
from typing import Any

from avsec_gym.metrics.safety import SafetyRecord


def drive_info(record: SafetyRecord | None, scenario: str, intention: str) -> dict[str, Any]:
    """`planned`, `collision`, `safe`, `cost` (s, nan if unplanned), `outcome`, and where.

    Args:
        record: Of the drive; None at reset, whose outcome is ``reset``.
        scenario: Its id.
        intention: Where the car wants to go.
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
