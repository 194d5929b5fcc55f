"""Rows of a run in which it is known what every method finds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.experiments.chapter4.measured_state import KnownAttack, MeasuredState
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_GEOMETRY,
    BY_RAYS,
    CLEAN,
    FITTED,
    JUDGED,
    METHODS,
    NAMERS,
    USUAL,
    ConnectedCondition,
)
from avsec_gym.experiments.chapter4.state_rows import rows_of, setting_of
from avsec_gym.runs.experiment import Measurement
from avsec_gym.validation.connected.result import AttackKind, Naming

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
    """Ten regions with scores from 0 to 0.9, of which the last are not decidable.

    One is not by geometry, and one more not by the counts of rays. Rays name an honest vehicle at
    the first place.
    """
    scores, numbers = np.arange(REGIONS) / REGIONS, np.arange(REGIONS)
    return MeasuredState(
        f"{number:06d}",
        None,
        {BY_GEOMETRY: numbers < REGIONS - 1, BY_RAYS: numbers < REGIONS - 2},
        {"surfaces": scores, "rays": scores - 1, "learned": scores - 2},
        dict.fromkeys(METHODS, scores),
        dict.fromkeys(NAMERS, np.zeros(0, np.int64)),
        {**dict.fromkeys(NAMERS, 0), "rays": int(number == 0)},
        DISTANCES,
        6,
        0,
        {"surfaces": 1.0, "rays": 0.01 * (number + 1), "learned": 1.1},
        {
            "proposals": np.array([10, 20, 30]),
            "claims": np.array([40, 100, 150]),
            "counts": np.array([50, 80, 120]),
            "crops": np.array([990, 2980, 1970]),
        },
        {"regions": 500},
    )


def attacked(number: int, kind: AttackKind = "ghost") -> MeasuredState:
    """Of five in turn: nothing there, not proposed, undecidable, missed by surfaces, found.

    The more so, the farther from the victim, and with 0, 2, 0, 1 and 3 witnesses.
    """
    turn = number % 5
    regions, witnesses = int(turn > 1), (0, 2, 0, 1, 3)[turn]
    category = ("Pedestrian" if turn == 1 else "Car") if kind == "removal" else ""
    by_surfaces = -np.inf if turn == 3 else 2.0
    alarm = Naming.NO_ALARM if turn == 3 else Naming.CANNOT_TELL
    named = {
        "thesis": Naming.NO_ALARM if turn == 3 else Naming.VICTIM,
        "surfaces": alarm,
        "rays": Naming.VICTIM,
        "learned": Naming.ANOTHER,
    }
    return MeasuredState(
        f"{number:06d}",
        KnownAttack(witnesses, 9.0 * turn + 1.0, category) if turn else None,
        {BY_GEOMETRY: np.full(regions, witnesses > 0), BY_RAYS: np.full(regions, turn == 4)},
        {
            "surfaces": np.full(regions, by_surfaces),
            "rays": np.full(regions, 5.0),
            "learned": np.full(regions, 4.0),
        },
        dict.fromkeys(METHODS, np.full(regions, 0.95)),
        {namer: np.full(regions, named[namer], np.int64) for namer in NAMERS},
        {**dict.fromkeys(NAMERS, 0), "thesis": int(turn == 4)},
        np.full(regions, 1.2),
        2 * regions,
        3 * int(turn == 4),
        dict.fromkeys(METHODS, 0.03),
        {},
        {},
    )


def known_rows(places: int, condition: ConnectedCondition = USUAL) -> list[Measurement]:
    """Of so many places of each part."""
    rows = []
    for number in range(places):
        rows += rows_of(clean(number), setting_of(FITTED, condition, CLEAN))
        rows += rows_of(clean(number), setting_of(JUDGED, condition, CLEAN))
        for kind in ATTACKS:
            rows += rows_of(attacked(number, kind), setting_of(JUDGED, condition, kind))
    return rows
