"""The results of chapter 3 on damage located and repaired, in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.localisation.measures import CAR
from avsec_gym.experiments.chapter3.localisation.rates import LocalisationSummary
from avsec_gym.experiments.chapter3.objects.tables import detector_words


def localisation_sentences(summary: LocalisationSummary) -> list[str]:
    """How well attacks are located, from the worst to the best, and what repair leaves.

    Args:
        summary: The rows of a run.
    """
    ious = [(row.iou, row) for row in summary.attacks if row.iou is not None]
    rows = [row for _, row in sorted(ious, key=lambda one: one[0])]
    if not rows:
        return []
    low, high = (f"{number(row.iou, 100)} % ({row.attack})" for row in (rows[0], rows[-1]))
    sentences = [f"Damage is located with a mean IoU of {low} to {high}."]
    errors = [
        (row.error_before, row.error_after)
        for row in rows
        if row.error_before is not None and row.error_after is not None
    ]
    if errors:
        before, after = (list(values) for values in zip(*errors, strict=True))
        sentences.append(
            f"Where a facula changes an image it is off by {_range(before)} grey levels on average,"
            f" by {_range(after)} after the repair."
        )
    for row in rows:
        if row.attack == CAR and row.bogus_after is not None:
            seen = (row.bogus_clean, row.bogus_before, row.bogus_after)
            clean, attacked, repaired = (f"{number(share, 100)} %" for share in seen)
            detector = detector_words(summary.scan_detector)
            sentences.append(
                f"Where a car’s scan is pasted {detector} sees an obstacle in {attacked} of the"
                f" frames, after the repair in {repaired}; without attack in {clean}."
            )
    return sentences


def _range(values: list[float]) -> str:
    return f"{number(min(values))} to {number(max(values))}"
