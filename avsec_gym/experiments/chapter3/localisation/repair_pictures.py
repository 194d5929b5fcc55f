"""Pictures of attacked and repaired frames, made again: a run keeps figures, not images."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from matplotlib.figure import Figure

from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.page_table import number
from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.experiments.chapter3.localisation.figure import draw_repair
from avsec_gym.experiments.chapter3.localisation.measures import measures_of
from avsec_gym.experiments.chapter3.localisation.rates import LocalisationSummary, LocatedFrame
from avsec_gym.experiments.chapter3.localisation.repaired_frames import Attempt
from avsec_gym.progress import Progress, no_progress

SHOWN = {
    "facula": "facula, camera 2, 225 px",
    "bogus_return": "bogus return, 1.5 m, rays lost",
}
"""One attack of each kind, by the names of its files."""
_WORDS = {"median": "the median frame", "lowest": "the frame with the lowest IoU"}
"""The words of each attack: the frames that are shown, by their names in the summary."""


class Repairs(Protocol):
    """What is needed of chapter 3's `RepairedFrames`."""

    def again(self, id: str, attack: str) -> Attempt:
        """One attack of a cell once more."""
        ...


@dataclass(frozen=True, eq=False)
class RepairPicture:
    """One frame: clean, attacked, found beside true, repaired.

    Args:
        file: A name for it, without a suffix.
        title: Attack, frame and IoU.
        figure: The picture.
        image: The same as a data URI.
        as_stored: Whether the IoU came out as it is stored in the run.
    """

    file: str
    title: str
    figure: Figure
    image: str
    as_stored: bool


def repair_pictures(
    summary: LocalisationSummary,
    repairs: Repairs,
    count: int,
    on_progress: Progress = no_progress,
) -> list[RepairPicture]:
    """The frames with the median IoU and with the lowest one, for each attack of `SHOWN`.

    Args:
        summary: The rows of a run.
        repairs: The object that makes the frames again.
        count: How many at most.
        on_progress: Function that gets how many of how many are done.

    Raises:
        DataError: The recordings are not where they were.
    """
    rows = {row.attack: row for row in summary.attacks}
    wanted = [
        (f"repair_{kind}_{which}", attack, words, frame)
        for which, words in _WORDS.items()
        for kind, attack in SHOWN.items()
        if attack in rows and (frame := getattr(rows[attack], which))
    ][:count]
    pictures = []
    for done, picture in enumerate(wanted, start=1):
        pictures.append(_picture(*picture, repairs))
        on_progress(done, len(wanted))
    return pictures


def _picture(
    file: str, attack: str, words: str, frame: LocatedFrame, repairs: Repairs
) -> RepairPicture:
    attempt = repairs.again(frame.frame, attack)
    figure = draw_repair(attempt.clean, attempt.tampered, attempt.repaired)
    iou = measures_of(attempt.clean, attempt.tampered, attempt.repaired)["iou"]
    return RepairPicture(
        file,
        f"{attack}: {words}, {frame.frame}, IoU {number(frame.iou, 100)} %",
        figure,
        embedded(picture_array(figure)),
        iou is not None and math.isclose(iou, frame.iou),
    )
