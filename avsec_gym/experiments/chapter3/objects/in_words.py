"""The results of chapter 3 on detectors under optical attacks, in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA
from avsec_gym.experiments.chapter3.objects.believed_points import PASTED_RAYS_LOST, PLANE
from avsec_gym.experiments.chapter3.objects.believed_rates import BelievedSummary
from avsec_gym.experiments.chapter3.objects.impact_rates import ImpactSummary
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import SensitivityCurve
from avsec_gym.experiments.chapter3.objects.tables import (
    SHOWN_LEVEL,
    OpticalSummaries,
    detector_words,
)

_RATE = 0.01


def optical_sentences(summaries: OpticalSummaries) -> list[str]:
    """Sentences on the parts that a run has figures of.

    Args:
        summaries: The results of a run.
    """
    sentences = []
    if summaries.baseline:
        for row in summaries.baseline.rows:
            if (row.iou, row.rate) == (0.5, _RATE):
                sentences.append(
                    f"Objects of {row.scenario} reveal {_percent(row.rates.average)} of the"
                    f" attacks, with {_percent(row.rates.false_alarms.rate)} false alarms (IoU 0.5,"
                    " r = 1 %)."
                )
    if summaries.impact:
        sentences += _impact(summaries.impact)
    if summaries.believed:
        sentences += _believed(summaries.believed)
    if summaries.sensitivity:
        sentences += [_sizes(*each) for each in summaries.sensitivity.curves.items()]
    return sentences


def _impact(impact: ImpactSummary) -> list[str]:
    lidar, camera = impact.lidar, impact.camera
    taken, clean = lidar.shares.taken, lidar.shares.clean
    sentences = [
        f"{detector_words(lidar.detector)} takes the bogus return for an obstacle in"
        f" {taken.count:,} of {taken.of:,} frames; without the attack it has one there in"
        f" {clean.count:,}."
    ]
    if camera is not None:
        values = [levels[SHOWN_LEVEL].value for levels in (camera.clean, camera.attacked)]
        sentences.append(
            f"A facula lowers {detector_words(camera.detector)}’s AP of cars from"
            f" {number(values[0], digits=2)} to {number(values[1], digits=2)} % ({SHOWN_LEVEL},"
            f" IoU {camera.iou:g})."
        )
    return sentences


def _believed(summary: BelievedSummary) -> list[str]:
    sentences = []
    for detector in summary.objects:
        rows = {row.kind: row for row in summary.rows if row.detector == detector}
        plane = _percent(rows[PLANE].newly.rate)
        sentence = (
            f"{detector_words(detector)} is led to see an obstacle by {plane} of the bogus planes"
        )
        if PASTED_RAYS_LOST in rows:
            car = _percent(rows[PASTED_RAYS_LOST].newly.rate)
            sentence += f", and by {car} of the scans of cars that hide what is behind them"
        sentences.append(f"{sentence}.")
    return sentences


def _sizes(what: str, curve: SensitivityCurve) -> str:
    unit = "px" if what == CAMERA else "m"
    first, last = curve.sizes[1], curve.sizes[-1]
    detected = [_percent(row.detected["any"].rate) for row in (first, last)]
    sentence = (
        f"{'Faculae' if what == CAMERA else 'Bogus returns'} of {first.size:g} to"
        f" {last.size:g} {unit} are detected in {detected[0]} to {detected[1]} of the frames"
    )
    if first.precision is None or last.precision is None:
        return f"{sentence}."
    levels = (first.precision, last.precision)
    lost = [number(precision[SHOWN_LEVEL].lost, digits=2) for precision in levels]
    return (
        f"{sentence}; they cost {detector_words(curve.detector)} {lost[0]} to {lost[1]} points"
        " of AP."
    )


def _percent(share: float | None) -> str:
    return f"{number(share, 100, 2)} %"
