"""The drives of a scene on a page: film strips, one below the other, and how to read them."""

from __future__ import annotations

import math

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.film_strip import ShownDrive, film_strip
from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.drives.drive_folder import DriveFolder
from avsec_gym.drives.telling import DrivenScene, how_bad, outcome_in_words

KEY_OF_STRIPS = (
    "A picture for each second and one of the end, ahead is up. Blue: the car, its way and its "
    "plan; grey: what is there and the car believes in; white: what is there and it does not "
    "believe in; dashed red: what it believes where it lies otherwise; red: what it has touched, "
    "or its brake lights; yellow: the line that it is to cross."
)
_LEAST_PANELS = 8
"""Pictures that a strip has room for, so that those of short drives are not blown up."""


def shown_drives(folder: DriveFolder, scene: DrivenScene) -> list[ShownDrive]:
    """The drives of a scene, to be drawn.

    Args:
        folder: The drives.
        scene: One of theirs.

    Raises:
        DataError: A film is missing or damaged.
    """
    return [
        ShownDrive(row["setting"], folder.film(row["id"]), outcome_in_words(row), how_bad(row) > 0)
        for row in scene.rows
    ]


def scene_figure(folder: DriveFolder, scene: DrivenScene) -> Figure:
    """A film strip for each setting under which a scene was driven.

    Args:
        folder: The drives.
        scene: One of theirs.

    Raises:
        DataError: A film is missing or damaged.
    """
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


def _strip(shown: ShownDrive, panels: int, every: int) -> CaptionedImage:
    film: DriveFilm = shown.film
    return CaptionedImage(
        embedded(film_strip(shown, panels, every)),
        f"{shown.outcome} after {film.times[-1]:.1f} s",
        f"Film strip of a drive that ends after {film.times[-1]:.1f} s: {shown.outcome}",
    )
