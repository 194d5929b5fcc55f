"""The answer to chapter 5's question in sentences that follow from the figures, whatever they are.

For each detector: ``coupled`` where the interval of the rank correlation between loss of precision
and loss of safety lies above zero; ``partly`` where nevertheless some pairs of attacks surely go
the other way; ``reversed`` where it lies below zero; ``decoupled`` where it holds zero and is
narrow; else it ``cannot tell``, whatever single pairs do: that two of many attacks go against each
other does not show that the others do not go together.  Of ``alike`` attacks, such as some that
take no safety at all, there is no correlation, and of ``few`` scenarios there is no answer.

The same is asked within each family of attacks.  Where attacks of a family go together, but not all
attacks, the detector is coupled ``within`` families: a point of precision may cost another amount
of safety in another family, which is no evidence against either.  Where all go together, but not
those of some family, it is coupled ``across`` families.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.decoupling import Decoupling, RankCorrelation, UnattackedRow
from avsec_gym.experiments.chapter5.families import (
    ALL_FAMILIES,
    ComparedFamilies,
    FamilyFigures,
    FamilyRow,
)
from avsec_gym.experiments.chapter5.losses import LossRow
from avsec_gym.experiments.chapter5.pairs_of_attacks import DiscordantPairs
from avsec_gym.experiments.chapter5.settings import PATCHES, PERTURBATIONS
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.many_comparisons import ALPHA

FEWEST = 3
"""Attacks that a rank correlation needs."""
FEWEST_SCENARIOS = 30
"""Fewest scenarios of which intervals can be drawn; of fewer, resampled scenes are too often the
same ones."""
NARROW = 0.3
"""A correlation that surely lies within this of zero is none that matters."""
NO_FAMILIES = FamilyFigures((), ())
"""Attacks of which families are not asked for."""

_WORDS = {
    "coupled": "Yes.",
    "partly": "Only in part.",
    "decoupled": "No.",
    "reversed": "No, rather the reverse.",
    "cannot tell": "This run cannot tell.",
    "alike": "This run cannot tell.",
    "few": "This run cannot tell.",
    "within": "Within a family of attacks.",
    "across": "Over families of attacks only.",
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
_COUPLED, _CONTRADICTS = ("coupled", "partly"), ("decoupled", "reversed")
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
        meaning: The answer in words.
        families: The same within each family of attacks, and what a point of precision costs in
            each, a sentence each.
    """

    detector: str
    name: str
    kind: str
    evidence: str
    took: Sequence[str]
    meaning: str
    families: Sequence[str]


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


def answer(decoupling: Decoupling, families: FamilyFigures = NO_FAMILIES) -> WordedAnswer:
    """The first thing that a report states.

    Args:
        decoupling: Losses of precision and of safety, and how far they go together.
        families: The same by family of attacks.
    """
    detectors = [_on_detector(row, decoupling, families) for row in decoupling.unattacked]
    known = [each for each in detectors if each.kind != "nothing"]
    kinds = list(dict.fromkeys(each.kind for each in known))
    meanings = list(dict.fromkeys(each.meaning for each in known))
    if not known:
        kind, sentence = "nothing", "The question needs three attacks or more."
    elif decoupling.scenarios < FEWEST_SCENARIOS:
        kind = "few"
        sentence = (
            f"{decoupling.scenarios} scenarios are too few: an answer takes "
            f"{FEWEST_SCENARIOS} or more."
        )
    else:
        kind = kinds[0] if len(kinds) == 1 else "depends"
        parts = [f"for {each.name}, {each.meaning}" for each in known]
        sentence = f"{_capital(meanings[0] if len(meanings) == 1 else '; '.join(parts))}."
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


def _on_detector(
    row: UnattackedRow, decoupling: Decoupling, families: FamilyFigures
) -> DetectorAnswer:
    attacks = [
        attack
        for attack in decoupling.attacks
        if attack.condition.detector == row.detector and attack.counts
    ]
    groups = (
        [attack for attack in attacks if attack.condition.attack in family]
        for family in (PERTURBATIONS, PATCHES[:1])
    )
    strongest = [max(group, key=_strength) for group in groups if group]
    kind, evidence = "nothing", "fewer than three attacks"
    if row.detector in decoupling.discordant_pairs:
        correlation = decoupling.rank_correlation[row.detector]
        pairs = decoupling.discordant_pairs[row.detector]
        kind = kind_of(correlation, pairs.discordant)
        if kind == "alike":
            evidence = f"{correlation.attacks} attacks, no correlation"
        elif kind != "nothing":
            evidence = _evidence(correlation, pairs)
    own = [each for each in families.rows if each.detector == row.detector]
    within = {
        each.family: kind_of(each.correlation, each.pairs.discordant)
        for each in own
        if each.family != ALL_FAMILIES
    }
    kind, meaning = _by_family(kind, within)
    return DetectorAnswer(
        row.detector,
        detector_name(row.detector),
        kind,
        evidence,
        [_sentence(row, attack) for attack in strongest],
        meaning,
        [
            *(_on_family(each, within[each.family]) for each in own if each.family in within),
            *_on_rates(row.detector, own, families.compared),
        ],
    )


def _by_family(pooled: str, within: Mapping[str, str]) -> tuple[str, str]:
    """The kind of answer for a detector in view of its families, and the answer in words.

    Args:
        pooled: The kind of all attacks together.
        within: The kind of each family.
    """
    go, do_not = (
        [family for family, kind in within.items() if kind in kinds]
        for kinds in (_COUPLED, _CONTRADICTS)
    )
    if pooled in (*_CONTRADICTS, "cannot tell") and go:
        exceptions = (
            "" if all(within[family] == "coupled" for family in go) else ", with exceptions"
        )
        return "within", (
            f"within {_and(go)}, attacks that take more precision take more safety{exceptions};"
            f" over families together, {_MEANS[pooled]}"
        )
    if pooled in _COUPLED and do_not:
        return "across", f"{_MEANS[pooled]}, but not within {_and(do_not)}"
    return pooled, _MEANS.get(pooled, "")


def _on_family(row: FamilyRow, kind: str) -> str:
    """What is known of the attacks of one family."""
    attacks = f"{row.correlation.attacks} {row.family}"
    if kind == "nothing":
        return f"Within {row.family}: {row.correlation.attacks} of {FEWEST} attacks, no answer."
    if kind == "alike":
        return f"Within {row.family}: {_MEANS[kind]} ({attacks})."
    return f"Within {row.family}: {_MEANS[kind]} ({_evidence(row.correlation, row.pairs)})."


def _on_rates(
    detector: str, rows: Sequence[FamilyRow], compared: Sequence[ComparedFamilies]
) -> Iterator[str]:
    """What a point of precision costs in each family, and which costs more."""
    rates = {row.family: row.exchange_rate for row in rows if row.family != ALL_FAMILIES}
    known = [
        f"{_value(rate)} where {family} take it"
        for family, rate in rates.items()
        if rate.value is not None
    ]
    if known:
        yield f"A point of average precision costs, in points of safe driving: {'; '.join(known)}."
    for row in compared:
        if row.detector != detector or row.difference.value is None:
            continue
        if row.p_holm is None or row.p_holm > ALPHA:
            yield f"That {row.first} and {row.second} differ in this is not sure."
        elif row.ratio.value is None:
            more = _value(row.difference, signed=True)
            yield f"{_capital(row.first)} cost {more} points more than {row.second}."
        else:
            yield f"{_capital(row.first)} cost {_value(row.ratio)} times as much as {row.second}."


def _evidence(correlation: RankCorrelation, pairs: DiscordantPairs) -> str:
    """The figures that a kind of answer rests on."""
    rho = number(correlation.rho, digits=2)
    interval = bounds(correlation.interval, digits=2)
    return (
        f"ρ = {rho} {interval} over {correlation.attacks} attacks; of {pairs.pairs} pairs"
        f" {pairs.concordant} surely go with it, {pairs.discordant} surely against it,"
        f" {pairs.undecided} are undecided"
    )


def _value(estimate: Estimate, *, signed: bool = False) -> str:
    value = number(estimate.value, digits=2, signed=signed)
    return f"{value} {bounds(estimate.interval, digits=2, signed=signed)}".strip()


def _and(names: Sequence[str]) -> str:
    return " and ".join(names)


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
