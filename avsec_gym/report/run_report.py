"""Everything that a run has to say, as JSON; pages and tables are made of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from datetime import datetime
from typing import Any

from avsec_gym.experiments.chapter3.defence.rates import defence_summary, is_of_defence
from avsec_gym.experiments.chapter3.identification.five_sensors import five_summary
from avsec_gym.experiments.chapter3.identification.summary import validation_summary
from avsec_gym.experiments.chapter3.localisation.rates import localisation_summary
from avsec_gym.experiments.chapter3.objects.baseline_rates import baseline_summary
from avsec_gym.experiments.chapter3.objects.believed_rates import believed_summary
from avsec_gym.experiments.chapter3.objects.impact_rates import impact_summary
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import sensitivity_summary
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
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.runs.run_folder import RunFolder

Report = dict[str, Any]
QUESTION = "Does a detector’s loss of precision under attack say anything about driving safety?"
_NOTHING = {"kind": "nothing"}


def outcomes_of(run: RunFolder) -> Outcomes:
    """A run of chapter 5, ready to be summed up.

    Raises:
        DataError: The labels of its scenes are not where they were.
    """
    return Outcomes(run, labels_of(run.configuration))


def holds_chapter_5(run: RunFolder) -> bool:
    """Whether a run has results of chapter 5's experiments."""
    return any(_of_chapter_5(name) for name, _ in run.settings())


def run_report(
    run: RunFolder,
    outcomes: Outcomes | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    looked_at: int = 0,
) -> Report:
    """All figures of a run, finished or not.

    Without anything of chapter 5 in it, only the run itself is described, with the rates of its
    drives.

    Args:
        run: The run.
        outcomes: Of it; read if None.
        on_progress: Told how many conditions and scenarios of how many are looked at.
        looked_at: See `validation_summary`.

    Raises:
        DataError: The labels of the run's scenes are not where they were.
    """
    report: Report = {"question": QUESTION, **_run(run)}
    if holds_chapter_5(run):
        outcomes = outcomes_of(run) if outcomes is None else outcomes
        report |= _chapter_5(run, outcomes, on_progress)
    if report.get("answer", _NOTHING)["kind"] == "nothing":
        report["question"] = next(iter(run.manifest["experiments"].values()))["question"]
    report["validation"] = validation_summary(run, run.configuration, looked_at)
    report["five_sensors"] = five_summary(run, run.configuration)
    report["baseline"] = baseline_summary(run, run.configuration)
    report["impact"] = impact_summary(run, run.configuration)
    report["believed"] = believed_summary(run, run.configuration)
    report["sensitivity"] = sensitivity_summary(run, run.configuration)
    report["localisation"] = localisation_summary(run, run.configuration)
    report["defence"] = defence_summary(run)
    report["spread"] = spread_rows(run)
    report["other"] = _other_rates(run)
    return report


def _chapter_5(
    run: RunFolder, outcomes: Outcomes, on_progress: Callable[[int, int], None]
) -> Report:
    conditions = outcomes.conditions if outcomes.scenarios else ()
    slow = len(conditions) + len(outcomes.scenarios)
    for number, condition in enumerate(conditions):
        # The slow part, done first so that it can be watched; the outcomes keep it.
        on_progress(number, slow)
        for intention in outcomes.looks(condition):
            outcomes.precision(condition, intention)
    found: Report = {
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


def _run(run: RunFolder) -> Report:
    """What was asked, what is done, what failed, how long it took."""
    cells, manifest = run.cells(), run.manifest
    failures = [cell for cell in cells if cell["status"] == "failed"]
    attacks: dict[str, list[float]] = {}
    for cell in cells:
        if cell["status"] == "done" and "attack" in cell["arguments"]:
            attacks.setdefault(cell["arguments"]["attack"], []).append(cell["seconds"])
    counts = Counter(str(cell["error"]) for cell in failures)
    examples = {str(cell["error"]): cell["arguments"] for cell in reversed(failures)}
    return {
        "manifest": {**manifest, "folder": run.path.resolve().name},
        "cells": {
            "done": len(cells) - len(failures),
            "failed": len(failures),
            "missing": run.missing(),
        },
        "failures": [
            {"error": error, "cells": count, "example": examples[error]}
            for error, count in counts.most_common()
        ],
        "timings": {
            "parts": run.timings(),
            "attacks": {
                name: {"cells": len(attacks[name]), "seconds": sum(attacks[name])}
                for name in sorted(attacks, key=lambda one: (_order(one), one))
            },
            "wall": sum(_seconds(sitting) or 0.0 for sitting in manifest["sittings"]),
        },
    }


def _other_rates(run: RunFolder) -> list[Report]:
    """Rates under settings that chapter 5 does not know, for experiments of others."""
    return [
        {
            "setting": name,
            "strength": strength,
            **SafetyRates.of(run.records(setting=name, strength=strength)).to_json(),
        }
        for name, strength in run.settings()
        if not (_of_chapter_5(name) or is_of_defence(name))
        and run.drives(setting=name, strength=strength)
    ]


def _of_chapter_5(setting: str) -> bool:
    detector = setting.partition(" ")[0]
    if is_of_defence(setting):
        return False
    return setting == GROUND_TRUTH or detector in (*DETECTORS, WITHOUT_PYRAMID)


def _order(attack: str) -> int:
    return ATTACKS.index(attack) if attack in ATTACKS else len(ATTACKS)


def _seconds(sitting: dict[str, Any]) -> float | None:
    """None while it goes on, or where it was killed."""
    if sitting["ended"] is None:
        return None
    begun, ended = (datetime.fromisoformat(sitting[name]) for name in ("started", "ended"))
    return (ended - begun).total_seconds()
