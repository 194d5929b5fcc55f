"""The answer to chapter 5's question in sentences that follow from the figures, whatever they are.

Of each detector: ``coupled`` where the interval of the rank correlation between loss of precision
and loss of safety lies above zero; ``partly`` where nevertheless some pairs of attacks surely go
the other way; ``reversed`` where it lies below zero; ``decoupled`` where it holds zero, and either
such pairs exist or it is narrow; else it ``cannot tell``.  Of ``alike`` attacks, such as some that
take no safety at all, there is no correlation, and of ``few`` scenarios there is no answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.settings import PATCHES, PERTURBATIONS

FEWEST = 3
"""Attacks that a rank correlation needs."""
FEWEST_SCENARIOS = 30
"""Of which intervals can be drawn; of fewer, resampled scenes are too often the same ones."""
NARROW = 0.3
"""A correlation that surely lies within this of zero is none that matters."""

_WORDS = {
    "coupled": "Yes.",
    "partly": "Only in part.",
    "decoupled": "No.",
    "reversed": "No, rather the reverse.",
    "cannot tell": "This run cannot tell.",
    "alike": "This run cannot tell.",
    "few": "This run cannot tell.",
    "depends": "It depends on the detector.",
    "nothing": "There is nothing to compare yet.",
}
_MEANS = {
    "coupled": "attacks that take more precision take more safety",
    "partly": "attacks that take more precision take more safety on the whole, with exceptions",
    "decoupled": "how much precision an attack takes does not tell how much safety it takes",
    "reversed": "attacks that take more precision take less safety",
    "cannot tell": "the interval of the rank correlation is too wide for an answer",
    "alike": "all attacks take the same of precision, or all the same of safety",
}
_UNITS = {"precision": "points of average precision", "safety": "points of safe driving"}
_UNSURE = "did not measurably change"
Answer = dict[str, Any]


def answer(decoupling: Mapping[str, Any]) -> Answer:
    """What is to be said first.

    Args:
        decoupling: As `avsec_gym.experiments.chapter5.decoupling.decoupling` gives it.

    Returns:
        ``kind``, ``word`` (the answer), ``sentence`` (what it means), and of each of the
        ``detectors`` its ``name``, ``kind``, ``evidence``, and ``took``: what the strongest
        perturbation and the random patch took.
    """
    detectors = [_on_detector(row, decoupling) for row in decoupling["unattacked"]]
    known = [one for one in detectors if one["kind"] != "nothing"]
    kinds = list(dict.fromkeys(one["kind"] for one in known))
    if not known:
        kind, sentence = "nothing", "The question needs three attacks or more."
    elif decoupling["scenarios"] < FEWEST_SCENARIOS:
        kind = "few"
        sentence = (
            f"{decoupling['scenarios']} scenarios are too few: an answer takes "
            f"{FEWEST_SCENARIOS} or more."
        )
    elif len(kinds) == 1:
        kind, sentence = kinds[0], f"{_capital(_MEANS[kinds[0]])}."
    else:
        kind = "depends"
        parts = [f"for {one['name']}, {_MEANS[one['kind']]}" for one in known]
        sentence = f"{_capital('; '.join(parts))}."
    return {"kind": kind, "word": _WORDS[kind], "sentence": sentence, "detectors": detectors}


def kind_of(correlation: Mapping[str, Any], discordant: int) -> str:
    """What a rank correlation and the pairs that surely contradict it come to."""
    if correlation["rho"] is None or correlation["interval"] is None:
        return "alike" if correlation["attacks"] >= FEWEST else "nothing"
    low, high = correlation["interval"]
    if low > 0:
        return "partly" if discordant else "coupled"
    if high < 0:
        return "reversed"
    narrow = low >= -NARROW and high <= NARROW
    return "decoupled" if discordant or narrow else "cannot tell"


def _on_detector(row: Mapping[str, Any], decoupling: Mapping[str, Any]) -> Answer:
    name = row["detector"]
    own = [one for one in decoupling["attacks"] if one["detector"] == name and one["counts"]]
    strongest = [
        max((one for one in own if one["attack"] in family), key=_strength, default=None)
        for family in (PERTURBATIONS, PATCHES[:1])
    ]
    kind, evidence = "nothing", "fewer than three attacks"
    if name in decoupling["discordant_pairs"]:
        correlation = decoupling["rank_correlation"][name]
        pairs = decoupling["discordant_pairs"][name]
        kind = kind_of(correlation, pairs["discordant"])
        if kind == "alike":
            evidence = f"{correlation['attacks']} attacks, no correlation"
        elif kind != "nothing":
            rho = number(correlation["rho"], digits=2)
            interval = bounds(correlation["interval"], digits=2)
            evidence = (
                f"ρ = {rho} {interval} over {correlation['attacks']} attacks,"
                f" {pairs['discordant']} of {pairs['pairs']} pairs contradict it"
            )
    return {
        "detector": name,
        "name": detector_name(name),
        "kind": kind,
        "evidence": evidence,
        "took": [_sentence(row, one) for one in strongest if one is not None],
    }


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _strength(one: Mapping[str, Any]) -> tuple[int, float]:
    order = PERTURBATIONS + PATCHES
    return order.index(one["attack"]), one["strength"]


def _sentence(row: Mapping[str, Any], one: Mapping[str, Any]) -> str:
    name = attack_name(one["attack"], one["strength"])
    article = "The " if one["attack"] in PATCHES else ""
    clauses: list[tuple[str, str]] = []
    for what, unit in _UNITS.items():
        lost, interval = one[f"{what}_lost"], one[f"{what}_lost_interval"]
        clauses.append(_clause(lost, interval, row[what], unit))
    (verb, first), (other, second) = clauses
    if verb != other:
        return f"{article}{name} {verb} {first} and {other} {second}."
    return f"{article}{name} {verb} {first} {'or' if verb == _UNSURE else 'and'} {second}."


def _clause(
    lost: float, interval: Sequence[float] | None, whole: float, unit: str
) -> tuple[str, str]:
    """Verb, and what it did to how much."""
    if interval is not None and interval[0] > 0:
        return "took", f"{number(lost)} of {number(whole)} {unit}"
    if interval is not None and interval[1] < 0:
        return "added", f"{number(-lost)} to {number(whole)} {unit}"
    unsure = f" {bounds([-interval[1], -interval[0]], signed=True)}" if interval else ""
    return _UNSURE, f"{number(whole)} {unit} ({number(-lost, signed=True)}{unsure})"
