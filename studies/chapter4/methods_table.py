"""The table of docs/connected.md: what each method finds, and what it takes."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.naming_rates import ENOUGH_WITNESSES
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_RAYS,
    FIVE,
    METHODS,
    OPERATING_RATE,
    USUAL,
)
from avsec_gym.experiments.chapter4.shown_figures import IN_WORDS
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, share
from studies.result_fields import ResultField, bounds_at, field, number_at, row

_FOUND = field("chapter4", "connected")


def methods_table() -> list[str]:
    """Lines of the table: three vehicles at the usual errors, names of five, by counted rays."""
    rows = []
    for method in METHODS:
        at = {"condition": USUAL.name, "method": method}
        detection = [
            _FOUND.then("detection", row(**at, kind=kind, of="regions", rate=OPERATING_RATE))
            for kind in ATTACKS
        ]
        areas = [
            _FOUND.then("roc", row(**at, kind=kind), "area_by_rays", "value") for kind in ATTACKS
        ]
        names = [
            _FOUND.then(
                "namings",
                row(
                    condition=FIVE.name,
                    namer=method,
                    kind=kind,
                    by=BY_RAYS,
                    witnesses=ENOUGH_WITNESSES,
                ),
                "victim",
            )
            for kind in ATTACKS
        ]
        time = _FOUND.then("after_proposals", row(**at, state="clean"), "median")
        rows.append(
            [
                IN_WORDS[method],
                *(_share(place.then("detected_by_rays")) for place in detection),
                _share(detection[0].then("false_alarms_by_rays")),
                *(_number(area, 1, 3) for area in areas),
                *(_share(named) for named in names),
                _number(_FOUND.then("sent", row(**at), "mean"), 1, 0),
                _number(time, 1000, 0),
            ]
        )
    columns = [
        "method",
        *(f"{kind}s detected, %" for kind in ATTACKS),
        "false alarms, % of regions",
        *(f"AUC, {kind}s" for kind in ATTACKS),
        *(f"of five vehicles, victims of {kind}s named, %" for kind in ATTACKS),
        "bytes a vehicle",
        "ms an instant",
    ]
    return markdown_table(columns, rows)


def _share(place: ResultField) -> str:
    bounds = bounds_at(place.then("interval"))
    if bounds is None:
        return UNKNOWN
    low, high = (share(bound) for bound in bounds)
    return f"{share(number_at(place.then('rate')))} ({low}–{high})"


def _number(place: ResultField, scale: float, digits: int) -> str:
    value = number_at(place)
    return UNKNOWN if value is None else f"{scale * value:,.{digits}f}"
