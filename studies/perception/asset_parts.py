"""Do designs that no network has learned from cost precision?  Scenes of two parts of the assets.

An interval over scenes holds for other scenes of the same part: however many there are, it knows
nothing of other designs.  What the designs cost is the difference of two parts, which has an
interval of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import METRICS, MinIou, average_precision
from avsec_gym.metrics.cluster_bootstrap import Sampled, difference_of_parts
from avsec_gym.metrics.estimate import Estimate
from studies.perception.detection_errors import CATEGORY, LEVEL
from studies.perception.kept_detections import LabelledData


@dataclass(frozen=True, eq=False)
class SeenScenes:
    """Scenes of one part of the assets, and what a detector finds in them.

    Args:
        data: Which they are.
        truth: The labels of each, DontCare regions included.
        found: The detections in each.
    """

    data: LabelledData
    truth: Sequence[Boxes3D]
    found: Sequence[Boxes3D]


@dataclass(frozen=True)
class PartsPrecision:
    """Average precision of cars on two parts, in space, moderate, 11 recall points, percent.

    Args:
        judged: The precision on the judged scenes, with the interval over these.
        other: The precision on the scenes of the other part, with the interval over those.
        difference: The first less the second, with an interval over the scenes of both.
        paired: Whether both parts have the same layouts, each of which is then drawn in both.
    """

    judged: Estimate
    other: Estimate
    difference: Estimate
    paired: bool


def parts_precision(
    judged: SeenScenes, other: SeenScenes, iou: MinIou, resamples: int, seed: int
) -> PartsPrecision:
    """Precision on two parts of the assets, and by how much they differ.

    Args:
        judged: Scenes of the part that is judged on.
        other: Scenes of the other part, such as the one that networks learn from.
        iou: What a match needs.
        resamples: Scenes are drawn anew so many times for 95 % intervals; 0: none.
        seed: The seed of these draws.
    """
    here, there = (_precision(each, iou, resamples, seed) for each in (judged, other))
    paired = _same_layouts(judged.data, other.data)
    difference = here - there if paired else difference_of_parts(here, there, seed=seed)
    return PartsPrecision(here.estimate, there.estimate, difference.estimate, paired)


def _precision(scenes: SeenScenes, iou: MinIou, resamples: int, seed: int) -> Sampled:
    result = average_precision(
        scenes.truth, scenes.found, classes=(CATEGORY,), min_iou=iou, resamples=resamples, seed=seed
    )
    place = (0, METRICS.index("3d"), LEVEL)
    samples = np.zeros(0) if result.drawn is None else result.drawn[place][:, 0]
    return Sampled(float(result.ap11[place]), samples)


def _same_layouts(one: LabelledData, other: LabelledData) -> bool:
    """A suite and a seed draw layouts, whatever the assets are."""
    known = one.suite is not None and one.seed is not None
    same = (one.suite, one.seed, one.frames) == (other.suite, other.seed, other.frames)
    return known and same
