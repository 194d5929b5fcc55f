"""How many objects of two sensors have no partner, in every frame of a run."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.object_mismatches import mismatches
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    WIDTH,
    reach_name,
    seen_setting,
    view_setting,
)
from avsec_gym.experiments.chapter3.recordings import FITTED, SYSTEM
from avsec_gym.geometry import Floats
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.evidence.disparity_maps import Pair

IOUS = (0.5, 0.7)
"""Overlaps; partners have more in common than one of these."""


def mismatch_counts(
    results: Results, part: str, thresholds: Mapping[str, ScoreThreshold]
) -> tuple[Floats, list[str]]:
    """What `SensorDetections` stored, counted.

    Args:
        results: The results of a run.
        part: `FITTED`, whose frames are without an attack, or `JUDGED`.
        thresholds: The least score of a counted box by detector, see `score_thresholds`.

    Returns:
        Shape (N, pairs, IoUs, 2, 2), NaN for states that lack: the pairs are those of the system,
        the last axes whether its first and its second sensor is attacked; and the frames' ids.
    """
    views: dict[str, dict[str, float]] = {}
    for view in results.measurements(setting=view_setting(part)):
        views.setdefault(view.scenario, {})[view.name] = view.value
    frames, pairs = sorted(views), SYSTEM.pairs()
    counts = np.full((len(frames), len(pairs), len(IOUS), 2, 2), np.nan)
    attacked = (False,) if part == FITTED else (False, True)
    for column, pair in enumerate(pairs):
        # The reference is the left one of two cameras.
        right, left = (
            [_objects(results, part, pair, place, state, thresholds) for state in attacked]
            for place in (0, 1)
        )
        for (row, id), i, k in product(enumerate(frames), map(int, attacked), map(int, attacked)):
            reach, width = views[id].get(reach_name(pair), 0.0), views[id][WIDTH]
            counts[row, column, :, i, k] = [
                mismatches(left[k][id], right[i][id], iou, reach, width) for iou in IOUS
            ]
    return counts, frames


def _objects(
    results: Results,
    part: str,
    pair: Pair,
    place: int,
    is_attacked: bool,
    thresholds: Mapping[str, ScoreThreshold],
) -> dict[str, Boxes3D]:
    """Of the first or the second sensor of a pair, in the image that they are compared in."""
    sensor = SYSTEM.sensors[pair[place]]
    camera = int(SYSTEM.sensors[pair[1]]) if sensor == LIDAR else int(sensor)
    least = thresholds["lidar" if sensor == LIDAR else "camera"].score
    found = results.detections(seen_setting(part, sensor, is_attacked, camera))
    return {id: boxes[boxes.score >= least] for id, boxes in found.items()}
