"""Rows of a run in which it is known what every method finds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.experiments.chapter4.measured_state import (
    MeasuredState,
    rows_of,
    setting_of,
)
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    FITTED,
    JUDGED,
    METHODS,
    USUAL,
    ConnectedCondition,
)
from avsec_gym.runs.experiment import Measurement
from avsec_gym.validation.connected.result import Naming

REGIONS = 10
DISTANCES = np.array([0.1, 0.2, 1.5])


class Kept:
    """What cells came to, as a run keeps it."""

    def __init__(self, rows: Sequence[Measurement]) -> None:
        self._rows: dict[str, list[Measurement]] = {}
        for row in rows:
            self._rows.setdefault(row.setting, []).append(row)

    def measurements(self, setting: str) -> list[Measurement]:
        return self._rows.get(setting, [])

    def timings(self) -> dict[str, dict[str, float]]:
        return {"rays: claim, CPU": {"cells": 4, "seconds": 0.2}}


def clean(number: int) -> MeasuredState:
    """Ten regions with scores from 0 to 0.9, the last of which is not decidable."""
    scores = np.arange(REGIONS) / REGIONS
    nothing = np.zeros(0, np.int64)
    return MeasuredState(
        f"{number:06d}",
        False,
        np.arange(REGIONS) < REGIONS - 1,
        {"surfaces": scores, "rays": scores - 1, "learned": scores - 2},
        dict.fromkeys(METHODS, nothing),
        DISTANCES,
        {
            "surfaces": np.array([1000, 3000, 2000]),
            "rays": np.array([100, 200, 300]),
            "learned": np.array([1100, 3200, 2300]),
        },
    )


def attacked(number: int) -> MeasuredState:
    """Of five in turn: nothing there, not proposed, undecidable, missed by surfaces, found."""
    turn = number % 5
    regions = 0 if turn < 2 else 1
    by_surfaces = -np.inf if turn == 3 else 2.0
    named = {
        "surfaces": np.full(regions, Naming.NO_ALARM if turn == 3 else Naming.CANNOT_TELL),
        "rays": np.full(regions, Naming.VICTIM),
        "learned": np.full(regions, Naming.ANOTHER),
    }
    return MeasuredState(
        f"{number:06d}",
        turn > 0,
        np.full(regions, turn > 2),
        {
            "surfaces": np.full(regions, by_surfaces),
            "rays": np.full(regions, 5.0),
            "learned": np.full(regions, 4.0),
        },
        {method: named[method].astype(np.int64) for method in METHODS},
        np.full(regions, 1.2),
        dict.fromkeys(METHODS, np.zeros(0, np.int64)),
    )


def known_rows(places: int, condition: ConnectedCondition = USUAL) -> list[Measurement]:
    """Of so many places of each part."""
    rows = []
    for number in range(places):
        rows += rows_of(clean(number), setting_of(FITTED, condition, CLEAN))
        rows += rows_of(clean(number), setting_of(JUDGED, condition, CLEAN))
        for kind in ATTACKS:
            rows += rows_of(attacked(number), setting_of(JUDGED, condition, kind))
    return rows
