"""Why safety is lost or kept: its headroom, and the errors that cost it.

    python -m studies.chapter5.costly_errors RUN

Plans anew on what a run has stored; no network is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.console import progress
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.report.markdown_table import interval, markdown_table, share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from studies.chapter5.case_measures import IN_REACH
from studies.chapter5.corrected_episodes import AS_FOUND, CORRECTED, SAME, corrected_rows
from studies.chapter5.headroom import NOTHING, RANDOM, SPECIFIC, TRUTH, headroom_rows
from studies.chapter5.run_page import run_page
from studies.chapter5.telling_measures import BOTH, PRECISION

Row = Mapping[str, Any]
"""A row of the result, as JSON has it."""
_SEEN = {
    TRUTH: "the truth",
    NOTHING: "nothing",
    RANDOM: "the truth and a random patch’s ghost",
    SPECIFIC: "the truth and a specific patch’s ghost",
}


def page(found: Mapping[str, Any], command: str) -> str:
    """All as Markdown.

    Args:
        found: ``scenarios``, how many; rows of ``headroom`` and ``errors``; of earlier runs those
            of ``measures``, which `telling_page` shows of later ones.
        command: The command that made it.
    """
    return "\n".join(
        [
            "# Which errors cost safety?",
            "",
            f"{found['scenarios']:,} scenarios, the three intentions together, planned anew on the"
            f" detections of [chapter5.md](chapter5.md)'s run by `{command}`. Safe driving in %;"
            " behind it what is gained, in percentage points, with its 95 % bootstrap interval over"
            " scenarios.",
            *_headroom(found["headroom"]),
            *_corrected(found["errors"]),
            *(_measures(found["measures"]) if "measures" in found else []),
            "",
        ]
    )


def _headroom(rows: Sequence[Row]) -> list[str]:
    """Safe driving between what nothing and what the truth lets be planned."""
    titles = ["what the planner is given", "safe driving", "against the truth", "collisions"]
    cells = [
        [
            _SEEN[row["seen"]],
            share(row["safe_driving_rate"]),
            _signed(row) if row["seen"] != TRUTH else "",
            share(row["collision_rate"]),
            *(share(row["by_intention"][intention]) for intention in Intention),
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


def _corrected(rows: Sequence[Row]) -> list[str]:
    """What correcting one kind of error gains, a line for each detector and attack."""
    cells: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        names = (detector_name(row["detector"]), attack_name(row["attack"], row["strength"]))
        rate = share(row["safe_driving_rate"])
        text = rate if row["corrected"] == AS_FOUND else f"{rate}, {_signed(row)}"
        cells.setdefault(names, []).append(text)
    titles = ["detector", "attack", AS_FOUND, *(f"{name} corrected" for name in CORRECTED[1:])]
    return [
        "",
        "## Errors corrected",
        "",
        *markdown_table(titles, [[*names, *own] for names, own in cells.items()]),
        "",
        "Ghosts: boxes that stand for nothing real are dropped. Misses: real objects that no box"
        f" means, with an overlap of {SAME:g} from above, are added, those too that the detector"
        " does not look for. Places: boxes that mean a real object are moved to where it is.",
    ]


def _measures(rows: Sequence[Row]) -> list[str]:
    """How far measures of perception go with safe driving."""
    titles = ["measure", "detector", "attacks", "ρ with safe driving", f"more than of {PRECISION}"]
    cells = [
        [
            row["measure"],
            BOTH if row["detector"] == BOTH else detector_name(row["detector"]),
            str(row["attacks"]),
            interval(row["rho"], row["interval"], 2),
            "" if row["measure"] == PRECISION else _signed(row, "more", 2),
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


def _measured(run: RunFolder) -> dict[str, Any]:
    configuration = run.configuration
    given = {**OPTIONS, **configuration.options}
    motion, scenes = Motion.named(given["motion"]), scenes_of(configuration)
    outcomes = Outcomes(run, labels_of(configuration))
    with progress("driving without a detector") as shown:
        headroom = headroom_rows(scenes, outcomes.scenarios, motion, configuration.seed, shown)
    with progress("driving on corrected detections") as shown:
        errors = corrected_rows(outcomes, scenes, motion, given["score_threshold"], shown)
    return {
        "scenarios": len(outcomes.scenarios),
        "headroom": as_json(headroom),
        "errors": as_json(errors),
    }


def _signed(row: Row, name: str = "gain", digits: int = 1) -> str:
    said = interval(row[name], row[f"{name}_interval"], digits)
    return f"+{said}" if row[name] is not None and row[name] >= 0 else said


if __name__ == "__main__":
    sys.exit(main())
