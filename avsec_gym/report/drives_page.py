"""Drives under several settings as one HTML page: the table, film strips, every drive."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.drives.drive_folder import DriveFolder
from avsec_gym.drives.scene_figures import KEY_OF_STRIPS, scene_figure
from avsec_gym.drives.summary import Mean, SettingSummary
from avsec_gym.drives.telling import (
    DrivenScene,
    by_scene,
    good,
    how_bad,
    outcome_in_words,
    telling,
)
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.html import joined, page_environment
from avsec_gym.runs.section import Section

_QUESTION = "How does the car drive on, by what it believes?"
_GOOD = 2
"""Scenes in which all goes well that are shown, too."""


def drives_page(
    folder: DriveFolder,
    summary: Sequence[SettingSummary],
    record: Mapping[str, Any],
    pictures: int,
) -> str:
    """The page; the same bytes for the same drives.

    Args:
        folder: The drives.
        summary: The rates and means of the drives, setting by setting.
        record: What was asked for.
        pictures: The most scenes whose drives ended badly that are shown as film strips.

    Raises:
        DataError: A film is missing or damaged.
    """
    scenes = by_scene(folder.rows.values())
    sections = [
        Section("settings", "The settings, side by side", parts=[_settings(summary)], link="table"),
        *_strips(folder, scenes, pictures),
        Section("drives", "Every drive", parts=[_drives(scenes)]),
    ]
    environment = page_environment()
    return environment.get_template("drives.html.j2").render(
        question=_QUESTION,
        extent=f"{len(folder.rows)} drives, {len(scenes)} under each setting",
        sections=sections,
        facts=[(key, _fact(value)) for key, value in record.items()],
        css=joined(environment, "report.css"),
        js=joined(environment, "report.js"),
    )


def _settings(summary: Sequence[SettingSummary]) -> Table:
    differ = any(each.differences for each in summary)
    columns = ["setting", "drives", "at-fault collisions, %", "collisions, %", "goal reached, %"]
    columns += ["brakes hard, %"]
    rates = ["at_fault", "collision", "goal", "hard_braking"]
    if any(each.rates["alarm"].count for each in summary):
        columns += ["alarm raised, %"]
        rates += ["alarm"]
    columns += ["NAVSIM score"]
    first = summary[0].setting
    columns += [f"at fault against {first}, %", f"score against {first}"] if differ else []
    rows = []
    for each in summary:
        cells = [name(each.setting), figure(each.drives, digits=0)]
        cells += [_share(each.rates[rate]) for rate in rates]
        cells.append(_mean(each.navsim_score))
        if differ:
            cells.append(_mean(each.differences.get("at_fault"), scale=100, digits=1, signed=True))
            cells.append(_mean(each.differences.get("navsim_score"), signed=True))
        rows.append(cells)
    note = (
        "In brackets 95 % intervals that know which drives share a scene. At fault: by nuPlan's "
        "rule. Brakes hard: above 4.05 m/s², nuPlan's bound of comfort. Score: NAVSIM's formula, "
        "0 to 1."
    )
    return Table("Rates of all drives", columns, rows, note)


def _share(share: Share) -> TableCell:
    hint = f"{share.count} of {share.of} drives"
    return figure(share.rate, share.interval, scale=100, hint=hint)


def _mean(
    mean: Mean | None, *, scale: float = 1.0, digits: int = 2, signed: bool = False
) -> TableCell:
    if mean is None:
        return figure(None)
    return figure(mean.value, mean.interval, scale=scale, digits=digits, signed=signed)


def _strips(folder: DriveFolder, scenes: Sequence[DrivenScene], pictures: int) -> list[Section]:
    """Film strips of scenes that ended badly under some setting, and of some that did not."""
    if not pictures:
        return []
    bad, fine = telling(scenes), good(scenes)
    sections = []
    if bad:
        left = len(bad) - pictures
        more = f" {left} more are not shown." if left > 0 else ""
        sentence = (
            f"In {len(bad)} of {len(scenes)} cases a drive did not reach its goal under some "
            f"setting; where settings differ most comes first.{more}"
        )
        parts = [scene_figure(folder, scene) for scene in bad[:pictures]]
        sections.append(
            Section(
                "bad", "What went wrong", [sentence], parts, "film strips", context=KEY_OF_STRIPS
            )
        )
    if fine:
        parts = [scene_figure(folder, scene) for scene in fine[:_GOOD]]
        sentence = "Every drive reached its goal; those that came nearest to something."
        context = "" if bad else KEY_OF_STRIPS
        sections.append(Section("good", "What went well", [sentence], parts, context=context))
    return sections


def _drives(scenes: Sequence[DrivenScene]) -> Table:
    rows = []
    for scene in scenes:
        for row in scene.rows:
            bad = how_bad(row)
            outcome = TableCell(
                outcome_in_words(row), tone="bad" if bad > 1 else "warn" if bad else "", words=True
            )
            rows.append(
                [
                    name(row["scenario"]),
                    name(row["intention"]),
                    name(row["setting"]),
                    outcome,
                    figure(row["duration"]),
                    figure(row["progress"]),
                    figure(row["smallest_distance"], digits=2),
                    figure(row["hardest_braking"]),
                    figure(row["navsim_score"], digits=3),
                    figure(row["seed"], digits=0),
                ]
            )
    columns = ["scene", "intention", "setting", "outcome", "time, s", "progress, m"]
    columns += ["smallest distance, m", "hardest braking, m/s²", "NAVSIM score", "seed"]
    return Table("Drives", columns, rows, names=4, sortable=True, filters=(1, 2, 3))


def _fact(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
