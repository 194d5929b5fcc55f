"""Pictures of attacked and repaired moments, made again: a run keeps figures, not images."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from matplotlib.figure import Figure

from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.page_table import number
from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.experiments.chapter3.localisation.figure import draw_repair
from avsec_gym.experiments.chapter3.localisation.measures import measures_of
from avsec_gym.experiments.chapter3.localisation.rates import LOWEST, MEDIAN
from avsec_gym.experiments.chapter3.localisation.repaired_moments import Attempt

SHOWN = {
    "facula": "facula, camera 2, 225 px",
    "bogus_return": "bogus return, 1.5 m, rays lost",
}
"""One attack of each kind, by the names of its files."""
_WORDS = {MEDIAN: "the median moment", LOWEST: "the moment with the lowest IoU"}


class Repairs(Protocol):
    """What is needed of chapter 3's `RepairedMoments`."""

    def again(self, moment: str, attack: str) -> Attempt:
        """One attack of a cell once more."""
        ...


@dataclass(frozen=True, eq=False)
class RepairPicture:
    """One moment: clean, attacked, found beside true, repaired.

    Args:
        file: A name for it, without a suffix.
        title: Attack, moment and IoU.
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
    summary: Mapping[str, Any],
    repairs: Repairs,
    count: int,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[RepairPicture]:
    """Of each attack of `SHOWN` the moment with the median IoU and that with the lowest.

    Args:
        summary: As `avsec_gym.experiments.chapter3.localisation.rates.localisation_summary` makes
            it.
        repairs: Makes them again.
        count: How many at most.
        on_progress: Told how many of how many are done.

    Raises:
        DataError: The recordings are not where they were.
    """
    rows = {row["attack"]: row for row in summary["attacks"]}
    wanted = [
        (kind, which, rows[attack])
        for which in (MEDIAN, LOWEST)
        for kind, attack in SHOWN.items()
        if attack in rows and rows[attack][which]
    ][:count]
    pictures = []
    for done, (kind, which, row) in enumerate(wanted, start=1):
        pictures.append(_picture(kind, which, row, repairs))
        on_progress(done, len(wanted))
    return pictures


def _picture(kind: str, which: str, row: Mapping[str, Any], repairs: Repairs) -> RepairPicture:
    attack, told = row["attack"], row[which]
    attempt = repairs.again(told["moment"], attack)
    figure = draw_repair(attempt.clean, attempt.tampered, attempt.mended)
    iou = measures_of(attempt.clean, attempt.tampered, attempt.mended)["iou"]
    return RepairPicture(
        f"repair_{kind}_{which}",
        f"{attack}: {_WORDS[which]}, {told['moment']}, IoU {number(told['iou'], 100)} %",
        figure,
        embedded(picture_array(figure)),
        iou is not None and math.isclose(iou, told["iou"]),
    )
