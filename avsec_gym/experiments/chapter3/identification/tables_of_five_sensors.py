"""What is named of five sensors, as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter3.identification.tables import (
    INTERVALS,
    METHODS,
    PRIOR,
    TOLD,
    share_cell,
)


def table_of_five(told: Mapping[str, Any]) -> Table:
    """What is named of five sensors.

    Args:
        told: Of `avsec_gym.experiments.chapter3.identification.five_sensors.five_summary`.
    """
    lines = [
        [
            name(METHODS[row["method"]]),
            figure(row["rate"], scale=100, digits=0),
            *map(share_cell, row["together"].values()),
            figure(row["average"], row["interval"], scale=100, digits=2),
            *(share_cell(row[one]) for one in ("told", "false_alarms", "beyond")),
        ]
        for row in told["identification"]
    ]
    return Table(
        "Identification rate of one LiDAR and four cameras",
        [
            *("method", "r, %", "one attacked, %", "two attacked, %", "mean, %"),
            *("mean of what is told, %", "false alarms, %", "beyond n − 2, %"),
        ],
        lines,
        f"{told['moments']['judged']:,} moments in all 32 states, on none of which anything was"
        f" fitted. Identified: exactly the attacked sensors were named. {TOLD} Beyond n − 2: among"
        f" three to five attacked sensors. {PRIOR} {INTERVALS}",
    )
