"""Drives under several settings as one HTML page: the table, film strips, every drive."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.film_strip import Shown, film_strip
from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.drives.drive_folder import DriveFolder
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
_LEAST_PANELS = 8
"""Pictures that a strip has room for, so that those of short drives are not blown up."""
_NOTE = (
    "A picture for each second and one of the end, ahead is up. Blue: the car, its way and its "
    "plan; grey: what is there and the car believes in; white: what is there and it does not "
    "believe in; dashed red: what it believes where it lies otherwise; red: what it has touched, "
    "or its brake lights; yellow: the line that it is to cross."
)


def drives_page(
    folder: DriveFolder,
    summary: Sequence[SettingSummary],
    record: Mapping[str, Any],
    pictures: int,
) -> str:
    """The page; the same bytes for the same drives.

    Args:
        folder: The drives.
        summary: Their rates and means, setting by setting.
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


def shown_drives(folder: DriveFolder, scene: DrivenScene) -> list[Shown]:
    """The drives of a scene, to be drawn.

    Args:
        folder: The drives.
        scene: One of theirs.

    Raises:
        DataError: A film is missing or damaged.
    """
    return [
        Shown(row["setting"], folder.film(row["id"]), outcome_in_words(row), how_bad(row) > 0)
        for row in scene.rows
    ]


def _settings(summary: Sequence[SettingSummary]) -> Table:
    differ = any(each.differences for each in summary)
    columns = ["setting", "drives", "at-fault collisions, %", "collisions, %", "goal reached, %"]
    columns += ["brakes hard, %", "NAVSIM score"]
    first = summary[0].setting
    columns += [f"at fault against {first}, %", f"score against {first}"] if differ else []
    rows = []
    for each in summary:
        cells = [name(each.setting), figure(each.drives, digits=0)]
        cells += [
            _share(each.rates[rate]) for rate in ("at_fault", "collision", "goal", "hard_braking")
        ]
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
        parts = [_scene_figure(folder, scene) for scene in bad[:pictures]]
        sections.append(
            Section("bad", "What went wrong", [sentence], parts, "film strips", context=_NOTE)
        )
    if fine:
        parts = [_scene_figure(folder, scene) for scene in fine[:_GOOD]]
        sentence = "Every drive reached its goal; those that came nearest to something."
        context = "" if bad else _NOTE
        sections.append(Section("good", "What went well", [sentence], parts, context=context))
    return sections


def _scene_figure(folder: DriveFolder, scene: DrivenScene) -> Figure:
    drives = shown_drives(folder, scene)
    length = max(float(shown.film.times[-1]) for shown in drives)
    every = math.ceil(length / 8.0)
    panels = max(math.floor(length / every) + 2, _LEAST_PANELS)
    return Figure(
        f"{scene.scenario}, {scene.intention}",
        pictures=[
            PictureRow([_strip(shown, panels, every)], "repairs", shown.name) for shown in drives
        ],
    )


def _strip(shown: Shown, panels: int, every: int) -> CaptionedImage:
    film: DriveFilm = shown.film
    return CaptionedImage(
        embedded(film_strip(shown, panels, every)),
        f"{shown.outcome} after {film.times[-1]:.1f} s",
        f"Film strip of a drive that ends after {film.times[-1]:.1f} s: {shown.outcome}",
    )


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
