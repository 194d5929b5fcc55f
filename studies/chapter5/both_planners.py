"""Does the answer depend on the planner?  A* and GBFS on the same attacked detections.

    python -m studies.chapter5.both_planners RUN

The run's own planner is A*; GBFS plans anew on the detections that it has stored, for which no
network is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.families import FamilyFigures, family_figures
from avsec_gym.experiments.chapter5.losses import safety
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.many_comparisons import ALPHA, holm_adjusted
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.report.markdown_table import interval, markdown_table, number, share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.planned_anew import planned_anew
from studies.chapter5.replanned_results import replanned
from studies.chapter5.run_page import run_page

_WORDS = {Algorithm.ASTAR: "A*", Algorithm.GBFS: "GBFS"}


@dataclass(frozen=True)
class PlannerUnderAttack:
    """A planner on what a detector sees under an attack, the three intentions together.

    Args:
        condition: The detector under its attack.
        planner: The search.
        rates: The three rates; the intentions of a scene are a cluster.
        by_intention: Safe driving rate of each intention.
    """

    condition: Condition
    planner: str
    rates: SafetyRates
    by_intention: Mapping[str, float | None]


@dataclass(frozen=True)
class PlannerDifference:
    """GBFS against A* on the same detections, percentage points of safe driving.

    Args:
        condition: The detector under its attack.
        more_safe: How much more safely GBFS drives, paired over scenes.
        p_holm: Its p-value after Holm's correction for all conditions; None without scenarios.
        more_lost: How much more the attack takes with GBFS; unknown of no attack.
    """

    condition: Condition
    more_safe: Estimate
    p_holm: float | None
    more_lost: Estimate


@dataclass(frozen=True)
class BothPlanners:
    """The study.

    Args:
        scenarios: Number of scenarios.
        rows: A row for each condition and planner.
        differences: A row for each condition.
        families: The chapter's question within families of attacks, by planner.
    """

    scenarios: int
    rows: Sequence[PlannerUnderAttack]
    differences: Sequence[PlannerDifference]
    families: Mapping[str, FamilyFigures]


def both_planners(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    threshold: float,
    on_progress: Progress = no_progress,
) -> BothPlanners:
    """Plan with GBFS on the detections of a run, and set it beside A*.

    Args:
        outcomes: The outcomes of a run, whose planner is A*.
        scenes: The run's scenes.
        motion: The objects that its planner takes as moving.
        threshold: The least score of a box that is planned on.
        on_progress: Function that gets the number of scenarios that are done, and of all.
    """
    conditions = [each for each in outcomes.conditions if not each.whole_levels]

    def planned_on(boxes: Boxes3D, _: Scene, __: Intention) -> Boxes3D:
        return above(boxes, threshold)

    anew = planned_anew(
        outcomes,
        scenes,
        motion,
        conditions,
        {Algorithm.GBFS: planned_on},
        on_progress,
        MotionPrimitivePlanner(Algorithm.GBFS),
    )
    greedy = replanned(
        outcomes, {each: anew[each, Algorithm.GBFS] for each in conditions}, Algorithm.GBFS
    )
    by_planner = {Algorithm.ASTAR: outcomes, Algorithm.GBFS: greedy}
    return BothPlanners(
        len(outcomes.scenarios),
        [
            _row(found, condition, planner)
            for condition in conditions
            for planner, found in by_planner.items()
        ],
        _differences(outcomes, greedy, conditions),
        {str(planner): family_figures(found) for planner, found in by_planner.items()},
    )


def _row(outcomes: Outcomes, condition: Condition, planner: Algorithm) -> PlannerUnderAttack:
    records = outcomes.records(condition)
    by_intention = {str(way): outcomes.rates(condition, way).safe_driving_rate for way in Intention}
    return PlannerUnderAttack(condition, str(planner), SafetyRates.of(records), by_intention)


def _differences(
    first: Outcomes, second: Outcomes, conditions: Sequence[Condition]
) -> list[PlannerDifference]:
    """The second planner's safety less the first's; both from the same draws of scenarios."""
    more = {each: safety(second, each) - safety(first, each) for each in conditions}
    corrected = holm_adjusted([more[each].p for each in conditions])
    return [
        PlannerDifference(
            each,
            more[each].estimate,
            None if np.isnan(p) else float(p),
            NOTHING
            if each.attack == UNATTACKED or each.unattacked not in more
            else (more[each.unattacked] - more[each]).estimate,
        )
        for each, p in zip(conditions, corrected, strict=True)
    ]


def page(found: BothPlanners, command: str) -> str:
    """All as Markdown.

    Args:
        found: The result.
        command: The command that made it.
    """
    return "\n".join(
        [
            "# Both planners under attack",
            "",
            f"{found.scenarios:,} scenarios, planned anew with GBFS on the detections of"
            f" [chapter5.md](chapter5.md)'s run by `{command}`; A* is the run's own planner.",
            "",
            "## Rates",
            "",
            *_rates_table(found.rows),
            "",
            "In %, the three intentions together; behind it safe driving by intention. In brackets:"
            " 95 % intervals, the intentions of a scene being one cluster.",
            "",
            "## GBFS against A*",
            "",
            *_differences_table(found.differences),
            "",
            "In percentage points, in brackets 95 % bootstrap intervals over the same scenarios. p:"
            " by Holm’s method for the number of rows. More taken: what the attack takes of safe"
            " driving with GBFS, less what it takes with A*.",
            "",
            _sentence(found.differences),
            "",
            "## The chapter's question with each planner",
            "",
            *_families_table(found.families),
            "",
            "ρ: Spearman’s rank correlation of what attacks take of average precision with what"
            " they take of safe driving. Exchange rate: points of safe driving lost for each point"
            " of average precision. Pairs are sure after Holm’s correction for all of a detector.",
            "",
        ]
    )


def _rates_table(rows: Sequence[PlannerUnderAttack]) -> list[str]:
    """Success, collisions and safe driving of each condition and planner."""
    return markdown_table(
        [
            "detector",
            "attack",
            "planner",
            "success",
            "collisions",
            "safe driving",
            *map(str, Intention),
        ],
        [
            [
                *_names(row.condition),
                _WORDS[Algorithm(row.planner)],
                share(row.rates.success_rate),
                share(row.rates.collision_rate),
                _safe(row.rates),
                *(share(row.by_intention[way]) for way in Intention),
            ]
            for row in rows
        ],
    )


def _differences_table(differences: Sequence[PlannerDifference]) -> list[str]:
    """GBFS against A* under each condition."""
    return markdown_table(
        [
            "detector",
            "attack",
            "safe driving, GBFS less A*",
            "p, corrected",
            "more taken with GBFS",
        ],
        [
            [
                *_names(row.condition),
                interval(row.more_safe.value, row.more_safe.interval),
                number(row.p_holm, 3),
                interval(row.more_lost.value, row.more_lost.interval),
            ]
            for row in differences
        ],
    )


def _families_table(families_of: Mapping[str, FamilyFigures]) -> list[str]:
    """What each planner answers to the chapter's question."""
    return markdown_table(
        [
            "planner",
            "detector",
            "family",
            "attacks",
            "ρ",
            "exchange rate",
            "pairs with it",
            "against it",
            "undecided",
        ],
        [
            [
                _WORDS[Algorithm(planner)],
                detector_name(row.detector),
                row.family,
                str(row.correlation.attacks),
                interval(row.correlation.rho, row.correlation.interval, 2),
                interval(row.exchange_rate.value, row.exchange_rate.interval, 2),
                *map(str, (row.pairs.concordant, row.pairs.discordant, row.pairs.undecided)),
            ]
            for planner, families in families_of.items()
            for row in families.rows
        ],
    )


def _sentence(rows: Sequence[PlannerDifference]) -> str:
    """How many conditions surely differ."""
    sure = [row for row in rows if row.p_holm is not None and row.p_holm <= ALPHA]
    if not sure:
        return f"In none of the {len(rows)} conditions do the planners surely differ."
    safer = sum((row.more_safe.value or 0.0) > 0 for row in sure)
    return (
        f"In {len(sure)} of the {len(rows)} conditions the planners surely differ: GBFS drives more"
        f" safely in {safer}, A* in {len(sure) - safer}."
    )


def _names(condition: Condition) -> list[str]:
    return [detector_name(condition.detector), attack_name(condition.attack, condition.strength)]


def _safe(rates: SafetyRates) -> str:
    found = Estimate.of_columns("safe_driving_rate", rates.to_json())
    bounds = None if found.interval is None else [100 * bound for bound in found.interval]
    return interval(None if found.value is None else 100 * found.value, bounds)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print rows as JSON; returns the exit code."""
    return run_page(__spec__.name, __doc__, arguments, _measured, page)


def _measured(run: RunFolder) -> BothPlanners:
    given = {**OPTIONS, **run.configuration.options}
    outcomes = Outcomes(run, labels_of(run.configuration))
    with progress("driving with GBFS") as shown:
        return both_planners(
            outcomes,
            scenes_of(run.configuration),
            Motion.named(given["motion"]),
            given["score_threshold"],
            shown,
        )


if __name__ == "__main__":
    sys.exit(main())
