"""How precise the detectors of one sensor are on held-out frames: those that chapter 3 compares.

Run ``python -m studies.perception.single_sensor_precision --kitti DIR --json FILE``,
on frames with scans.  A detector is a name, or ``name=FILE`` with weights of one's own.  A run that
was stopped goes on: what was detected is kept in ``--out``.  ``--real ROOT`` counts, too, what each
finds in real frames of KITTI.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.working_point import (
    FROM_ABOVE,
    IN_IMAGE,
    Counts,
    WorkingPoint,
    counted,
    working_point,
)
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.pipeline import Pipeline
from studies.answer import answer
from studies.perception.detection_errors import CATEGORY
from studies.perception.detector_scores import Precision, precision
from studies.perception.kept_detections import (
    FrameTime,
    LabelledData,
    add_options,
    check_judging_assets,
    described,
    detected,
    labelled_frames,
    seconds_a_frame,
)
from studies.perception.weights_facts import WeightsFacts, weights_facts

IOUS = (0.7, 0.5)
CAMERA = 2
NEEDED = ("label_2", "calib", "image_2", "velodyne")
"""Folders in which a frame has a file."""
_MAKE = "avsec world make --suite mixed --frames 200 --assets judge --out DIR"


class ScoredNetwork(NamedTuple):
    """What a detector looks at, and what it reports that can be scored."""

    sensor: str
    folder: str
    metrics: tuple[str, ...]

    @property
    def seen(self) -> int:
        """Where its boxes are counted."""
        return IN_IMAGE if "2d" in self.metrics else FROM_ABOVE


NETWORKS = {
    "pixor": ScoredNetwork("LiDAR", "velodyne", ("bev",)),
    "pointrcnn": ScoredNetwork("LiDAR", "velodyne", ("bev", "3d")),
    "faster_rcnn": ScoredNetwork(f"camera {CAMERA}", f"image_{CAMERA}", ("2d",)),
    "yolo": ScoredNetwork(f"camera {CAMERA}", f"image_{CAMERA}", ("2d",)),
}
"""PIXOR finds no height, and a single image no place in space."""
DRIVING_SCORE = Pipeline.score_threshold
"""The least score of boxes that a car plans with, unless another is given."""


@dataclass(frozen=True)
class RealFrames:
    """Cars of real frames, found from the working point's score on, and as cars are driven."""

    frames: list[str]
    counts: Counts = field(metadata=FLAT)
    driving: Counts | None = field(default=None, metadata=OPTIONAL)
    """Counts from `DRIVING_SCORE` on, which hangs on no other frames."""


@dataclass(frozen=True)
class ScoredSensor:
    """A detector of one sensor, and its scores in what the sensor shows."""

    sensor: str
    weights: WeightsFacts | None
    average_precision: Mapping[str, Precision]
    """Average precision by `IOUS`."""
    working_point: WorkingPoint | None
    seconds: FrameTime
    real: RealFrames | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class SingleSensorPrecision:
    """The result."""

    data: LabelledData
    resamples: int
    detectors: Mapping[str, ScoredSensor]


def run(options: argparse.Namespace) -> SingleSensorPrecision:
    """Detect and score.

    Raises:
        ConfigurationError: A detector is none of `NETWORKS`, an option makes no sense, or frames
            are not of judging assets.
        DataError: The folder has no frames, a file is broken, or there are no weights.
    """
    data, ids, truth = labelled_frames(options, NEEDED, _MAKE)
    frames = described(data, truth)
    check_judging_assets(frames, options)
    result = {}
    for text in options.detectors:
        name, _, file = text.partition("=")
        if name not in NETWORKS:
            raise ConfigurationError(f"{name!r} is none of {', '.join(NETWORKS)}")
        network, weights = NETWORKS[name], Path(file) if file else shipped_weights(f"{name}_small")
        what: dict[str, Any] = {"name": name, "weights": str(weights)}
        if "2d" in network.metrics:
            what = {"name": "single_image", "detector": what, "camera": CAMERA}
        found = detected(what, weights, data, ids, options.out, options.workers)
        scores = {}
        for iou in IOUS:
            least = {CATEGORY: (iou, iou, iou)}
            every = precision(truth, found, least, options.resamples, options.seed)
            scores[str(iou)] = {metric: every[metric] for metric in network.metrics}
        point = working_point(truth, found, network.seen)
        result[name] = ScoredSensor(
            sensor=network.sensor,
            weights=weights_facts(weights),
            average_precision=scores,
            working_point=point,
            seconds=seconds_a_frame(what, data, ids[: options.timed]),
            real=in_real_frames(options.real, network, what, point.score)
            if options.real is not None and point is not None
            else None,
        )
    return SingleSensorPrecision(frames, options.resamples, result)


def in_real_frames(
    root: Path, network: ScoredNetwork, what: dict[str, Any], least_score: float
) -> RealFrames:
    """Moderate cars found and missed, and false alarms, in all labelled frames with the sensor.

    Args:
        root: The folder of the object benchmark.
        network: The network whose sensor it is.
        what: What `make_detector` takes.
        least_score: The least score of boxes that count.

    Raises:
        DataError: There is no such frame, or a file is broken.
    """
    data, detector = KittiObject(root), make_detector(what)
    ids = data.ids(having=("label_2", "calib", network.folder))
    if not ids:
        raise DataError(f"No frame has labels, calib and {network.folder}.", path=root)
    truth = [data.labels(id, keep_dont_care=True) for id in ids]
    found = [detector.detect(data.frame(id)) for id in ids]
    counts, driving = (
        counted(truth, [above(boxes, least) for boxes in found], network.seen)
        for least in (least_score, DRIVING_SCORE)
    )
    return RealFrames(ids, counts, driving)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    parser.add_argument("--detectors", nargs="+", default=list(NETWORKS))
    parser.add_argument("--real", type=Path, help="root of the object benchmark")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
