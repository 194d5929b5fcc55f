"""The answer to chapter 5's question in sentences that follow from the figures, whatever they are.

For each detector: ``coupled`` where the interval of the rank correlation between loss of precision
and loss of safety lies above zero; ``partly`` where nevertheless some pairs of attacks surely go
the other way; ``reversed`` where it lies below zero; ``decoupled`` where it holds zero and is
narrow; else it ``cannot tell``, whatever single pairs do: that two of many attacks go against each
other does not show that the others do not go together.  Of ``alike`` attacks, such as some that
take no safety at all, there is no correlation, and of ``few`` scenarios there is no answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.decoupling import Decoupling, RankCorrelation, UnattackedRow
from avsec_gym.experiments.chapter5.losses import LossRow
from avsec_gym.experiments.chapter5.settings import PATCHES, PERTURBATIONS
from avsec_gym.metrics.estimate import Estimate

FEWEST = 3
"""Attacks that a rank correlation needs."""
FEWEST_SCENARIOS = 30
"""Fewest scenarios of which intervals can be drawn; of fewer, resampled scenes are too often the
same ones."""
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
_PRECISION, _SAFETY = "points of average precision", "points of safe driving"
_UNSURE = "did not measurably change"


@dataclass(frozen=True)
class DetectorAnswer:
    """The answer for one detector.

    Args:
        detector: The detector.
        name: The detector's name for readers.
        kind: The kind of answer, see above.
        evidence: The figures that it rests on.
        took: What the strongest perturbation and the random patch took, a sentence each.
    """

    detector: str
    name: str
    kind: str
    evidence: str
    took: Sequence[str]


@dataclass(frozen=True)
class WordedAnswer:
    """The answer to the chapter's question.

    Args:
        kind: The kind of answer, see above.
        word: The answer in a word or two.
        sentence: The answer as a sentence.
        detectors: The answer for each detector.
    """

    kind: str
    word: str
    sentence: str
    detectors: Sequence[DetectorAnswer]


def answer(decoupling: Decoupling) -> WordedAnswer:
    """The first thing that a report states."""
    detectors = [_on_detector(row, decoupling) for row in decoupling.unattacked]
    known = [each for each in detectors if each.kind != "nothing"]
    kinds = list(dict.fromkeys(each.kind for each in known))
    if not known:
        kind, sentence = "nothing", "The question needs three attacks or more."
    elif decoupling.scenarios < FEWEST_SCENARIOS:
        kind = "few"
        sentence = (
            f"{decoupling.scenarios} scenarios are too few: an answer takes "
            f"{FEWEST_SCENARIOS} or more."
        )
    elif len(kinds) == 1:
        kind, sentence = kinds[0], f"{_capital(_MEANS[kinds[0]])}."
    else:
        kind = "depends"
        parts = [f"for {each.name}, {_MEANS[each.kind]}" for each in known]
        sentence = f"{_capital('; '.join(parts))}."
    return WordedAnswer(kind, _WORDS[kind], sentence, detectors)


def kind_of(correlation: RankCorrelation, discordant: int) -> str:
    """The kind of answer that a rank correlation and the pairs that contradict it give.

    Args:
        correlation: The rank correlation of one detector's attacks.
        discordant: Number of the pairs that surely contradict it: they qualify what goes together
            on the whole, and prove nothing by themselves.
    """
    if correlation.rho is None or correlation.interval is None:
        return "alike" if correlation.attacks >= FEWEST else "nothing"
    low, high = correlation.interval
    if low > 0:
        return "partly" if discordant else "coupled"
    if high < 0:
        return "reversed"
    narrow = low >= -NARROW and high <= NARROW
    return "decoupled" if narrow else "cannot tell"


def _on_detector(row: UnattackedRow, decoupling: Decoupling) -> DetectorAnswer:
    attacks = [
        attack
        for attack in decoupling.attacks
        if attack.condition.detector == row.detector and attack.counts
    ]
    families = (
        [attack for attack in attacks if attack.condition.attack in family]
        for family in (PERTURBATIONS, PATCHES[:1])
    )
    strongest = [max(family, key=_strength) for family in families if family]
    kind, evidence = "nothing", "fewer than three attacks"
    if row.detector in decoupling.discordant_pairs:
        correlation = decoupling.rank_correlation[row.detector]
        pairs = decoupling.discordant_pairs[row.detector]
        kind = kind_of(correlation, pairs.discordant)
        if kind == "alike":
            evidence = f"{correlation.attacks} attacks, no correlation"
        elif kind != "nothing":
            rho = number(correlation.rho, digits=2)
            interval = bounds(correlation.interval, digits=2)
            evidence = (
                f"ρ = {rho} {interval} over {correlation.attacks} attacks; of {pairs.pairs} pairs"
                f" {pairs.concordant} surely go with it, {pairs.discordant} surely against it,"
                f" {pairs.undecided} are undecided"
            )
    took = [_sentence(row, attack) for attack in strongest]
    return DetectorAnswer(row.detector, detector_name(row.detector), kind, evidence, took)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _strength(row: LossRow) -> tuple[int, float]:
    order = PERTURBATIONS + PATCHES
    return order.index(row.condition.attack), row.condition.strength


def _sentence(clean: UnattackedRow, row: LossRow) -> str:
    name = attack_name(row.condition.attack, row.condition.strength)
    article = "The " if row.condition.attack in PATCHES else ""
    verb, first = _clause(row.precision_lost, clean.precision, _PRECISION)
    other, second = _clause(row.safety_lost, clean.safety, _SAFETY)
    if verb != other:
        return f"{article}{name} {verb} {first} and {other} {second}."
    return f"{article}{name} {verb} {first} {'or' if verb == _UNSURE else 'and'} {second}."


def _clause(lost: Estimate, clean: Estimate, unit: str) -> tuple[str, str]:
    """Verb, and what it did to how much."""
    whole = f"{number(clean.value)} {unit}"
    if lost.value is None or lost.interval is None:
        change = None if lost.value is None else -lost.value
        return _UNSURE, f"{whole} ({number(change, signed=True)})"
    low, high = lost.interval
    if low > 0:
        return "took", f"{number(lost.value)} of {whole}"
    if high < 0:
        return "added", f"{number(-lost.value)} to {whole}"
    unsure = bounds([-high, -low], signed=True)
    return _UNSURE, f"{whole} ({number(-lost.value, signed=True)} {unsure})"
