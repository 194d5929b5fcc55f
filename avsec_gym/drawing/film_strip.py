"""Pictures of a filmed drive with words: a strip, a second from one to the next, and a clip."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.figure_style import FAINT, INK, as_text
from avsec_gym.drawing.film_picture import CONTACT, FilmView, film_picture
from avsec_gym.frame import Image

_PAPER = (255, 255, 255)
_GAP = 6
_LINE = 17
"""Pixels of a line of words."""
_STRIP = FilmView((124, 330), 6.0, "up", 12.0)
_CLIP = FilmView((760, 132), 8.0, "right", 18.0)
_WAIT = 12
"""Pictures for which a clip shows the end."""
RATE = 10
"""Pictures in a second of a clip, as many as the films have instants."""


@dataclass(frozen=True, eq=False)
class ShownDrive:
    """A drive to be shown.

    Args:
        name: What is written beside it.
        film: The drive.
        outcome: How it ended, in words.
        bad: Whether that is bad.
    """

    name: str
    film: DriveFilm
    outcome: str
    bad: bool


def film_strip(shown: ShownDrive, panels: int, every: int = 1) -> Image:
    """Pictures of every second and of the end, side by side, ahead is up.

    Args:
        shown: The drive.
        panels: The number of pictures that there is room for; the strip is that wide, however short
            the drive is.
        every: Seconds between two pictures.

    Returns:
        Red, green and blue, shape (H, W, 3).
    """
    film = shown.film
    instants = strip_instants(film, every)[:panels]
    width, height = _STRIP.size
    strip = np.full((height + 2 * _LINE, panels * (width + _GAP) - _GAP, 3), _PAPER, np.uint8)
    words: list[_Words] = []
    for number, instant in enumerate(instants):
        left = number * (width + _GAP)
        strip[:height, left : left + width] = film_picture(film, instant, _STRIP)
        ends = instant == len(film) - 1
        speed = f"{film.times[instant]:.1f} s   {film.car[instant, 2]:.1f} m/s"
        words.append(_Words((left + 2, height + 2), speed, FAINT))
        if ends:
            colour = CONTACT if shown.bad else INK
            words.append(_Words((left + 2, height + _LINE), shown.outcome, colour, bold=True))
        elif film.stops[instant]:
            words.append(_Words((left + 2, height + _LINE), "emergency stop", CONTACT))
    return _written(strip, words)


def strip_instants(film: DriveFilm, every: int = 1) -> list[int]:
    """The instants of a strip: each full second that is not just before the end, and the end.

    Args:
        film: The drive.
        every: Seconds between two instants.
    """
    last = len(film) - 1
    seconds = range(0, int(film.times[-1]) + 1, every)
    return [at for at in map(film.at, seconds) if film.times[last] - film.times[at] > 0.35] + [last]


def clip(drives: Sequence[ShownDrive]) -> list[Image]:
    """Drives one below the other, a picture for each tenth of a second; what is over stands still.

    Args:
        drives: Drives of one scene under different settings.
    """
    length = max(len(shown.film) for shown in drives)
    images = [_clip_image(drives, instant) for instant in range(length)]
    return images + [images[-1]] * _WAIT


def gif(images: Sequence[Image], rate: int = RATE) -> bytes:
    """The pictures as an animated GIF that begins anew when it is over.

    Args:
        images: Pictures of one size.
        rate: Pictures in a second.
    """
    from PIL import Image as Pillow

    # One palette for all, of a picture of the beginning and one of the end.
    both = Pillow.fromarray(np.vstack([images[0], images[-1]]))
    palette = both.quantize(64, dither=Pillow.Dither.NONE)
    frames = [
        Pillow.fromarray(image).quantize(palette=palette, dither=Pillow.Dither.NONE)
        for image in images
    ]
    content = io.BytesIO()
    frames[0].save(
        content,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=1000 // rate,
        loop=0,
        optimize=True,
    )
    return content.getvalue()


def _clip_image(drives: Sequence[ShownDrive], instant: int) -> Image:
    width, height = _CLIP.size
    image = np.full((len(drives) * (height + _LINE + _GAP), width, 3), _PAPER, np.uint8)
    words = []
    for number, shown in enumerate(drives):
        top = number * (height + _LINE + _GAP)
        film = shown.film
        at = min(instant, len(film) - 1)
        image[top + _LINE : top + _LINE + height] = film_picture(film, at, _CLIP)
        words.append(_Words((2, top), shown.name, INK, bold=True))
        speed = f"{film.times[at]:.1f} s   {film.car[at, 2]:.1f} m/s"
        words.append(_Words((150, top), speed, FAINT))
        if at == len(film) - 1:
            words.append(
                _Words((290, top), shown.outcome, CONTACT if shown.bad else INK, bold=True)
            )
        elif film.stops[at]:
            words.append(_Words((290, top), "emergency stop", CONTACT))
    return _written(image, words)


@dataclass(frozen=True)
class _Words:
    at: tuple[int, int]
    text: str
    colour: str
    bold: bool = False


def _written(image: Image, words: Sequence[_Words]) -> Image:
    from PIL import Image as Pillow
    from PIL import ImageDraw

    picture = Pillow.fromarray(image)
    pen = ImageDraw.Draw(picture)
    for each in words:
        pen.text(each.at, as_text(each.text), fill=each.colour, font=_font(each.bold))
    return np.asarray(picture).copy()


@lru_cache(maxsize=2)
def _font(bold: bool) -> Any:
    """The typeface of the figures, which matplotlib brings."""
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts/ttf" / name), 12)
