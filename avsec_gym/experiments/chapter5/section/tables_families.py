"""Tables of losses by family of attacks, and of contested scenes beside all scenes."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, name, p_value
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.experiments.chapter5.contested_scenes import ContestedFigures
from avsec_gym.experiments.chapter5.families import ComparedFamilies, FamilyFigures, FamilyRow
from avsec_gym.experiments.chapter5.losses import LossRow
from avsec_gym.experiments.chapter5.pairs_of_attacks import DiscordantPairs
from avsec_gym.experiments.chapter5.section.condition_cells import condition_names, count_cell
from avsec_gym.experiments.chapter5.section.estimate_cell import estimate_cell
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.safety import COLLIDED, SAFE_DRIVING, SUCCESS, SafetyRates

_RESAMPLED = "In brackets: 95 % bootstrap intervals over scenarios, each with all its attacks."
_RATE = (
    "Exchange rate: points of safe driving lost for each point of average precision, the ratio of"
    " what all attacks of the family take; unknown where they do not surely take precision."
)
_PAIRS = (
    "Of a pair that surely goes with the claim, one attack takes more of both; both differences are"
    " sure after Holm’s correction for all pairs of the detector."
)


def family_table(figures: FamilyFigures) -> Table:
    """Correlation, exchange rate and pairs of each family."""
    return Table(
        "Losses by family of attacks",
        ["detector", "family", "attacks", "ρ", "AP taken", "safe driving taken", "exchange rate",
         "pairs with it", "against it", "undecided"],
        [
            [
                name(detector_name(row.detector)),
                name(row.family),
                count_cell(row.correlation.attacks),
                estimate_cell(_rho(row), digits=2),
                estimate_cell(row.precision_lost),
                estimate_cell(row.safety_lost),
                estimate_cell(row.exchange_rate, digits=2),
                *_pairs(row.pairs),
            ]
            for row in figures.rows
        ],
        "ρ: Spearman’s rank correlation of what attacks take of average precision and of safe"
        " driving; of fewer than three there is none. Taken: in the mean over the attacks, in"
        f" percentage points. {_RATE} {_PAIRS} {_RESAMPLED}",
        names=2,
    )  # fmt: skip


def compared_table(rows: Sequence[ComparedFamilies]) -> Table:
    """Exchange rates of two families against each other."""
    return Table(
        "Exchange rates between families of attacks",
        ["detector", "family", "against", "times as much", "difference", "p, corrected",
         "pairs with it", "against it", "undecided"],
        [
            [
                name(detector_name(row.detector)),
                name(row.first),
                name(row.second),
                estimate_cell(row.ratio, digits=2),
                estimate_cell(row.difference, digits=2, signed=True),
                TableCell(p_value(row.p_holm), key=row.p_holm),
                *_pairs(row.pairs),
            ]
            for row in rows
        ],
        "How much more safety a point of precision costs that the first family takes: their"
        " exchange rates divided, and subtracted, in the same bootstrap draws. p: of a difference"
        f" of zero, corrected by Holm’s method for the number of rows. Pairs of an attack of each."
        f" {_PAIRS} {_RESAMPLED}",
        names=3,
    )  # fmt: skip


def contested_loss_table(every: Sequence[LossRow], contested: Sequence[LossRow]) -> Table:
    """What attacks take in all scenes, and in contested ones."""
    of_contested = {row.condition: row for row in contested}
    return Table(
        "What each attack takes, in all scenes and in contested ones",
        ["detector", "attack", *("all", "contested") * 2],
        [
            [
                *condition_names(row.condition),
                estimate_cell(row.precision_lost),
                estimate_cell(_precision_of(of_contested.get(row.condition))),
                estimate_cell(row.safety_lost),
                estimate_cell(_safety_of(of_contested.get(row.condition))),
            ]
            for row in every
            if not row.condition.whole_levels
        ],
        "In percentage points. Contested: episodes that are unsafe for a car that sees nothing and"
        " safe for one that sees all; precision is that of the scenes which have such an episode."
        f" {_RESAMPLED}",
        [("", 2), ("average precision taken", 2), ("safe driving taken", 2)],
        names=2,
    )  # fmt: skip


def contested_rate_table(found: ContestedFigures) -> Table:
    """Safe driving of each condition in all episodes, and in contested ones."""
    rates = {(row.condition, row.contested): row.rates for row in found.rates}
    return Table(
        "Safe driving, in all episodes and in contested ones",
        ["detector", "attack", *("success", "collision", "safe driving") * 2],
        [
            [
                *condition_names(condition),
                *_three_rates(rates[condition, False]),
                *_three_rates(rates[condition, True]),
            ]
            for condition in dict.fromkeys(row.condition for row in found.rates)
            if not condition.whole_levels
        ],
        f"In %, the intentions together; {found.episodes:,} episodes of {found.scenarios:,} scenes"
        " are contested. In brackets: 95 % intervals, the episodes of a scene being one cluster.",
        [("", 2), ("all", 3), ("contested", 3)],
        names=2,
    )  # fmt: skip


def contested_family_table(every: FamilyFigures, contested: FamilyFigures) -> Table:
    """Correlation and exchange rate of each family in all scenes, and in contested ones."""
    of_contested = {(row.detector, row.family): row for row in contested.rows}
    lines = []
    for row in every.rows:
        other = of_contested.get((row.detector, row.family))
        lines.append(
            [
                name(detector_name(row.detector)),
                name(row.family),
                count_cell(row.correlation.attacks),
                estimate_cell(_rho(row), digits=2),
                estimate_cell(NOTHING if other is None else _rho(other), digits=2),
                estimate_cell(row.exchange_rate, digits=2),
                estimate_cell(NOTHING if other is None else other.exchange_rate, digits=2),
            ]
        )
    return Table(
        "Families of attacks, in all scenes and in contested ones",
        ["detector", "family", "attacks", *("all", "contested") * 2],
        lines,
        f"{_RATE} {_RESAMPLED}",
        [("", 3), ("ρ", 2), ("exchange rate", 2)],
        names=2,
    )


def _rho(row: FamilyRow) -> Estimate:
    return Estimate(row.correlation.rho, row.correlation.interval)


def _pairs(pairs: DiscordantPairs) -> list[TableCell]:
    return [count_cell(count) for count in (pairs.concordant, pairs.discordant, pairs.undecided)]


def _three_rates(rates: SafetyRates) -> list[TableCell]:
    found = rates.to_json()
    return [
        estimate_cell(Estimate.of_columns(rate, found), scale=100)
        for rate in (SUCCESS, COLLIDED, SAFE_DRIVING)
    ]


def _precision_of(row: LossRow | None) -> Estimate:
    return NOTHING if row is None else row.precision_lost


def _safety_of(row: LossRow | None) -> Estimate:
    return NOTHING if row is None else row.safety_lost
