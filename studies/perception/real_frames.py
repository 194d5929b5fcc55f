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
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.found_and_true import draw_frame, draw_frames_from_above
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import above, default_score_threshold
from avsec_gym.metrics.working_point import MIN_IOU, counted
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
from studies.perception.detector_precision import named

FRAMES = ("000107", "000274", "001267", "001570")

_SUREST = 10
"""So many detections of a frame are listed."""


def run(options: argparse.Namespace) -> dict[str, Any]:
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
        name, detector = asked["name"], make_detector(asked)
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
    return {
        "frames": list(options.frames),
        "detectors": {
            name: {
                "least_score": round(least[name], 4),
                "frames": {
                    id: compared(truth[id], found[name][id], least[name]) for id in options.frames
                },
                "all": _total(
                    [truth[id] for id in found[name]], [*found[name].values()], least[name]
                ),
            }
            for name in found
        },
    }


def compared(truth: Boxes3D, found: Boxes3D, least_score: float) -> dict[str, Any]:
    """What a detector reports of a frame's cars; JSON-able.

    Args:
        truth: Labels, DontCare regions included.
        found: All detections.
        least_score: The least score of those that are taken for real.

    Returns:
        Right and wrong (`avsec_gym.metrics.working_point`); each labelled car,
        nearest first: metres ahead, whether it is to be found at the moderate level, the score of
        the detection that means it in the image, how far off that is in depth, and the largest
        overlap from above, also of detections that are not sure enough; and the surest detections.
    """
    is_car = truth.category == CATEGORY
    errors = car_errors([truth], [found], [is_car])
    columns = {
        "ahead": errors.distance,
        "to_find": wanted_cars([truth])[0][is_car],
        "score": errors.score,
        "depth_error": errors.values["depth"],
        "overlap": errors.overlap,
    }
    cars = [
        {name: _plain(column[i]) for name, column in columns.items()}
        for i in np.argsort(errors.distance)
    ]
    surest = found[np.argsort(-found.score, kind="stable")[:_SUREST]]
    return {
        **_total([truth], [found], least_score),
        "cars": cars,
        "surest": _described(truth, surest),
    }


def _total(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], least_score: float
) -> dict[str, Any]:
    real = [above(boxes, least_score) for boxes in found]
    meant = sum(
        int(np.isin(np.flatnonzero(wanted), paired(labels, boxes).label).sum())
        for labels, boxes, wanted in zip(truth, real, wanted_cars(truth), strict=True)
    )
    counts = counted(truth, real)
    return {"to_find": counts.found + counts.missed, "seen_in_image": meant, **counts._asdict()}


def _described(truth: Boxes3D, found: Boxes3D) -> list[dict[str, Any]]:
    """Detections one by one, with the category of the label that each means."""
    pairs = paired(truth, found)
    meant = dict(zip(pairs.detection.tolist(), truth.category[pairs.label].tolist(), strict=True))
    overlap = np.zeros(len(found))
    is_car = truth.category == CATEGORY
    if len(found) and is_car.any():
        overlap = rectangle_iou(footprints(found), footprints(truth[is_car])).max(axis=1)
    return [
        {
            "score": _plain(found.score[i]),
            "right": _plain(found.location[i, 0]),
            "ahead": _plain(found.location[i, 2]),
            "means": meant.get(i),
            "is_right": bool(overlap[i] > MIN_IOU),
        }
        for i in range(len(found))
    ]


def _plain(value: np.generic) -> Any:
    """For JSON: None for NaN."""
    if isinstance(value, np.bool_):
        return bool(value)
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
    parser.add_argument("--detectors", nargs="+", default=["dsgn", "stereo_rcnn"])
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
