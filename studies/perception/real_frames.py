"""What the small detectors see in real frames of KITTI, which are not what they learned from.

Run ``python -m studies.perception.real_frames --kitti ROOT --json FILE --figure
PNG``. Pictures with the photographs go to ``--out``; KITTI's images may not be passed on, so what
is meant to be published (``--json``, ``--figure``) holds detections, and labels only as footprints
from above.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.found_and_true import draw_frame, draw_frames_from_above
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import above, default_score_threshold
from avsec_gym.metrics.working_point import MIN_IOU, Counts, counted
from avsec_gym.perception.detectors import make_detector
from avsec_gym.storage.json_files import read_json
from studies.answer import answer
from studies.perception.detection_errors import (
    CATEGORY,
    car_errors,
    footprints,
    paired,
    wanted_cars,
)
from studies.perception.detector_precision import label_of, named

FRAMES = ("000107", "000274", "001267", "001570")

_SUREST = 10
"""So many detections of a frame are listed."""


@dataclass(frozen=True)
class FrameCounts:
    """What is right and wrong, of the detections that are sure enough."""

    to_find: int
    """Moderate cars."""
    seen_in_image: int
    """How many of them a detection means in the image."""
    counts: Counts = field(metadata=FLAT)


@dataclass(frozen=True)
class LabelledCar:
    """A labelled car, and the detection that means it in the image."""

    ahead: float | None
    """The distance ahead of the camera, metres."""
    to_find: bool
    """Cars to find at the moderate level."""
    score: float | None
    """None where no detection means it."""
    depth_error: float | None
    """Found minus true, metres."""
    overlap: float | None
    """The largest intersection over union from above with any detection, however unsure."""


@dataclass(frozen=True)
class DescribedDetection:
    """A detection, and the category of the label that it means."""

    score: float | None
    right: float | None
    """The distance to the right of the camera, metres."""
    ahead: float | None
    """The distance ahead of the camera, metres."""
    means: str | None
    is_right: bool


@dataclass(frozen=True)
class ComparedFrame:
    """What a detector finds in a frame."""

    total: FrameCounts = field(metadata=FLAT)
    cars: list[LabelledCar]
    """Nearest first."""
    surest: list[DescribedDetection]


@dataclass(frozen=True)
class RealDetections:
    """What a detector finds in all frames."""

    least_score: float
    """Least score of the boxes that count."""
    frames: Mapping[str, ComparedFrame]
    all: FrameCounts


@dataclass(frozen=True)
class DetectorsInRealFrames:
    """The result."""

    frames: list[str]
    detectors: Mapping[str, RealDetections]


def run(options: argparse.Namespace) -> DetectorsInRealFrames:
    """Detect, compare, draw.

    Raises:
        ConfigurationError: There is no such detector.
        DataError: A frame is missing or broken, or there are no weights.
    """
    data = KittiObject(options.kitti)
    points = _working_points(options.precision)
    truth = {id: data.labels(id, keep_dont_care=True) for id in options.frames}
    found: dict[str, dict[str, Boxes3D]] = {}
    least: dict[str, float] = {}
    for asked in map(named, options.detectors):
        name, detector = label_of(asked), make_detector(asked)
        found[name] = {id: detector.detect(data.frame(id)) for id in options.frames}
        scores = [boxes.score for boxes in found[name].values()]
        least[name] = points.get(name, default_score_threshold(np.concatenate(scores)))
    shown = {
        id: {name: above(found[name][id], least[name]) for name in found} for id in options.frames
    }
    for id, boxes in shown.items():
        figure = draw_frame(data.frame(id), truth[id], boxes, title=f"KITTI {id}")
        save_picture(figure, options.out / f"{id}.png", overwrite=True)
    if options.figure is not None:
        frames = {id: (truth[id], shown[id]) for id in options.frames}
        save_picture(draw_frames_from_above(frames), options.figure, overwrite=True)
    detectors = {
        name: RealDetections(
            least_score=round(least[name], 4),
            frames={id: compared(truth[id], boxes[id], least[name]) for id in options.frames},
            all=_total([truth[id] for id in boxes], [*boxes.values()], least[name]),
        )
        for name, boxes in found.items()
    }
    return DetectorsInRealFrames(list(options.frames), detectors)


def compared(truth: Boxes3D, found: Boxes3D, least_score: float) -> ComparedFrame:
    """What a detector reports of a frame's cars.

    Args:
        truth: Labels, DontCare regions included.
        found: All detections.
        least_score: The least score of those that are taken for real.
    """
    is_car = truth.category == CATEGORY
    errors = car_errors([truth], [found], [is_car])
    to_find = wanted_cars([truth])[0][is_car]
    cars = [
        LabelledCar(
            ahead=_rounded(errors.distance[i]),
            to_find=bool(to_find[i]),
            score=_rounded(errors.score[i]),
            depth_error=_rounded(errors.values["depth"][i]),
            overlap=_rounded(errors.overlap[i]),
        )
        for i in np.argsort(errors.distance)
    ]
    surest = found[np.argsort(-found.score, kind="stable")[:_SUREST]]
    total = _total([truth], [found], least_score)
    return ComparedFrame(total, cars, _described(truth, surest))


def _total(truth: Sequence[Boxes3D], found: Sequence[Boxes3D], least_score: float) -> FrameCounts:
    real = [above(boxes, least_score) for boxes in found]
    meant = sum(
        int(np.isin(np.flatnonzero(wanted), paired(labels, boxes).label).sum())
        for labels, boxes, wanted in zip(truth, real, wanted_cars(truth), strict=True)
    )
    counts = counted(truth, real)
    return FrameCounts(counts.found + counts.missed, meant, counts)


def _described(truth: Boxes3D, found: Boxes3D) -> list[DescribedDetection]:
    """Detections one by one, with the category of the label that each means."""
    pairs = paired(truth, found)
    meant = dict(zip(pairs.detection.tolist(), truth.category[pairs.label].tolist(), strict=True))
    overlap = np.zeros(len(found))
    is_car = truth.category == CATEGORY
    if len(found) and is_car.any():
        overlap = rectangle_iou(footprints(found), footprints(truth[is_car])).max(axis=1)
    return [
        DescribedDetection(
            score=_rounded(found.score[i]),
            right=_rounded(found.location[i, 0]),
            ahead=_rounded(found.location[i, 2]),
            means=meant.get(i),
            is_right=bool(overlap[i] > MIN_IOU),
        )
        for i in range(len(found))
    ]


def _rounded(value: float) -> float | None:
    """None for NaN."""
    return round(float(value), 3) if np.isfinite(value) else None


def _working_points(path: Path | None) -> Mapping[str, float]:
    """Scores by detector, of a result of `detector_precision`."""
    if path is None:
        return {}
    try:
        detectors = read_json(path, remedy="Make it anew.")["detectors"]
        points = {name: figures["working_point"] for name, figures in detectors.items()}
        return {name: float(point["score"]) for name, point in points.items() if point}
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(f"This is no result of detector_precision ({error}).", path=path) from error


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object benchmark")
    parser.add_argument("--frames", nargs="+", default=list(FRAMES))
    parser.add_argument("--detectors", nargs="+", default=["dsgn", "dsgn:medium", "stereo_rcnn"])
    parser.add_argument(
        "--precision", type=Path, help="of detector_precision: scores from which boxes count"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("runs/real_frames"), help="for pictures, not to pass on"
    )
    parser.add_argument("--figure", type=Path, help="PNG without photographs")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
