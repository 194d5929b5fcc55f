"""A figure of a report, before it is HTML: drawings or pictures, a legend, and how to read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from avsec_gym.drawing.page_plots import mark_shape


@dataclass(frozen=True)
class Key:
    """An entry of a legend; `line_key` and `mark_key` make the usual ones.

    Args:
        kind: Class name that gives the sample its colour.
        sample: The line or mark, as HTML.
        words: The text that explains the mark.
    """

    kind: str
    sample: str
    words: str


@dataclass(frozen=True)
class CaptionedImage:
    """An image with a caption.

    Args:
        image: The image as a data URI.
        caption: What stands below it.
        alt: What is read to those who do not see it.
        small: Figures after the caption, smaller.
        warning: What must be known of the picture, after the caption, in bold.
        still: The image that stands for one that moves, where a reader asks for less motion, as
            a data URI.
    """

    image: str
    caption: str
    alt: str
    small: str = ""
    warning: str = ""
    still: str = ""


@dataclass(frozen=True)
class PictureRow:
    """Pictures that belong together.

    Args:
        pictures: The pictures, from left to right.
        layout: ``layers`` for small ones beside each other, ``repairs`` for wide ones.
        title: What they show.
    """

    pictures: Sequence[CaptionedImage]
    layout: Literal["layers", "repairs"]
    title: str = ""


@dataclass(frozen=True)
class Figure:
    """Drawings that belong together.

    Args:
        title: What the figure shows.
        drawings: SVG, as `avsec_gym.drawing.page_plots.drawing` makes it; it is not escaped.
        legend: Samples of lines and marks.
        note: How to read it.
        layout: ``panels`` for small drawings, ``maps`` for larger ones.
        columns: Drawings beside each other; 0: as many as usual.
        pictures: Rows of images, above the drawings.
        label: A short name for those who hear the page; its title, if empty.
    """

    title: str
    drawings: Sequence[str] = ()
    legend: Sequence[Key] = ()
    note: str = ""
    layout: Literal["panels", "maps"] = "panels"
    columns: int = 0
    pictures: Sequence[PictureRow] = ()
    label: str = ""


def line_key(kind: str, words: str) -> Key:
    """The key of a line.

    Args:
        kind: Class names of the line, as of `avsec_gym.drawing.page_plots.polyline`; the last one
            gives it its colour.
        words: What the line stands for.

    Example:
        >>> line_key("dashed line-0", "by E alone").sample
        '<i class="dashed"></i>'
    """
    dashed = ' class="dashed"' if "dashed" in kind.split() else ""
    return Key(kind.split()[-1], f"<i{dashed}></i>", words)


def mark_key(kind: str, words: str, shape: str = "circle", size: float = 4.5) -> Key:
    """The key of a mark.

    Args:
        kind: Class names of the mark, as of `avsec_gym.drawing.page_plots.marker`; the last one
            gives it its colour.
        words: What the mark stands for.
        shape: The mark's shape, as of `avsec_gym.drawing.page_plots.marker`.
        size: The mark's radius, pixels.
    """
    styles = "".join(f" {name}" for name in kind.split() if name in ("hollow", "theirs"))
    drawn = mark_shape((7, 7), shape, size)
    sample = f'<svg viewBox="0 0 14 14" class="sample{styles}" aria-hidden="true">{drawn}</svg>'
    return Key(kind.split()[-1], sample, words)
