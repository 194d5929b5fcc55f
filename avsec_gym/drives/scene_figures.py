"""The drives of a scene on a page: film strips, one below the other, and how to read them."""

from __future__ import annotations

import math

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.embedded_image import embedded, embedded_file
from avsec_gym.drawing.film_strip import ShownDrive, film_strip
from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.drives.camera_views import view_until
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


def scene_figure(folder: DriveFolder, scene: DrivenScene, *, views: bool = True) -> Figure:
    """A film strip for each setting under which a scene was driven, what the cameras showed first.

    Args:
        folder: The drives.
        scene: One of theirs.
        views: Whether the cameras' images are part of it, where there are any.

    Raises:
        DataError: A film or an image is missing or damaged.
    """
    drives = shown_drives(folder, scene)
    length = max(float(shown.film.times[-1]) for shown in drives)
    every = math.ceil(length / 8.0)
    panels = max(math.floor(length / every) + 2, _LEAST_PANELS)
    strips = [PictureRow([_strip(shown, panels, every)], "repairs", shown.name) for shown in drives]
    row = views_row(folder, scene) if views else None
    return Figure(
        f"{scene.scenario}, {scene.intention}", pictures=[*([row] if row else []), *strips]
    )


def views_row(
    folder: DriveFolder, scene: DrivenScene, time: float | None = None
) -> PictureRow | None:
    """What the left camera of each drive showed last until a time, with what the car believed.

    Args:
        folder: The drives.
        scene: One of theirs.
        time: Seconds since the start; None: the end of the drive that ends worst of those that have
            images, the last of these where several do.

    Returns:
        None where none of the drives has kept what its camera showed.

    Raises:
        DataError: An image cannot be read.
    """
    seeing = [row for row in scene.rows if view_until(folder.out, row["id"]) is not None]
    if time is None and seeing:
        time = max(reversed(seeing), key=how_bad)["duration"]
    pictures = []
    for row in seeing:
        view = view_until(folder.out, row["id"], time)
        if view is not None:
            what = f"{row['setting']}, after {view.time:.1f} s"
            alt = f"Image of the left camera and the boxes that the car believes: {what}"
            pictures.append(CaptionedImage(embedded_file(view.content), what, alt))
    title = "What the left camera shows, and the boxes that the car believes"
    return PictureRow(pictures, "repairs", title) if pictures else None


def _strip(shown: ShownDrive, panels: int, every: int) -> CaptionedImage:
    film: DriveFilm = shown.film
    return CaptionedImage(
        embedded(film_strip(shown, panels, every)),
        f"{shown.outcome} after {film.times[-1]:.1f} s",
        f"Film strip of a drive that ends after {film.times[-1]:.1f} s: {shown.outcome}",
    )
