"""Why safety is lost or kept: its headroom, and the errors that cost it.

    python -m studies.chapter5.costly_errors RUN

Plans anew on what a run has stored; no network is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

from avsec_gym.console import progress
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.estimate import Estimate, Interval
from avsec_gym.metrics.ghosts import SAME
from avsec_gym.metrics.many_comparisons import ALPHA
from avsec_gym.report.markdown_table import interval, markdown_table, share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from studies.chapter5.case_measures import IN_REACH
from studies.chapter5.corrected_episodes import (
    AS_FOUND,
    GHOSTS_IN,
    CorrectedRow,
    corrected_rows,
)
from studies.chapter5.headroom import (
    NOTHING,
    RANDOM,
    SPECIFIC,
    TRUTH,
    HeadroomRow,
    headroom_rows,
)
from studies.chapter5.run_page import run_page
from studies.chapter5.telling_measures import BOTH, PRECISION

_SEEN = {
    TRUTH: "the truth",
    NOTHING: "nothing",
    RANDOM: "the truth and a random patch’s ghost",
    SPECIFIC: "the truth and a specific patch’s ghost",
}


@dataclass(frozen=True)
class EarlierMeasureRow:
    """How far the loss of a measure goes with the loss of safety, see `MeasureRow`."""

    measure: str
    detector: str
    attacks: int
    rho: float | None
    interval: Interval | None
    more: Estimate


@dataclass(frozen=True)
class CostlyErrors:
    """The study.

    Args:
        scenarios: Number of scenarios.
        headroom: Rows of cars without a detector.
        errors: Rows of corrected detections.
        measures: The measures of earlier runs, which `telling_page` shows of later ones; None: the
            run is a later one.
    """

    scenarios: int
    headroom: Sequence[HeadroomRow]
    errors: Sequence[CorrectedRow]
    measures: Sequence[EarlierMeasureRow] | None = field(default=None, metadata=OPTIONAL)


def page(found: CostlyErrors, command: str) -> str:
    """All as Markdown.

    Args:
        found: The result.
        command: The command that made it.
    """
    return "\n".join(
        [
            "# Which errors cost safety?",
            "",
            f"{found.scenarios:,} scenarios, the three intentions together, planned anew on the"
            f" detections of [chapter5.md](chapter5.md)'s run by `{command}`. Safe driving in %;"
            " behind it what is gained, in percentage points, with its 95 % bootstrap interval over"
            " scenarios.",
            *_headroom(found.headroom),
            *_corrected(found.errors),
            *(_measures(found.measures) if found.measures else []),
            "",
        ]
    )


def _headroom(rows: Sequence[HeadroomRow]) -> list[str]:
    """Safe driving between what nothing and what the truth lets be planned."""
    titles = ["what the planner is given", "safe driving", "against the truth", "collisions"]
    cells = [
        [
            _SEEN[row.seen],
            share(row.rates.safe_driving_rate),
            _signed(row.gain) if row.seen != TRUTH else "",
            share(row.rates.collision_rate),
            *(share(row.by_intention[intention]) for intention in Intention),
        ]
        for row in rows
    ]
    return [
        "",
        "## Headroom",
        "",
        *markdown_table([*titles, *map(str, Intention)], cells),
        "",
        "Behind the collisions, safe driving by intention. The ghost is the box that patches are"
        " trained for, where those of the run stood: a patch that always works, and spoils nothing"
        " else.",
    ]


def _corrected(rows: Sequence[CorrectedRow]) -> list[str]:
    """What correcting one kind of error gains, a line for each detector and attack."""
    cells: dict[Condition, list[str]] = {}
    for row in rows:
        rate = share(row.rates.safe_driving_rate)
        sure = "\\*" if row.p_holm is not None and row.p_holm <= ALPHA else ""
        text = rate if row.corrected == AS_FOUND else f"{rate}, {_signed(row.gain)}{sure}"
        cells.setdefault(row.condition, []).append(text)
    lines = [
        [detector_name(each.detector), attack_name(each.attack, each.strength), *own]
        for each, own in cells.items()
    ]
    kinds = dict.fromkeys(row.corrected for row in rows)
    kinds.pop(AS_FOUND, None)
    titles = ["detector", "attack", AS_FOUND, *(f"{name} corrected" for name in kinds)]
    lanes = [
        "",
        "Ghosts of one lane alone are dropped in their columns: of the car’s own lane, of the lane"
        " that it changes to, and all others; one that reaches into several counts in the first of"
        " these.",
    ]
    marks = [
        "",
        "\\*: surely, by an exact test of the scenarios that gain against those that lose, after"
        f" Holm’s correction for all {sum(row.p_holm is not None for row in rows)} gains.",
    ]
    return [
        "",
        "## Errors corrected",
        "",
        *markdown_table(titles, lines),
        "",
        "Ghosts: boxes that stand for nothing real are dropped. Misses: real objects that no box"
        f" means, with an overlap of {SAME:g} from above, are added, those too that the detector"
        " does not look for. Places: boxes that mean a real object are moved to where it is.",
        *(lanes if {*kinds} & {*GHOSTS_IN.values()} else []),
        *(marks if any(row.p_holm is not None for row in rows) else []),
    ]


def _measures(rows: Sequence[EarlierMeasureRow]) -> list[str]:
    """How far measures of perception go with safe driving."""
    titles = ["measure", "detector", "attacks", "ρ with safe driving", f"more than of {PRECISION}"]
    cells = [
        [
            row.measure,
            BOTH if row.detector == BOTH else detector_name(row.detector),
            str(row.attacks),
            interval(row.rho, row.interval, 2),
            "" if row.measure == PRECISION else _signed(row.more, 2),
        ]
        for row in rows
    ]
    return [
        "",
        "## Which measure of perception predicts safety?",
        "",
        *markdown_table(titles, cells),
        "",
        "Spearman’s rank correlation, over perturbations and patches, of what an attack takes of"
        " the measure and of safe driving, with 95 % bootstrap intervals over scenarios. Cars"
        f" found: a box overlaps them by more than {SAME:g} from above; in reach: up to"
        f" {IN_REACH:g} m away.",
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print rows as JSON; returns the exit code."""
    return run_page(__spec__.name, __doc__, arguments, _measured, page)


def _measured(run: RunFolder) -> CostlyErrors:
    configuration = run.configuration
    given = {**OPTIONS, **configuration.options}
    motion, scenes = Motion.named(given["motion"]), scenes_of(configuration)
    outcomes = Outcomes(run, labels_of(configuration))
    with progress("driving without a detector") as shown:
        headroom = headroom_rows(scenes, outcomes.scenarios, motion, configuration.seed, shown)
    with progress("driving on corrected detections") as shown:
        errors = corrected_rows(outcomes, scenes, motion, given["score_threshold"], shown)
    return CostlyErrors(len(outcomes.scenarios), headroom, errors)


def _signed(difference: Estimate, digits: int = 1) -> str:
    text = interval(difference.value, difference.interval, digits)
    return f"+{text}" if difference.value is not None and difference.value >= 0 else text


if __name__ == "__main__":
    sys.exit(main())
