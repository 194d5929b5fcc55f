"""Does a stereo detector see as much by another pair of the rig's cameras?

Where a camera of its pair is attacked, the response ``drop`` gives a detector another pair, whose
baseline is another one. Run ``python -m studies.chapter3.other_pairs`` to
count the cars that it finds by each pair, in frames without an attack.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.defence.defended_episodes import DRIVE_FRAMES
from avsec_gym.experiments.chapter3.defence.scenes import scene_of
from avsec_gym.experiments.chapter3.recordings import JUDGED, recordings_of
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.geometry import Floats
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.perception.detectors import Detector, make_detector
from avsec_gym.runs.experiment import Configuration
from avsec_gym.validation.compromised_sensors import as_stereo_pair, stereo_pairs
from avsec_gym.validation.recordings import Recordings, drive_of
from studies.answer import answer

_LOG = logging.getLogger(__name__)
_NEAREST, _FARTHEST = 5.0, 40.0
"""Metres ahead; of cars that count."""
_SAME_BEARING = np.radians(2.0)


@dataclass(frozen=True)
class DistanceRatio:
    """Distance of boxes over the true one: median, 10th and 90th percentile; None without a box."""

    median: float | None
    low: float | None = field(metadata=keyed("from"))
    high: float | None = field(metadata=keyed("to"))


@dataclass(frozen=True)
class PairRow:
    """What a detector finds by a pair of cameras.

    Args:
        left: Number of the left camera.
        right: Number of the right camera.
        baseline: Baseline over that of cameras 2 and 3.
        found: Share of the cars 5 to 40 m ahead in whose direction it has a box; its interval
            allows for cars of one drive being alike.
        distance: Distance of these boxes.
    """

    left: int
    right: int
    baseline: float
    found: Share
    distance: DistanceRatio


@dataclass(frozen=True)
class OtherPairs:
    """The study: what was judged, and a row for each pair."""

    detector: str
    seed: int
    frames: int
    score_threshold: float
    pairs: Sequence[PairRow]


def run(options: argparse.Namespace) -> OtherPairs:
    """Count by every pair.

    Raises:
        ConfigurationError: No such detector.
        DataError: The detector's weights are missing or broken.
    """
    detector = make_detector({"name": options.detector})
    configuration = Configuration(PROCEDURAL, options.limit, options.seed)
    recordings = recordings_of(configuration, JUDGED, DRIVE_FRAMES)
    return OtherPairs(
        detector=options.detector,
        seed=options.seed,
        frames=len(recordings.frames),
        score_threshold=options.score_threshold,
        pairs=found_by_pairs(recordings, detector, options.score_threshold),
    )


def found_by_pairs(
    recordings: Recordings, detector: Detector, score_threshold: float
) -> list[PairRow]:
    """A row for each pair, that of the baseline most like the usual one first.

    Args:
        recordings: Recordings of labelled drives.
        detector: A detector of images.
        score_threshold: The least score of boxes that count.
    """
    calibration = recordings.frames[0].frame().calibration
    pairs = stereo_pairs(calibration, recordings.system.cameras)
    drives: list[str] = []
    seen = {pair: [np.empty(0)] for pair in pairs}
    start, count = time.perf_counter(), len(recordings.frames)
    for number, recorded in enumerate(recordings.frames):
        frame = recorded.frame()
        true = cars_ahead(scene_of(frame, recorded.id, number).boxes)
        drives += [drive_of(recorded.id)] * len(true)
        for pair in pairs:
            found = above(detector.detect(as_stereo_pair(frame, *pair)), score_threshold)
            seen[pair].append(distances(true, found))
        if number % 20 == 19:
            left = (time.perf_counter() - start) * (count / (number + 1) - 1)
            _LOG.info("%d of %d frames, about %.0f s left", number + 1, count, left)
    rows = []
    for pair, baseline in pairs.items():
        ratios = np.concatenate(seen[pair])
        share = share_of(~np.isnan(ratios), drives)
        rows.append(PairRow(*pair, round(baseline, 3), share, _distance(ratios)))
    return rows


def _distance(ratios: Floats) -> DistanceRatio:
    """Of all cars of a pair, see `distances`."""
    known = ratios[~np.isnan(ratios)]
    low, middle, high = np.percentile(known, (10, 50, 90)).tolist() if len(known) else [None] * 3
    return DistanceRatio(middle, low, high)


def cars_ahead(boxes: Boxes3D) -> Boxes3D:
    """Cars that a pair should find."""
    away = boxes.location[:, 2]
    return boxes[(boxes.category == "Car") & (away > _NEAREST) & (away < _FARTHEST)]


def distances(cars: Boxes3D, found: Boxes3D) -> Floats:
    """The distance of each car's box in its direction over its own; NaN without one.

    Args:
        cars: The cars as they are, N.
        found: The cars found by a detector.

    Returns:
        Shape (N,).
    """
    ratios = np.full(len(cars), np.nan)
    if not len(cars) or not len(found):
        return ratios
    bearings = [np.arctan2(boxes.location[:, 0], boxes.location[:, 2]) for boxes in (cars, found)]
    apart = np.abs(bearings[0][:, None] - bearings[1][None, :])
    same = apart < _SAME_BEARING
    # A box finds one car; no pair is worth losing another one.
    for car, box in zip(*linear_sum_assignment(np.where(same, apart, 10.0)), strict=True):
        if same[car, box]:
            ratios[car] = found.location[box, 2] / cars.location[car, 2]
    return ratios


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--detector", default="stereo_rcnn", help="one of images; its name")
    parser.add_argument("--limit", type=int, default=120, help="frames")
    parser.add_argument("--seed", type=int, default=0, help="of the drives")
    parser.add_argument("--score-threshold", type=float, default=0.3, help="of boxes that count")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
