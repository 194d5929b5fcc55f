"""The answer follows the figures, in every direction."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.experiments.chapter5.decoupling import (
    AttackRow,
    Decoupling,
    RankCorrelation,
    UnattackedRow,
)
from avsec_gym.experiments.chapter5.families import (
    ALL_FAMILIES,
    ComparedFamilies,
    FamilyFigures,
    FamilyRow,
)
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.pairs_of_attacks import DiscordantPairs
from avsec_gym.experiments.chapter5.section.answer_in_words import answer
from avsec_gym.metrics.estimate import NOTHING, Estimate


def losses(
    rho: float | None,
    interval: Any,
    discordant: int,
    *,
    safety_lost: Estimate = Estimate(0.5, [-1, 2]),
    attacks: int = 12,
    scenarios: int = 600,
) -> Decoupling:
    attack = AttackRow(
        Condition("dsgn", "thesis_pgd-1", 4.0), Estimate(40.0, [30, 45]), safety_lost, True, None
    )
    correlation = RankCorrelation(attacks, rho, interval)
    return Decoupling(
        scenarios,
        [UnattackedRow("dsgn", Estimate(45.0), Estimate(90.0))],
        [attack],
        {"dsgn": correlation, "both": correlation},
        {"dsgn": DiscordantPairs(66, 3, discordant, 63 - discordant)},
    )


@pytest.mark.parametrize(
    ("rho", "interval", "discordant", "kind", "word"),
    [
        (0.9, [0.6, 1.0], 0, "coupled", "Yes."),
        (0.6, [0.2, 0.8], 5, "partly", "Only in part."),
        (0.1, [-0.1, 0.2], 0, "decoupled", "No."),
        (0.1, [-0.1, 0.2], 5, "decoupled", "No."),
        (0.1, [-0.3, 0.3], 0, "decoupled", "No."),
        (-0.6, [-0.8, -0.2], 5, "reversed", "No, rather the reverse."),
        (0.3, [-0.4, 0.8], 0, "cannot tell", "This run cannot tell."),
        (None, None, 0, "alike", "This run cannot tell."),
    ],
)
def test_the_answer_follows_the_figures(
    rho: float | None, interval: Any, discordant: int, kind: str, word: str
) -> None:
    found = answer(losses(rho, interval, discordant))
    assert (found.kind, found.word) == (kind, word)


@pytest.mark.parametrize("discordant", [0, 1, 5, 63])
@pytest.mark.parametrize("interval", [[-0.4, 0.2], [-0.1, 0.31], [-0.45, 0.5], [-1.0, 1.0]])
def test_decoupled_asks_for_a_narrow_interval_whatever_single_pairs_do(
    interval: list[float], discordant: int
) -> None:
    assert answer(losses(0.1, interval, discordant)).kind == "cannot tell"


def test_pairs_are_counted_after_correction() -> None:
    (one,) = answer(losses(0.1, [-0.4, 0.5], 5)).detectors
    assert one.evidence.endswith(
        "of 66 pairs 3 surely go with it, 5 surely against it, 58 are undecided"
    )


def test_two_attacks_have_no_ranks_to_compare() -> None:
    assert answer(losses(None, None, 0, attacks=2)).word == "There is nothing to compare yet."


def test_what_cannot_be_told_from_nothing_is_not_called_a_loss() -> None:
    (one,) = answer(losses(0.9, [0.6, 1], 0)).detectors
    assert one.took == [
        "thesis PGD α 1, n 4 took 40.0 of 45.0 points of average precision and did not measurably"
        " change 90.0 points of safe driving (−0.5 [−2.0, +1.0])."
    ]
    gained = losses(0.9, [0.6, 1], 0, safety_lost=Estimate(-3.0, [-5, -1]))
    assert "added 3.0 to 90.0 points" in answer(gained).detectors[0].took[0]


def test_a_dozen_scenes_give_no_answer() -> None:
    found = answer(losses(0.9, [0.9, 0.9], 0, scenarios=12))
    assert (found.kind, found.word) == ("few", "This run cannot tell.")
    assert found.sentence.startswith("12 scenarios are too few")


def test_detectors_may_differ() -> None:
    one = losses(0.9, [0.6, 1], 0)
    both = Decoupling(
        600,
        [*one.unattacked, UnattackedRow("stereo_rcnn", Estimate(40.0), Estimate(90.0))],
        one.attacks,
        {**one.rank_correlation, "stereo_rcnn": RankCorrelation(12, -0.5, [-0.8, -0.1])},
        dict.fromkeys(("dsgn", "stereo_rcnn"), DiscordantPairs(66, 3, 0, 63)),
    )
    found = answer(both)
    assert found.kind == "depends"
    assert found.sentence.startswith("For DSGN, attacks that take more precision take more")
    assert "for Stereo R-CNN, attacks that take more precision take less" in found.sentence


def families(
    perturbations: tuple[float, float, float],
    patches: tuple[float, float, float] | None = None,
    *,
    rates: tuple[float | None, float | None] = (0.1, 0.25),
    p: float | None = 0.01,
) -> FamilyFigures:
    """Rank correlation with its interval of two families, and their exchange rates."""

    def row(name: str, found: tuple[float, float, float] | None, rate: float | None) -> FamilyRow:
        correlation = RankCorrelation(2, None, None)
        if found is not None:
            correlation = RankCorrelation(8, found[0], found[1:])
        exchanged = NOTHING if rate is None else Estimate(rate, (rate - 0.05, rate + 0.05))
        nothing = DiscordantPairs(28, 20, 0, 8)
        return FamilyRow("dsgn", name, correlation, NOTHING, NOTHING, exchanged, nothing)

    rows = [
        row(ALL_FAMILIES, (0.1, -0.4, 0.5), None),
        row("perturbations", perturbations, rates[0]),
        row("patches", patches, rates[1]),
    ]
    known = None not in rates
    compared = ComparedFamilies(
        "dsgn",
        "patches",
        "perturbations",
        Estimate(2.5, (1.5, 4.0)) if known else NOTHING,
        Estimate(0.15, (0.05, 0.25)) if known else NOTHING,
        p,
        DiscordantPairs(8, 0, 0, 8),
    )
    return FamilyFigures(rows, [compared])


COUPLED, WIDE, NONE = (0.93, 0.7, 1.0), (0.1, -0.4, 0.5), (0.0, -0.2, 0.2)


@pytest.mark.parametrize("pooled", [[-0.4, 0.5], [-0.2, 0.2], [-0.8, -0.1]])
def test_families_that_go_together_are_named_where_all_attacks_do_not(pooled: list[float]) -> None:
    found = answer(losses(0.0, pooled, 0), families(COUPLED, WIDE))
    assert (found.kind, found.word) == ("within", "Within a family of attacks.")
    assert found.sentence.startswith(
        "Within perturbations, attacks that take more precision take more safety; over families"
        " together, "
    )


def test_what_goes_together_on_the_whole_may_not_within_a_family() -> None:
    found = answer(losses(0.9, [0.6, 1.0], 0), families(NONE, WIDE))
    assert found.kind == "across"
    assert found.sentence.endswith("take more safety, but not within perturbations.")


@pytest.mark.parametrize(
    ("interval", "within", "kind"),
    [([0.6, 1.0], COUPLED, "coupled"), ([-0.2, 0.2], NONE, "decoupled"),
     ([-0.4, 0.5], WIDE, "cannot tell"), ([-0.4, 0.5], NONE, "cannot tell")],
)  # fmt: skip
def test_families_that_do_not_contradict_leave_the_answer(
    interval: list[float], within: tuple[float, float, float], kind: str
) -> None:
    with_families = answer(losses(0.1, interval, 0), families(within))
    alone = answer(losses(0.1, interval, 0))
    assert with_families.kind == alone.kind == kind
    assert with_families.sentence == alone.sentence


def test_sentences_of_families_state_their_figures_and_no_more() -> None:
    (one,) = answer(losses(0.1, [-0.4, 0.5], 0), families(COUPLED)).detectors
    assert one.families == [
        "Within perturbations: attacks that take more precision take more safety (ρ = 0.93"
        " [0.70, 1.00] over 8 attacks; of 28 pairs 20 surely go with it, 0 surely against it, 8 are"
        " undecided).",
        "Within patches: 2 of 3 attacks, no answer.",
        "A point of average precision costs, in points of safe driving: 0.10 [0.05, 0.15] where"
        " perturbations take it; 0.25 [0.20, 0.30] where patches take it.",
        "Patches cost 2.50 [1.50, 4.00] times as much as perturbations.",
    ]
    unsure = answer(losses(0.1, [-0.4, 0.5], 0), families(COUPLED, p=0.2)).detectors[0]
    assert unsure.families[-1] == "That patches and perturbations differ in this is not sure."
    unknown = families(COUPLED, rates=(0.1, None), p=None)
    (other,) = answer(losses(0.1, [-0.4, 0.5], 0), unknown).detectors
    assert other.families[-1].endswith("0.10 [0.05, 0.15] where perturbations take it.")


def test_few_scenarios_give_no_answer_within_families_either() -> None:
    found = answer(losses(0.1, [-0.4, 0.5], 0, scenarios=12), families(COUPLED))
    assert found.kind == "few"
