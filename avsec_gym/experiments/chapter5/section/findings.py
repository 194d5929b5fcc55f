"""The findings of a run of chapter 5, read from its rows."""

from __future__ import annotations

from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.figures import ChapterFigures, chapter_figures
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.patch_spreads import spread_rows
from avsec_gym.experiments.chapter5.scenes import labels_of
from avsec_gym.experiments.chapter5.section.answer_in_words import answer
from avsec_gym.experiments.chapter5.section.pictures import maps_of, strips_of
from avsec_gym.experiments.chapter5.section.sections import (
    answer_of,
    scenes_section,
    sections_of,
    spread_section,
    style_and_script,
)
from avsec_gym.experiments.chapter5.settings import ATTACKS, DETECTORS, WITHOUT_PYRAMID
from avsec_gym.experiments.chapter5.stronger_attacks import STRONGER_NAMES
from avsec_gym.experiments.chapter5.true_episodes import GROUND_TRUTH
from avsec_gym.experiments.json_rows import as_json, row_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest

QUESTION = "Does a detector’s loss of precision under attack say anything about driving safety?"


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The sections of chapter 5, as far as the run has results of its experiments.

    Raises:
        DataError: The labels of the run's scenes are not where they were.
    """
    settings = {setting for setting, _ in run.settings() if _of_chapter_5(setting)}
    outcomes = outcomes_of(run) if settings else None
    figures = None
    if outcomes is not None:
        with request.progress("reading") as shown:
            figures = chapter_figures(run, outcomes, shown)
    attacks = figures.of_attacks if figures else None
    worded = answer(attacks.decoupling, attacks.families) if attacks else None
    spread = spread_rows(run)
    strips, no_strips = strips_of(run, outcomes, request)
    maps, no_maps = maps_of(run, spread, request)
    sections = [
        *([scenes_section(strips)] if strips else []),
        *(sections_of(figures) if figures else []),
        *spread_section(spread, attacks.pyramid if attacks else (), maps),
    ]
    style, script = style_and_script() if sections else ("", "")
    return Findings(
        sections,
        {
            **(row_json(figures) if figures else {}),
            **({"answer": as_json(worded)} if worded else {}),
            "spread": as_json(spread),
        },
        settings,
        {attack: attack_name(attack) for attack in ATTACKS + STRONGER_NAMES},
        answer=answer_of(worded, attacks.decoupling) if worded and attacks else None,
        question=QUESTION if worded and worded.kind != "nothing" else "",
        extent=f"{figures.scenarios:,} scenarios" if figures and figures.scenarios else "",
        remarks=_remarks(run, figures) if figures else (),
        problems=[*no_strips, *no_maps],
        style=style,
        script=script,
    )


def outcomes_of(run: RunFolder) -> Outcomes:
    """A run of chapter 5, ready to be summed up.

    Raises:
        DataError: The labels of its scenes are not where they were.
    """
    return Outcomes(run, labels_of(run.configuration))


def _of_chapter_5(setting: str) -> bool:
    """Whether it is a detector of the chapter under an attack, or the ground truth."""
    detector, _, attack = setting.partition(" ")
    if setting == GROUND_TRUTH:
        return True
    known = attack.partition(" ")[0].startswith(ATTACKS + STRONGER_NAMES)
    return known and detector in (*DETECTORS, WITHOUT_PYRAMID)


def _remarks(run: RunFolder, figures: ChapterFigures) -> list[str]:
    """On how many scenarios the figures rest, and which attacks are left out."""
    remarks = []
    if figures.scenarios and (run.missing() or run.failures()):
        remarks.append(
            f"All figures are of the {figures.scenarios:,} scenarios that every attack shown here"
            " was done for."
        )
    if not figures.scenarios:
        remarks.append("There is no scenario yet that every attack was done for.")
    hardly_begun = [
        f"{attack_name(row.condition.attack, row.condition.strength, row.condition.whole_levels)}"
        f" on {detector_name(row.condition.detector)} ({row.scenarios:,})"
        for row in figures.left_out
    ]
    if hardly_begun:
        remarks.append(f"Left out, with too few scenarios: {', '.join(hardly_begun)}.")
    return remarks
