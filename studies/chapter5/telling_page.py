"""Which measure of perception tells of driving safety: over attacks, and in single episodes?

    python -m studies.chapter5.telling_page RUN --markdown FILE --figure FILE

Plans anew on what a run has stored; no network is needed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from avsec_gym.console import progress
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.contact_recall import HORIZON, MARGIN
from avsec_gym.metrics.ghosts import SAME
from avsec_gym.report.markdown_table import interval, markdown_table, number
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.scene import Motion
from avsec_gym.storage.text_files import write_text
from studies.answer import answer
from studies.chapter5.best_measure import BestMeasure, best_measure, sentences
from studies.chapter5.case_measures import IN_REACH, case_measures
from studies.chapter5.measures.planning_kl import CELL, TEMPERATURE
from studies.chapter5.measures.support_distance import MISSED
from studies.chapter5.telling_figure import draw_telling
from studies.chapter5.telling_flips import FlipRow, flip_rows
from studies.chapter5.telling_measures import (
    BOTH,
    PRECISION,
    MeasureRow,
    compared_attacks,
    telling_rows,
)


@dataclass(frozen=True)
class TellingMeasures:
    """The study.

    Args:
        scenarios: Number of scenarios.
        measures: Rows over attacks.
        flips: Rows of single episodes.
        best: The measures that work best by rule; None: an earlier result.
    """

    scenarios: int
    measures: Sequence[MeasureRow]
    flips: Sequence[FlipRow]
    best: BestMeasure | None = field(default=None, metadata=OPTIONAL)

    @classmethod
    def of(cls, scenarios: int, measures: list[MeasureRow], flips: list[FlipRow]) -> Self:
        """The study's result with the measures that these rows show to work best.

        Args:
            scenarios: Number of scenarios.
            measures: Rows of `telling_rows`.
            flips: Rows of `flip_rows`.
        """
        return cls(scenarios, measures, flips, best_measure(measures, flips))


def page(found: TellingMeasures, command: str) -> str:
    """All as Markdown.

    Args:
        found: The result.
        command: The command that made it.
    """
    p_values = [row.p_holm for rows in (found.measures, found.flips) for row in rows]
    is_corrected = any(p is not None for p in p_values)
    of_p = ["p, corrected"] if is_corrected else []
    correction = (
        ". p: of a difference of zero, after Holm’s correction for all rows of the table."
        if is_corrected
        else "; not corrected for the number of rows."
    )
    return "\n".join(
        [
            "# Which measure of perception tells of safety?",
            "",
            f"{found.scenarios:,} scenarios, three intentions each; measured on what a run of"
            f" chapter 5 has stored, by `{command}`. In brackets: 95 % intervals by bootstrap over"
            f" scenarios, each with all its attacks and intentions{correction}",
            "",
            *(_answer(found.best, found.scenarios) if found.best is not None else []),
            "## Over attacks",
            "",
            *markdown_table(
                ["measure", "detector", "attacks", "number", "ρ with safe driving",
                 f"more than of {PRECISION}", *of_p],
                [
                    _line(row, str(row.attacks), interval(row.rho, row.interval, 2), is_corrected)
                    for row in found.measures
                ],
            ),
            "",
            "Spearman’s rank correlation of what an attack takes of the measure with what it takes"
            " of safe driving; of fewer than three attacks there is none.",
            "",
            "## In single drives",
            "",
            *markdown_table(
                ["measure", "detector", "attacks", "became unsafe, of", "area under the ROC curve",
                 f"more than of {PRECISION}", *of_p],
                [
                    _line(
                        row,
                        f"{row.became_unsafe} in {row.scenes} scenes, {row.episodes:,}",
                        interval(row.area, row.interval, 2),
                        is_corrected,
                    )
                    for row in found.flips
                ],
            ),
            "",
            "Of the drives that are safe unattacked: the probability that the measure loses more in"
            " one that the attack makes unsafe than in one that stays safe under the same attack;"
            " 0.5 tells nothing. Average precision is then the area under the curve of the scene"
            " alone, with every car as a recall of its own.",
            "",
            "## The measures",
            "",
            f"- *Cars found*: a box overlaps them by more than {SAME:g} from above; in reach: up to"
            f" {IN_REACH:g} m away.",
            f"- *Found by time to contact*: an object weighs 1 / (1 + t) by the seconds until the"
            f" car, going straight to its goal, is within {MARGIN:g} m of it, up to {HORIZON:g} s"
            " (after Ceccarelli and Montecchi 2023); less ghosts: over real and invented objects.",
            f"- *Support distance*: 1 less the error of the gaps to each object, in units of"
            f" {MISSED:g} m, along the plan that the truth gives (after Deng et al. 2021).",
            "- *Contested objects found*: those of which missing one alone makes the drive unsafe.",
            f"- *Planning KL*: how far the belief moves the car from what it would do by the truth,"
            f" with cells of {CELL:g} m and a temperature of {TEMPERATURE:g} s (after Philion et"
            " al. 2020).",
            "",
            "Each module of `avsec_gym/metrics` states how it departs from its source. The last two"
            " ask the planner that is then judged: that they tell of its safety is no surprise, and"
            " holds for no other planner.",
            "",
        ]
    )  # fmt: skip


def _answer(best: BestMeasure, scenarios: int) -> list[str]:
    """The measure that works best, by rule."""
    return [
        "## The measure that works best",
        "",
        *(f"- {sentence}" for sentence in sentences(best, scenarios)),
        "",
        "Over attacks: the highest rank correlation over all attacks on both detectors. In single"
        " drives: the largest area over all attacks. Not surely worse are those whose intervals"
        " hold that value.",
        "",
    ]


def _line(row: MeasureRow | FlipRow, count: str, value: str, is_corrected: bool) -> list[str]:
    more = interval(row.more.value, row.more.interval, 2)
    signed = f"+{more}" if row.more.value is not None and row.more.value >= 0 else more
    return [
        row.measure,
        BOTH if row.detector == BOTH else detector_name(row.detector),
        row.family,
        count,
        value,
        "" if row.measure == PRECISION else signed,
        *([number(row.p_holm, 3)] if is_corrected and row.measure != PRECISION else []),
        *([""] if is_corrected and row.measure == PRECISION else []),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print rows as JSON, write page and picture; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("run", type=Path, help="folder that `avsec run` wrote")
    parser.add_argument("--markdown", type=Path, help="also write tables into this file")
    parser.add_argument("--figure", type=Path, help="also draw this picture")
    parser.add_argument("--json", type=Path, help="write here instead of standard output")

    def made(options: argparse.Namespace) -> TellingMeasures:
        result = _measured(RunFolder.open(options.run))
        if options.markdown is not None:
            command = f"python -m {__spec__.name} RUN --markdown FILE --figure FILE"
            write_text(options.markdown, page(result, command), overwrite=True)
        if options.figure is not None:
            draw_telling(result.measures, result.flips, options.figure)
        return result

    return answer(parser.parse_args(arguments), made)


def _measured(run: RunFolder) -> TellingMeasures:
    configuration = run.configuration
    given = {**OPTIONS, **configuration.options}
    outcomes = Outcomes(run, labels_of(configuration))
    attacks = compared_attacks(outcomes)
    conditions = list(dict.fromkeys([*(attack.unattacked for attack in attacks), *attacks]))
    with progress("measuring what is seen") as shown:
        cases = case_measures(
            outcomes,
            scenes_of(configuration).scenes.labelled,
            Motion.named(given["motion"]),
            conditions,
            given["score_threshold"],
            shown,
        )
    return TellingMeasures.of(
        len(outcomes.scenarios), telling_rows(outcomes, cases), flip_rows(outcomes, cases)
    )


if __name__ == "__main__":
    sys.exit(main())
