"""The results of chapter 3 on a validator before the detector, in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.defence.defended_episodes import NO_ATTACK
from avsec_gym.experiments.chapter3.defence.rates import ANY_ATTACK, DefenceSummary
from avsec_gym.experiments.chapter3.defence.tables import defended_detector
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.validation.response import Response

_WORTH = {
    "avoided_of_attack": ("collide only because of an attack", "do not collide"),
    "regained": ("are unsafe only because of an attack", "are safe again"),
}
"""Shares: of which episodes, and what becomes of them."""


def defence_sentences(summary: DefenceSummary) -> list[str]:
    """What each response is worth, and what it costs without an attack.

    Args:
        summary: The rows of a run.
    """
    worth = {
        (row.detector, row.attack, row.response): row.worth
        for row in summary.worth
        if row.worth is not None
    }
    sentences = []
    for detector in dict.fromkeys(detector for detector, _, _ in worth):
        own = {
            response: worth[detector, ANY_ATTACK, response]
            for response in Response
            if (detector, ANY_ATTACK, response) in worth
        }
        for share, (which, now) in _WORTH.items():
            shares = {response: getattr(worth, share) for response, worth in own.items()}
            hits = {response: hit for response, hit in shares.items() if hit.of}
            if not hits:
                continue
            shown = ", ".join(f"{_percent(hit)} ({response})" for response, hit in hits.items())
            count = next(iter(hits.values())).of
            car = defended_detector(detector)
            car = car[0].upper() + car[1:]
            sentences.append(f"{car}: of {count:,} cases that {which}, {shown} {now}.")
    for (_, attack, response), row in worth.items():
        if attack == NO_ATTACK and response == Response.STOP:
            sentences.append(
                f"Unattacked, a car that stops at alarms does so in {_percent(row.stopped)} of"
                " the frames."
            )
            break
    return sentences


def _percent(hits: Share) -> str:
    return f"{number(hits.rate, 100)} %"
