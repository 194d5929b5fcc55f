"""What a run of chapter 3 answers, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.identification.five_sensors import FiveSummary
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    IdentificationRates,
    MethodRates,
)
from avsec_gym.experiments.chapter3.identification.summary import ValidationSummary
from avsec_gym.experiments.chapter3.identification.tables import BEYOND_IN_WORDS

_RATE = 0.01


def validation_sentences(summary: ValidationSummary) -> list[str]:
    """Detection, identification, false alarms, at r = 1 %.

    Args:
        summary: The results of a run.
    """
    detected = {
        (row.scenario, row.criterion): row.rates for row in summary.detection if row.rate == _RATE
    }
    sentences = []
    for scenario in dict.fromkeys(scenario for scenario, _ in detected):
        alone, every = detected[scenario, "error"], detected[scenario, "any"]
        sentences.append(
            f"{scenario[0].upper()}{scenario[1:]} detect {_percent(every.average)} of the"
            f" thesis’ attacks at r = 1 % ({_percent(alone.average)} by E alone), with"
            f" {_percent(every.false_alarms.rate)} false alarms."
        )
    named = _at_usual_rate(summary.identification)
    by_algorithm, likeliest = named["algorithm 2, any"], named["maximum likelihood"]
    sentences.append(
        f"The attacked one of four sensors is named in {_percent(by_algorithm.average)} of the"
        f" cases by algorithm 2 ({_percent(named['algorithm 2, error'].average)} by E alone) and"
        f" in {_percent(likeliest.average)} by maximum likelihood, with"
        f" {_percent(by_algorithm.false_alarms.rate)} and"
        f" {_percent(likeliest.false_alarms.rate)} false alarms."
    )
    if summary.beyond:
        least = min(summary.beyond, key=lambda row: row.detected.percent)
        kind = BEYOND_IN_WORDS[least.kind, least.sensor == 0]
        sentences.append(
            "Attacks beyond the thesis’ settings are detected less often: least"
            f" {kind} on S{least.sensor}, in {_percent(least.detected.rate)} of the"
            " frames."
        )
    return sentences


def five_sentence(summary: FiveSummary) -> str:
    """The identification rates of five sensors, at r = 1 %.

    Args:
        summary: The results of a run.
    """
    rows = _at_usual_rate(summary.identification)
    by_algorithm, likeliest = rows["algorithm 2, any"], rows["maximum likelihood"]
    one, two = (
        [_percent(row.together[count].rate) for row in (by_algorithm, likeliest)]
        for count in ("1", "2")
    )
    return (
        f"Of five sensors one that is attacked is named in {one[0]} of the cases by algorithm 2"
        f" and in {one[1]} by maximum likelihood, two together in {two[0]} and {two[1]}, with"
        f" {_percent(by_algorithm.false_alarms.rate)} and"
        f" {_percent(likeliest.false_alarms.rate)} false alarms."
    )


def _at_usual_rate(rows: Sequence[MethodRates]) -> dict[str, IdentificationRates]:
    """By the method."""
    return {row.method: row.rates for row in rows if row.rates.rate == _RATE}


def _percent(share: float | None) -> str:
    return f"{number(share, 100, 2)} %"
