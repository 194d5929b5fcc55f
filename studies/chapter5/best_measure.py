"""Which measure works best, by rule: over attacks of all families, and in single episodes.

A rule, so that no reader picks a measure by eye among dozens of rows.  Over attacks the best is the
one whose loss has the highest rank correlation with the loss of safety over all attacks on all
detectors: attacks of several families lie on one line only if a point of the measure costs as much
safety whichever family takes it.  In single episodes it is the one with the largest area under the
ROC curve over all attacks.  Beside it stand those that are not surely worse, where it is weakest,
and what is known of its limits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.metrics.estimate import Interval
from avsec_gym.metrics.many_comparisons import ALPHA
from avsec_gym.report.markdown_table import interval, number
from studies.chapter5.case_measures import (
    CARS_FOUND,
    CONTACT_AGREEMENT,
    CONTACT_RECALL,
    CONTESTED,
    PLANNING_KL,
    REACH_FOUND,
    SUPPORT,
)
from studies.chapter5.telling_flips import FlipRow
from studies.chapter5.telling_measures import (
    ALL_ATTACKS,
    BOTH,
    LOW_PRECISION,
    PRECISION,
    MeasureRow,
)

_EVERYTHING = (BOTH, ALL_ATTACKS)
"""Detector and family of the rows over all attacks."""
_NO_GHOSTS = "it counts no ghosts"
_ASKS = "it asks the planner that is then judged, and holds for no other"
LIMITS: Mapping[str, str] = {
    PRECISION: "it counts cars that no way leads near, and asks for boxes that fit closely",
    LOW_PRECISION: "it counts cars that no way leads near",
    CARS_FOUND: f"it counts cars that no way leads near, and {_NO_GHOSTS}",
    REACH_FOUND: f"it does not know which way is driven, and {_NO_GHOSTS}",
    CONTACT_RECALL: f"{_NO_GHOSTS}, nor where a found box stands",
    CONTACT_AGREEMENT: "it takes the straight way to the goal for the one that is driven",
    SUPPORT: "it takes the plan on the truth for the one that is driven",
    CONTESTED: f"{_ASKS}; {_NO_GHOSTS}, nor objects that are missed together",
    PLANNING_KL: _ASKS,
}
"""What each measure does not know."""
WEIGHTED_RECALLS = {
    CONTACT_RECALL: "by the time to contact",
    CONTESTED: "of objects that must not be missed",
}
"""Measures that `avsec_gym.metrics.safety_weighted_recall` computes, and by which weights."""


@dataclass(frozen=True)
class BestOf:
    """The measure that works best at one task.

    Args:
        measure: Its name.
        value: The rank correlation, or the area under the ROC curve.
        interval: The 95 % interval of it.
        surely_more: Whether it is surely larger than that of the average precision, after Holm's
            correction for all rows.
        not_surely_worse: Other measures whose intervals hold the value.
        weakest: Detector, family and value where it is lowest; None without rows of families.
    """

    measure: str
    value: float
    interval: Interval | None
    surely_more: bool
    not_surely_worse: Sequence[str]
    weakest: tuple[str, str, float] | None


@dataclass(frozen=True)
class BestMeasure:
    """What the rule finds.

    Args:
        over_attacks: The best one over attacks; None where no correlation is known.
        in_episodes: The best one in single episodes; None where no episode became unsafe.
    """

    over_attacks: BestOf | None
    in_episodes: BestOf | None


def best_measure(measures: Sequence[MeasureRow], flips: Sequence[FlipRow]) -> BestMeasure:
    """The measures that work best.

    Args:
        measures: Rows of `telling_rows`.
        flips: Rows of `flip_rows`.
    """
    return BestMeasure(
        _best([(row, row.rho) for row in measures]), _best([(row, row.area) for row in flips])
    )


def sentences(found: BestMeasure, scenarios: int) -> list[str]:
    """The same in words, and no more than the figures show.

    Args:
        found: What the rule finds.
        scenarios: Number of scenarios that the rows rest on.
    """
    tasks = {
        "Over attacks of all families": (found.over_attacks, "ρ"),
        "In single drives": (found.in_episodes, "area"),
    }
    lines = [
        f"{task}, {_on_task(best, what)}"
        for task, (best, what) in tasks.items()
        if best is not None
    ]
    if not lines:
        return [
            "No measure can be compared: there are too few attacks, and no drive became unsafe."
        ]
    known = [best for best, _ in tasks.values() if best is not None]
    if len(known) == 2 and known[0].measure != known[1].measure:
        lines.append("No measure is best at both.")
    for measure in dict.fromkeys(best.measure for best in known):
        limits = f"Limits of *{measure}*: {LIMITS[measure]}."
        if measure in WEIGHTED_RECALLS:
            limits += f" It is the `safety_weighted_recall` {WEIGHTED_RECALLS[measure]}."
        lines.append(limits)
    if not any(best.measure in WEIGHTED_RECALLS for best in known):
        lines.append("No `safety_weighted_recall` is best at either.")
    lines.append(f"All of it rests on {scenarios:,} scenarios and these attacks.")
    return lines


def _on_task(best: BestOf, what: str) -> str:
    text = f"*{best.measure}* works best: {what} {interval(best.value, best.interval, 2)}"
    if best.measure != PRECISION:
        sure = "surely" if best.surely_more else "not surely"
        text += f", {sure} more than {PRECISION}"
    if best.weakest is not None:
        detector, family, value = best.weakest
        text += f"; least for {family} of {detector_name(detector)}, {number(value, 2)}"
    if best.not_surely_worse:
        text += f". Not surely worse: {', '.join(best.not_surely_worse)}"
    return f"{text}."


def _best(rows: Sequence[tuple[MeasureRow | FlipRow, float | None]]) -> BestOf | None:
    """Of equal ones the first."""
    known = [(row, value) for row, value in rows if value is not None]
    pooled = [(row, value) for row, value in known if (row.detector, row.family) == _EVERYTHING]
    if not pooled:
        return None
    best, value = max(pooled, key=lambda found: found[1])
    parts = [
        (row.detector, row.family, part)
        for row, part in known
        if row.measure == best.measure and row.detector != BOTH and row.family != ALL_ATTACKS
    ]
    return BestOf(
        best.measure,
        value,
        best.interval,
        best.p_holm is not None and best.p_holm <= ALPHA and (best.more.value or 0.0) > 0,
        [
            row.measure
            for row, _ in pooled
            if row.measure != best.measure and row.interval is not None and row.interval[1] >= value
        ],
        min(parts, key=lambda part: part[2], default=None),
    )
