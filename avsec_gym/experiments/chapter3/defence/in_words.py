"""What a run of chapter 3 says of a validator before the detector, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter3.defence.defended_drives import NO_ATTACK
from avsec_gym.experiments.chapter3.defence.rates import ANY_ATTACK
from avsec_gym.experiments.chapter3.defence.tables import defended_detector
from avsec_gym.validation.response import Response

_WORTH = {
    "avoided_of_attack": ("collide only because of an attack", "do not collide"),
    "regained": ("are unsafe only because of an attack", "are safe again"),
}
"""Shares: of which drives, and what becomes of them."""


def defence_sentences(summary: Mapping[str, Any]) -> list[str]:
    """What each response is worth, and what it costs where nobody attacks.

    Args:
        summary: Of `avsec_gym.experiments.chapter3.defence.rates.defence_summary`.
    """
    rows = {(row["detector"], row["attack"], row["response"]): row for row in summary["worth"]}
    sentences = []
    for detector in dict.fromkeys(one for one, _, _ in rows):
        own = {
            response: rows[detector, ANY_ATTACK, response]
            for response in Response
            if (detector, ANY_ATTACK, response) in rows
        }
        for share, (which, now) in _WORTH.items():
            hits = {response: row[share] for response, row in own.items() if row[share]["of"]}
            if not hits:
                continue
            told = ", ".join(f"{_percent(hit)} ({response})" for response, hit in hits.items())
            count = next(iter(hits.values()))["of"]
            who = defended_detector(detector)
            whose = who[0].upper() + who[1:]
            sentences.append(f"{whose}: of {count:,} cases that {which}, {told} {now}.")
    for (_, attack, response), row in rows.items():
        if attack == NO_ATTACK and response == Response.STOP:
            sentences.append(
                f"Unattacked, a car that stops at alarms does so in {_percent(row['stopped'])} of"
                " the moments."
            )
            break
    return sentences


def _percent(hits: Mapping[str, Any]) -> str:
    return f"{number(hits['rate'], 100)} %"
