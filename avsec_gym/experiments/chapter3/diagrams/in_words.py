"""What the diagrams of a run answer, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.diagrams.plots import MATCHER_WORDS, RULE_WORDS
from avsec_gym.experiments.chapter3.diagrams.summary import (
    NO_CHANGE,
    RULES,
    DiagramRow,
    DiagramsSummary,
)
from avsec_gym.experiments.chapter3.diagrams.thesis_marks import holds, thesis_detected
from avsec_gym.experiments.chapter3.diagrams.variant import is_of_lidar


def diagram_sentences(summary: DiagramsSummary) -> list[str]:
    """How far the figures spread over the open parameters, and where the thesis' lie.

    Args:
        summary: The results of a run.
    """
    sentences = []
    for words, of_lidar in (("Bogus objects", True), ("Lights", False)):
        rows = [row for row in summary.attacks if is_of_lidar(row.variant) == of_lidar]
        if rows:
            spread = ", ".join(f"{_spread(rows, rule)} by {RULE_WORDS[rule]}" for rule in RULES)
            sentences.append(f"{words} are detected in {spread}.")
            sentences.append(_where(words, rows))
    if summary.benign:
        sentences.append(_worst_change(summary))
    if summary.objects and summary.objects.believed:
        rates = [row.taken.percent for row in summary.objects.believed]
        sentences.append(
            f"Detectors take {number(min(rates))} to {number(max(rates))} % of bogus objects for"
            " obstacles, by their density and depth."
        )
    return sentences


def _spread(rows: Sequence[DiagramRow], rule: str) -> str:
    percents = [row.detected[rule].percent for row in rows]
    return f"{number(min(percents))} to {number(max(percents))} %"


def _where(words: str, rows: Sequence[DiagramRow]) -> str:
    """Where E alone has the thesis' figure."""
    there = [row for row in rows if row.variant.of_thesis]
    if not there:
        return f"{words} as the thesis has them are not among these."
    held = [row for row in there if holds(row.detected["error"], thesis_detected(row.variant))]
    if not held:
        return (
            f"{words}: the thesis’ detection rate by E lies in none of the {len(there)} settings"
            " that have what it states."
        )
    matchers = ", ".join(MATCHER_WORDS[name] for name in dict.fromkeys(row.matcher for row in held))
    return (
        f"{words}: the thesis’ detection rate by E lies in {len(held)} of the {len(there)} settings"
        f" that have what it states ({matchers})."
    )


def _worst_change(summary: DiagramsSummary) -> str:
    changed = [row for row in summary.benign if row.change != NO_CHANGE]
    parts = []
    for rule in RULES:
        clean = [row.alarms[rule].percent for row in summary.benign if row.change == NO_CHANGE]
        if changed and clean:
            worst = max(changed, key=lambda row: row.alarms[rule].percent)
            parts.append(
                f"{RULE_WORDS[rule]} {number(worst.alarms[rule].percent)} % ({worst.change},"
                f" {MATCHER_WORDS[worst.matcher]}; unchanged {number(max(clean))} % at most)"
            )
    return f"False alarms under the worst benign change: {'; '.join(parts)}."
