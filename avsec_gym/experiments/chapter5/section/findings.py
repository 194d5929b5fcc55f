"""All that a run of chapter 5 shows, read from its rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.controls import control_rows, rounding_rows, trend_rows
from avsec_gym.experiments.chapter5.decoupling import decoupling
from avsec_gym.experiments.chapter5.flips import flips
from avsec_gym.experiments.chapter5.ghost_shares import ghost_rows
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.patch_effects import patch_effect_rows
from avsec_gym.experiments.chapter5.patch_spreads import spread_rows
from avsec_gym.experiments.chapter5.pyramid import pyramid_rows
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.chapter5.section.answer_in_words import answer
from avsec_gym.experiments.chapter5.section.pictures import maps_of, strips_of
from avsec_gym.experiments.chapter5.section.sections import (
    answer_of,
    scenes_section,
    sections_of,
    spread_section,
)
from avsec_gym.experiments.chapter5.seen import seen_rows
from avsec_gym.experiments.chapter5.settings import ATTACKS, DETECTORS, WITHOUT_PYRAMID
from avsec_gym.experiments.chapter5.tables import (
    input_rows,
    intention_rows,
    planner_rows,
    precision_rows,
    safety_rows,
)
from avsec_gym.experiments.chapter5.true_drives import GROUND_TRUTH
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, OnProgress, ReportRequest

Data = dict[str, Any]
QUESTION = "Does a detector’s loss of precision under attack say anything about driving safety?"


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The sections of chapter 5, as far as the run has results of its experiments.

    Raises:
        DataError: The labels of the run's scenes are not where they were.
    """
    settings = {setting for setting, _ in run.settings() if _of_chapter_5(setting)}
    outcomes = outcomes_of(run) if settings else None
    data: Data = {}
    if outcomes is not None:
        with request.progress("reading") as shown:
            data = _data(run, outcomes, shown)
    spread = spread_rows(run)
    strips, no_strips = strips_of(run, outcomes, request)
    maps, no_maps = maps_of(run, spread, request)
    answered = data.get("answer", {"kind": "nothing"})["kind"] != "nothing"
    return Findings(
        [
            *([scenes_section(strips)] if strips else []),
            *sections_of(data),
            *spread_section(spread, data.get("pyramid", ()), maps),
        ],
        {**data, "spread": spread},
        settings,
        {attack: attack_name(attack) for attack in ATTACKS},
        answer=answer_of(data) if "answer" in data else None,
        question=QUESTION if answered else "",
        extent=f"{data['scenarios']:,} scenarios" if data.get("scenarios") else "",
        remarks=_remarks(run, data) if data else (),
        problems=[*no_strips, *no_maps],
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
    known = attack.partition(" ")[0].startswith(ATTACKS)
    return known and detector in (*DETECTORS, WITHOUT_PYRAMID)


def _data(run: RunFolder, outcomes: Outcomes, on_progress: OnProgress) -> Data:
    conditions = outcomes.conditions if outcomes.scenarios else ()
    slow = len(conditions) + len(outcomes.scenarios)
    for number, condition in enumerate(conditions):
        # The slow part, done first so that it can be watched; the outcomes keep it.
        on_progress(number, slow)
        for intention in outcomes.looks(condition):
            outcomes.precision(condition, intention)
    found: Data = {
        "scenarios": len(outcomes.scenarios),
        "left_out": [
            {**vars(condition), "scenarios": count}
            for condition, count in outcomes.left_out.items()
        ],
        "planners": planner_rows(outcomes),
    }
    if not conditions:
        return found
    threshold = {**OPTIONS, **run.configuration.options}["score_threshold"]
    losses = decoupling(outcomes)
    return found | {
        "answer": answer(losses),
        "decoupling": losses,
        "precision": precision_rows(outcomes),
        "safety": safety_rows(outcomes),
        "inputs": input_rows(outcomes),
        "intentions": intention_rows(outcomes),
        "seen": seen_rows(outcomes, threshold),
        "ghosts": ghost_rows(
            outcomes,
            scenes_of(run.configuration),
            threshold,
            lambda done, _: on_progress(len(conditions) + done, slow),
        ),
        "pyramid": pyramid_rows(run, outcomes.labels),
        "patch_effects": patch_effect_rows(outcomes),
        "controls": control_rows(outcomes),
        "trends": trend_rows(outcomes),
        "rounding": rounding_rows(outcomes),
        "flips": flips(outcomes),
    }


def _remarks(run: RunFolder, data: Mapping[str, Any]) -> list[str]:
    """On how many scenarios the figures rest, and which attacks are left out."""
    told = []
    if data["scenarios"] and (run.missing() or run.failures()):
        told.append(
            f"All figures are of the {data['scenarios']:,} scenarios that every attack shown here"
            " was done for."
        )
    if not data["scenarios"]:
        told.append("There is no scenario yet that every attack was done for.")
    hardly_begun = [
        f"{attack_name(one['attack'], one['strength'], one['whole_levels'])} on"
        f" {detector_name(one['detector'])} ({one['scenarios']:,})"
        for one in data["left_out"]
    ]
    if hardly_begun:
        told.append(f"Left out, with too few scenarios: {', '.join(hardly_begun)}.")
    return told
