"""The thesis' tables of chapter 3 with our figures, the thesis' beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.experiments.chapter3.thesis import DETECTION, IDENTIFICATION
from avsec_gym.report.page_table import Cell, Table, figure, name

METHODS = {
    "algorithm 2, error": "algorithm 2, E alone (the thesis’)",
    "algorithm 2, any": "algorithm 2, all four shares",
    "maximum likelihood": "maximum likelihood",
}
"""What ways to identify are called."""
CRITERIA = {"error": "E alone (the thesis’)", "any": "all four shares"}
"""What ways to detect are called."""
MEASURE_WORDS = {
    "error": "disparity error E",
    "hole_share": "share of holes",
    "densest": "densest contradiction",
    "brightness": "other brightness",
}
"""What the shares are called."""


def tables_of_validation(summary: Mapping[str, Any]) -> list[Table]:
    """Tables 3.1 and 3.2, and what the likelihood's probabilities are worth.

    Args:
        summary: As `avsec_gym.experiments.chapter3.summary.validation_summary` makes it.
    """
    return [
        _detection_table(summary["detection"]),
        _case_table(summary["detection"]),
        _identification_table(summary["identification"]),
        _honesty_table(summary["honesty"]),
    ]


def _detection_table(rows: Any) -> Table:
    lines = []
    for row in sorted(rows, key=lambda row: (row["scenario"], row["criterion"], row["rate"])):
        own = DETECTION.get((row["scenario"], row["rate"])) if row["criterion"] == "error" else None
        lines.append(
            [
                name(row["scenario"]),
                name(CRITERIA[row["criterion"]]),
                figure(row["rate"], scale=100, digits=0),
                figure(row["average"], row["interval"], own, scale=100, digits=2),
                _share(row["false_alarms"]),
            ]
        )
    return Table(
        "Table 3.1: detection rate, mean over the seven attack cases",
        ["sensors", "what counts", "r, %", "detected, %", "false alarms, %"],
        lines,
        "r: the designated false alarm rate, the share of the clean moments that thresholds were"
        " fitted on which lies beyond them; false alarms: what it comes to on clean moments that"
        " nothing was fitted on. In brackets: 95 % intervals, of detection by bootstrap over"
        " moments, of alarms Wilson’s. In italics: the thesis.",
        names=2,
    )


def _case_table(rows: Any) -> Table:
    chosen = [row for row in rows if row["rate"] == 0.01]
    cases = [list(row["cases"]) for row in chosen]
    lines = [
        [
            name(row["scenario"]),
            name(CRITERIA[row["criterion"]]),
            *(figure(row["cases"][case], scale=100) for case in names),
        ]
        for row, names in zip(chosen, cases, strict=True)
    ]
    positions = [_position(case, cases[0]) for case in cases[0]] if cases else []
    return Table(
        "Figures 3.6 and 3.8 at r = 1 %: detection rate in each attack case, %",
        ["sensors", "what counts", *positions],
        lines,
        "First, second and third: the LiDAR or the rightmost camera, and the cameras left of it.",
        names=2,
    )


def _position(case: str, cases: list[str]) -> str:
    single = [one for one in cases if "+" not in one]
    words = dict(zip(single, ("first", "second", "third"), strict=True))
    return " and ".join(words[one] for one in case.split("+"))


def _identification_table(rows: Any) -> Table:
    lines = []
    for row in rows:
        of_thesis = row["method"] == "algorithm 2, error" and row["rate"] in IDENTIFICATION
        own = IDENTIFICATION[row["rate"]] if of_thesis else (None,) * 5
        sensors = [
            figure(share["rate"], thesis=one, scale=100)
            for share, one in zip(row["sensors"].values(), own[:4], strict=True)
        ]
        lines.append(
            [
                name(METHODS[row["method"]]),
                figure(row["rate"], scale=100, digits=0),
                *sensors,
                figure(row["average"], row["interval"], own[4], scale=100, digits=2),
                _share(row["false_alarms"]),
                figure(row["beyond"]["rate"], scale=100),
            ]
        )
    return Table(
        "Table 3.2: identification rate of one LiDAR (S0) and three cameras",
        ["method", "r, %", "S0", "S1", "S2", "S3", "mean, %", "false alarms, %", "beyond n − 2, %"],
        lines,
        "Identified: exactly the attacked sensors were named. Mean: over attacks on one sensor, up"
        " to n − 2. Beyond n − 2: exactly named among two to four attacked sensors, where the"
        " thesis promises nothing.",
    )


def _honesty_table(told: Mapping[str, Any]) -> Table:
    lines = [
        [
            name("sensors that were told attacked or sound"),
            _share(told["told"]),
        ],
        [name("right, where told"), _share(told["right_where_told"])],
        *(
            [name(f"right, of all, with {count} attacked"), _share(share)]
            for count, share in told["right_by_attacked"].items()
        ),
        [name("Brier score of P(attacked)"), figure(told["brier"], digits=4)],
    ]
    return Table(
        "What the likelihood’s probabilities are worth",
        ["", "% (score as it is)"],
        lines,
        "Moments half of which are clean, the others in any state, at r = 1 %. A sensor is told"
        " where its probability is above 95 % or below 5 %; else the answer is that one cannot"
        " tell.",
    )


def _share(share: Mapping[str, Any]) -> Cell:
    return figure(share["rate"], share["interval"], scale=100, digits=2)
