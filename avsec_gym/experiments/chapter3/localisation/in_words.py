"""What a run of chapter 3 says of damage located and repaired, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.localisation.measures import CAR
from avsec_gym.experiments.chapter3.localisation.rates import BOGUS_SEEN
from avsec_gym.experiments.chapter3.objects.tables import detector_words

_ERRORS = ("error_before", "error_after")


def localisation_sentences(summary: Mapping[str, Any]) -> list[str]:
    """How well attacks are located, from the worst to the best, and what repair leaves.

    Args:
        summary: Of `avsec_gym.experiments.chapter3.localisation.rates.localisation_summary`.
    """
    located = (row for row in summary["attacks"] if row["iou"] is not None)
    rows = sorted(located, key=lambda row: row["iou"])
    if not rows:
        return []
    low, high = (f"{number(row['iou'], 100)} % ({row['attack']})" for row in (rows[0], rows[-1]))
    sentences = [f"Damage is located with a mean IoU of {low} to {high}."]
    lit = [row for row in rows if row["error_after"] is not None]
    if lit:
        before, after = (_range([row[name] for row in lit]) for name in _ERRORS)
        sentences.append(
            f"Where a facula changes an image it is off by {before} grey levels on average, by"
            f" {after} after the repair."
        )
    pasted = [row for row in rows if row["attack"] == CAR and row["bogus_after"] is not None]
    for row in pasted:
        clean, before, after = (f"{number(row[one], 100)} %" for one in BOGUS_SEEN)
        detector = detector_words(summary["scan_detector"])
        sentences.append(
            f"Where a car’s scan is pasted {detector} sees an obstacle in {before} of the moments,"
            f" after the repair in {after}; without attack in {clean}."
        )
    return sentences


def _range(values: list[float]) -> str:
    return f"{number(min(values))} to {number(max(values))}"
