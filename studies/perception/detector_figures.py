"""Pictures of what detectors find in held-out frames, chosen by rule, and their curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.found_and_true import draw_frame
from avsec_gym.drawing.precision_recall import draw_precision_recall
from avsec_gym.drawing.scenario_picture import picture_array, save_picture
from avsec_gym.frame import Image
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.metrics.working_point import Counts, WorkingPoint, counted
from avsec_gym.storage.atomic_write import write_bytes
from studies.perception.detection_errors import CATEGORY, wanted_cars

RANKS = ("best", "median", "worst")
MIN_CARS = 3
"""Frames with fewer cars to find are not shown."""

_QUALITY = 88


@dataclass(frozen=True)
class Example:
    """A frame that is shown, and what is right and wrong in it."""

    rank: str
    of: int
    """How many frames were ordered."""
    frame: str
    counts: Mapping[str, Counts]
    """Counts by detector."""


def draw_precision(
    truth: Sequence[Boxes3D], found: Mapping[str, Sequence[Boxes3D]], folder: Path
) -> None:
    """Precision over recall, a picture ``NAME_precision.png`` for each detector."""
    for name, boxes in found.items():
        curves = average_precision(truth, boxes, classes=(CATEGORY,))
        figure = draw_precision_recall(curves, title=f"{name}, {len(truth)} held-out frames")
        save_picture(figure, folder / f"{name}_precision.png", overwrite=True)


def draw_examples(
    data: KittiObject,
    ids: Sequence[str],
    truth: Sequence[Boxes3D],
    found: Mapping[str, Sequence[Boxes3D]],
    points: Mapping[str, WorkingPoint | None],
    folder: Path,
) -> list[Example]:
    """The best, the median and the worst frame as ``detections_RANK.jpg``.

    Frames are ordered by the F1 of all detectors' boxes together (`working_point`), ties by id.

    Args:
        data: Where the frames are.
        ids: The ids of F frames.
        truth: The labels of the frames.
        found: Detections of each, by the detector's name.
        points: The working point of each detector; without one, no box is shown.
        folder: The folder for the pictures.
    """
    least = {name: point.score if point else float("inf") for name, point in points.items()}
    shown = {name: [above(each, least[name]) for each in boxes] for name, boxes in found.items()}
    cars = [int(wanted.sum()) for wanted in wanted_cars(truth)]
    places = [i for i, count in enumerate(cars) if count >= MIN_CARS]

    def judged(i: int) -> dict[str, Counts]:
        return {name: counted([truth[i]], [boxes[i]]) for name, boxes in shown.items()}

    def quality(i: int) -> tuple[float, str]:
        counts = judged(i).values()
        totals = Counts(
            found=sum(each.found for each in counts),
            missed=sum(each.missed for each in counts),
            false_alarms=sum(each.false_alarms for each in counts),
        )
        return -totals.f1, ids[i]

    places.sort(key=quality)
    chosen = {RANKS[0]: 0, RANKS[1]: len(places) // 2, RANKS[2]: -1} if places else {}
    result = []
    for rank, place in chosen.items():
        i = places[place]
        figure = draw_frame(
            data.frame(ids[i]),
            truth[i],
            {name: boxes[i] for name, boxes in shown.items()},
            title=f"frame {ids[i]}, the {rank} of {len(places)}: true boxes white and grey",
        )
        write_jpeg(folder / f"detections_{rank}.jpg", picture_array(figure))
        result.append(Example(rank, len(places), ids[i], judged(i)))
    return result


def write_jpeg(path: Path, picture: Image) -> None:
    """Write an RGB picture, over an earlier one."""
    _, content = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    path.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(path, content.tobytes(), overwrite=True)
