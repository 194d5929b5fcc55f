"""The demo's drives on its page: sentences, a film, and film strips."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.film_strip import RATE, clip, gif
from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.drives.drive_folder import RECORD, DriveFolder, has_drives
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.scene_figures import KEY_OF_STRIPS, scene_figure, shown_drives, views_row
from avsec_gym.drives.telling import DrivenScene, by_scene, outcome_in_words
from avsec_gym.experiments.demo.drive_on import ATTACKED, CONTROL, DEFENDED, UNATTACKED
from avsec_gym.experiments.demo.experiment import FULL_REPORT
from avsec_gym.experiments.demo.telling_drive import TELLING
from avsec_gym.runs.section import Section
from avsec_gym.storage.json_files import read_json_object

_ENDS = {
    "goal": "it reaches its goal",
    "stopped": "it stands",
    "time": "it still drives",
    "off_road": "it leaves the road",
}
_CONTESTED = (
    "a car that sees nothing is to blame for a collision, one that sees all reaches its goal"
)
_TIMES = {3: "three times", 4: "four times"}
_EVERY = 2
"""Instants from one picture of the film to the next."""


def driven_rows(out: Path) -> list[DriveRow]:
    """The rows of the drives, in the order of the settings; none where nothing was driven.

    Args:
        out: Folder of the drives.

    Raises:
        DataError: The folder is damaged.
    """
    if not has_drives(out):
        return []
    rows = {row["setting"]: row for row in _folder(out).rows.values()}
    return [rows[name] for name in _record(out)["settings"] if name in rows]


def driven_section(out: Path) -> Section | None:
    """The drives as a clip and as film strips; None where not all of them are there.

    Args:
        out: Folder of the drives.

    Raises:
        DataError: The folder is damaged.
    """
    rows = driven_rows(out)
    if not rows or len(rows) < len(_record(out)["settings"]):
        return None
    folder, scene = _folder(out), by_scene(rows)[0]
    first_stops = {row["setting"]: _first_stop(folder, row) for row in rows}
    attacked = next(row for row in rows if row["setting"] == ATTACKED)
    row = views_row(folder, scene, attacked["duration"])
    views = [Figure("The last that the attacked car sees", pictures=[row])] if row else []
    handover = _record(out)["settings"][DEFENDED].get("handover")
    beside = " ".join([KEY_OF_STRIPS, *beside_in_words(rows, first_stops, handover)])
    strips = replace(scene_figure(folder, scene, views=False), note=beside)
    return Section(
        "drives",
        "A car drives on under a laser",
        [*in_words(rows, first_stops)],
        [*views, _film(folder, scene), strips],
        link="Driving on",
    )


def in_words(rows: Sequence[DriveRow], first_stops: Mapping[str, float | None]) -> Iterator[str]:
    """How the drives ended: alone, under the laser, and with a validator, a sentence each.

    Args:
        rows: The rows that `driven_rows` makes.
        first_stops: When each setting's first emergency stop begins, seconds; None: it has none.
    """
    ends = {row["setting"]: row for row in rows}
    yield f"Unattacked: {_end(ends[UNATTACKED])}."
    yield f"With a laser on the left camera: {_end(ends[ATTACKED])}."
    defended = f"{_end(ends[DEFENDED])}{_stops(ends[DEFENDED], first_stops[DEFENDED])}"
    yield f"With the laser, and a validator that stops the car at an alarm: {defended}."


def beside_in_words(
    rows: Sequence[DriveRow],
    first_stops: Mapping[str, float | None],
    handover: float | None = None,
) -> Iterator[str]:
    """The scene, what was passed over for it, and what the drives leave open, a sentence each.

    Args:
        rows: The rows that `driven_rows` makes.
        first_stops: When each setting's first emergency stop begins, seconds; None: it has none.
        handover: Seconds that a defended car stands before it is handed over; None: it is not.
    """
    ends = {row["setting"]: row for row in rows}
    yield from _scene_in_words(ends[UNATTACKED], ends[ATTACKED])
    if handover is not None:
        yield f"A car that has stood by alarms for {handover:g} s is handed over to a human."
    if CONTROL in ends:
        control = f"{_end(ends[CONTROL])}{_stops(ends[CONTROL], first_stops[CONTROL])}"
        yield f"With the validator, but without the laser, as a control: {control}."
    else:
        yield (
            "No drive here shows whether the validator also stops the car without a laser:"
            f" a demo of {FULL_REPORT} scenes or more has one."
        )


def _scene_in_words(unattacked: DriveRow, attacked: DriveRow) -> Iterator[str]:
    scene, known = unattacked["scenario"], TELLING.get(unattacked["seed"])
    passed_over = None
    if known is None or known.scene != scene:
        rule = f"the first in which {_CONTESTED}"
    elif unattacked["outcome"] == "goal" and attacked["at_fault"]:
        rule = f"the first in which {_CONTESTED}, and the light decides"
        passed_over = known.passed_over
    else:
        rule = f"one in which {_CONTESTED}"
    yield f"Scene {scene}, {rule}, driven by what Stereo R-CNN sees in rendered frames."
    if passed_over is not None:
        yield passed_over.in_words()


def _end(row: DriveRow) -> str:
    end = _ENDS.get(row["outcome"])
    if end is None:
        end = "it collides and is to blame" if row["at_fault"] else "it collides, not to blame"
    return f"{end} after {row['duration']:.1f} s"


def _stops(row: DriveRow, first_stop: float | None) -> str:
    """How far a car has come, and when it first brakes to a stop."""
    path = row["path_length"]
    way = "" if path is None else f" and {path:.1f} m"
    if first_stop is None:
        return f"{way}, without an emergency stop"
    begins = f"after {first_stop:.1f} s" if first_stop else "at once"
    return f"{way}; its first emergency stop begins {begins}"


def _first_stop(folder: DriveFolder, row: DriveRow) -> float | None:
    film = folder.film(row["id"])
    stops = np.flatnonzero(film.stops)
    return float(film.times[stops[0]]) if len(stops) else None


def _film(folder: DriveFolder, scene: DrivenScene) -> Figure:
    """The drives one below the other, moving."""
    pictures = clip(shown_drives(folder, scene))
    content = gif(pictures[::_EVERY], RATE // _EVERY)
    image = f"data:image/gif;base64,{base64.b64encode(content).decode()}"
    ends = "; ".join(f"{row['setting']}: {outcome_in_words(row)}" for row in scene.rows)
    times = _TIMES[len(scene.rows)]
    words = f"A film of the same scene, driven {times}. {ends}"
    film = CaptionedImage(image, ends, words, still=embedded(pictures[-1]))
    return Figure(f"The same scene, {times}", pictures=[PictureRow([film], "repairs")])


def _folder(out: Path) -> DriveFolder:
    return DriveFolder(out, _record(out))


def _record(out: Path) -> dict[str, Any]:
    record = read_json_object(out / RECORD, remedy=f"Take {out} away: it is driven again.")
    return {key: value for key, value in record.items() if key != "format"}
