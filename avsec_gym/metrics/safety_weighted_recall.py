"""Recall in which an object counts by what it would cost to miss it, instead of once.

Average precision counts a car that no way leads near as much as the one that the car is about to
hit.  Here every object of a frame has a weight with each driving intention, and the recall is the
share of the weight that is found.  What the weights are is a choice:

- `contact_weights`, the default, weighs by the time until the car would be near the object.  It
  needs no planner, and holds for any.
- A rule of one's own may ask a planner, and holds for that one: `contested_objects` in
  studies/chapter5/measures gives 1 to objects of which missing one alone makes the drive unsafe, 0
  to all others.

Limits, whatever the weights: a recall knows nothing of ghosts, which is what patches add, and
nothing of where a found box stands.  Whether it predicts driving safety better than average
precision does is a question for measurements: studies/results/telling_measures.md has those of this
project.

Source: the weighting by distance and time to collision is after Ceccarelli and Montecchi,
"Evaluating Object (Mis)Detection From a Safety and Reliability Perspective: Discussion and
Measures", IEEE Access 2023; `avsec_gym.metrics.contact_recall` states how it departs from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.image_only import is_image_only
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap
from avsec_gym.metrics.contact_recall import HORIZON, MARGIN, contact_weights
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.ghosts import meant
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario, is_obstacle
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.intention import Intention

Weigh = Callable[[Boxes3D, Intention], Floats]
"""The weights of N real objects with an intention, 0 or more, shape (N,)."""


@dataclass(frozen=True)
class SafetyWeightedRecall:
    """The share of the weight of real objects that is found.

    Args:
        recall: The recall over all frames and intentions, from 0 to 1; None where no object weighs
            anything.
        by_intention: The recall of each driving intention alone.
        frames: Number of frames.
        weighed: Number of objects that weigh something, counted once for each intention.
        threshold: The least score of a detection that counts.
    """

    recall: Estimate
    by_intention: Mapping[str, float | None]
    frames: int
    weighed: int
    threshold: float

    def to_json(self) -> dict[str, object]:
        """All of it, the interval beside the recall."""
        return {
            **self.recall.columns("recall"),
            "by_intention": dict(self.by_intention),
            "frames": self.frames,
            "weighed": self.weighed,
            "threshold": self.threshold,
        }


def safety_weighted_recall(
    truth: Sequence[Boxes3D],
    detections: Sequence[Boxes3D],
    *,
    threshold: float = 0.3,
    weigh: Weigh | None = None,
    category: str | None = None,
    resamples: int = 0,
    seed: int = 0,
) -> SafetyWeightedRecall:
    """How much of what a car must not miss is found, over many frames.

    Args:
        truth: The labels of each frame; obstacles count (`is_obstacle`), others do not.
        detections: The detections of each frame, in the same order; obstacles of any class count.
        threshold: The least score of a detection that counts.
        weigh: The weights of a frame's real objects; None: by the time to contact, on a street,
            all objects standing.
        category: The class of real objects that count; None: all obstacles.
        resamples: Frames are drawn so many times for a 95 % bootstrap interval, each with all its
            intentions; 0: there is none.
        seed: Seed of these draws.

    Raises:
        ValueError: There are more frames of one than of the other.

    Example:
        >>> near_and_far = Boxes3D(
        ...     [[0, 1.65, 12.0], [0, 1.65, 45.0]], [[1.5, 1.6, 4.0]] * 2, [-1.57] * 2, [0.9] * 2,
        ...     ["Car"] * 2,
        ... )
        >>> [
        ...     safety_weighted_recall([near_and_far], [near_and_far[[n]]]).recall.value
        ...     for n in (0, 1)
        ... ]
        [1.0, 0.0]
    """
    weigh = time_to_contact if weigh is None else weigh
    # Of each frame and intention: the weight that is found, and the weight of all.
    sums = np.zeros((len(truth), len(Intention), 2))
    weighed = 0
    for number, (labels, seen) in enumerate(zip(truth, detections, strict=True)):
        real = _obstacles(labels)
        if category is not None:
            real = real[real.category == category]
        if not len(real):
            continue
        # Which real objects a detection stands for.
        believed = _obstacles(seen)
        found = meant(real, believed[believed.score >= threshold])
        for column, intention in enumerate(Intention):
            weights = weigh(real, intention)
            weighed += int((weights > 0).sum())
            sums[number, column] = weights[found].sum(), weights.sum()
    # Their quotients, over all intentions with an interval, and by intention.
    total = sums.sum(axis=1)
    return SafetyWeightedRecall(
        _share(total, resamples, seed),
        {
            str(intention): _share(sums[:, column], 0, 0).value
            for column, intention in enumerate(Intention)
        },
        len(truth),
        weighed,
        threshold,
    )


def time_to_contact(
    objects: Boxes3D, intention: Intention, road_type: RoadType = RoadType.STREET
) -> Floats:
    """The weights of standing objects by the time until the car would be near them.

    Args:
        objects: N obstacles in the camera frame.
        intention: The driving intention.
        road_type: The type of the road, which gives the car its speed.

    Returns:
        See `contact_weights`, shape (N,).
    """
    # Most objects are farther away than the car drives: as discs around the middles of both.
    reach = HORIZON * driving_constraints(road_type).start_speed + MARGIN
    radii = [0.5 * np.hypot(each.length, each.width) for each in (BMW_320I, objects)]
    near = np.hypot(*objects.poses[:, :2].T) <= reach + radii[0] + radii[1]
    weights = np.zeros(len(objects))
    if near.any():
        problem = build_planning_scenario(objects[near], road_type=road_type, intention=intention)
        weights[near] = contact_weights(problem)
    return weights


def _obstacles(boxes: Boxes3D) -> Boxes3D:
    """Those of a class that becomes an obstacle, which have a place in space."""
    kept: NDArray[np.bool_] = is_obstacle(boxes) & ~is_image_only(boxes)
    return boxes[kept]


def _share(sums: Floats, resamples: int, seed: int) -> Estimate:
    """Found of all weight, shape (F, 2) by frame, with its interval."""
    found, there = sums.T
    if not resamples:
        return Estimate(float(found.sum() / there.sum()) if there.any() else None)
    return ClusterBootstrap(len(sums), resamples, seed).ratio(found, there).estimate
