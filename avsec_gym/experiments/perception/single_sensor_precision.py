"""How precise the detectors of one sensor are on held-out frames: those that chapter 3 compares.

Run ``python -m avsec_gym.experiments.perception.single_sensor_precision --kitti DIR --json FILE``,
on frames with scans.  A detector is a name, or ``name=FILE`` with weights of one's own.  A run that
was stopped goes on: what was detected is kept in ``--out``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.answer import answer
from avsec_gym.experiments.perception.detection_errors import CATEGORY
from avsec_gym.experiments.perception.kept_detections import (
    add_options,
    described,
    detected,
    labelled_frames,
    seconds_a_frame,
)
from avsec_gym.experiments.perception.weights_facts import weights_facts
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.weights.given import shipped_weights

IOUS = (0.7, 0.5)
CAMERA = 2
NEEDED = ("label_2", "calib", "image_2", "velodyne")
"""Folders in which a frame has a file."""
_MAKE = "avsec world make --suite mixed --frames 200 --seed 2 --out DIR"


class Network(NamedTuple):
    """What a detector looks at, and what it says that can be scored."""

    sensor: str
    metrics: tuple[str, ...]


NETWORKS = {
    "pixor": Network("LiDAR", ("bev",)),
    "pointrcnn": Network("LiDAR", ("bev", "3d")),
    "faster_rcnn": Network(f"camera {CAMERA}", ("2d",)),
    "yolo": Network(f"camera {CAMERA}", ("2d",)),
}
"""PIXOR tells no height, and a single image no place in space."""


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Detect and score.

    Raises:
        ConfigurationError: A detector is none of `NETWORKS`, or an option makes no sense.
        DataError: The folder has no frames, a file is broken, or there are no weights.
    """
    data, ids, truth = labelled_frames(options, NEEDED, _MAKE)
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
        precision = {}
        for iou in IOUS:
            every = average_precision(
                truth,
                found,
                classes=(CATEGORY,),
                min_iou={CATEGORY: (iou, iou, iou)},
                resamples=options.resamples,
                seed=options.seed,
            ).to_json()[CATEGORY]
            precision[str(iou)] = {metric: every[metric] for metric in network.metrics}
        result[name] = {
            "sensor": network.sensor,
            "weights": weights_facts(weights),
            "average_precision": precision,
            "seconds": seconds_a_frame(what, data, ids[: options.timed]),
        }
    return {"data": described(data, truth), "resamples": options.resamples, "detectors": result}


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    parser.add_argument("--detectors", nargs="+", default=list(NETWORKS))
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
