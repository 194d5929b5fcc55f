"""Fit an error model to what a detector found in frames whose objects are known."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize
from scipy.special import log_expit
from scipy.stats import norm
from scipy.stats import t as student

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.matching import Matches, errors_of, match
from avsec_gym.closed_loop.error_model.model import (
    COMPONENTS,
    FARTHEST,
    TERMS,
    ErrorModel,
    Ghosts,
    Spread,
    terms,
)
from avsec_gym.closed_loop.error_model.object_views import ObjectViews, object_views
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.builder import is_obstacle

_PRIOR = 3.0
"""Standard deviation of weights and growths before any data."""
_MOST_GHOSTS = 500
_ASSUMED_SECONDS = 0.5
"""How long errors last where no data follow one another in time."""


@dataclass(frozen=True, eq=False)
class DetectedFrame:
    """A frame whose objects are known, and what a detector found in it.

    Args:
        objects: Labels, in the camera frame; regions not to care about among them.
        detections: Detections that a planner would plan on.
        drive: Name of the drive that the frame is of; frames of their own have drives of their own.
        time: Seconds within the drive.
        actors: Id of each object, the same over the drive, shape (N,); None: not known.
        vehicle: Name of the vehicle that sees it; several may take part in one drive.
    """

    objects: Boxes3D
    detections: Boxes3D
    drive: str
    time: float = 0.0
    actors: NDArray[np.int64] | None = None
    vehicle: str = ""


@dataclass(frozen=True, eq=False)
class Compared:
    """A frame's obstacles in view, and what became of them.

    Args:
        frame: The frame.
        objects: Obstacles that can be seen, shape (N,).
        actors: Id of each obstacle, shape (N,); None: not known.
        views: How the camera sees them.
        matches: Assignment of detections to objects.
        detections: Detections that are judged.
    """

    frame: DetectedFrame
    objects: Boxes3D
    actors: NDArray[np.int64] | None
    views: ObjectViews
    matches: Matches
    detections: Boxes3D

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each obstacle was detected, shape (N,)."""
        return np.isin(np.arange(len(self.objects)), self.matches.objects)


def compared(frame: DetectedFrame) -> Compared:
    """Match a frame's detections with its obstacles."""
    obstacles = np.flatnonzero(is_obstacle(frame.objects))
    views = object_views(frame.objects[obstacles])
    visible = (views.outside < 1) & (views.distance <= FARTHEST)
    objects = frame.objects[obstacles[visible]]
    ignored = frame.objects[frame.objects.category == "DontCare"]
    detections = frame.detections[~_in_regions(frame.detections, ignored)]
    detections = detections[np.hypot(*detections.poses[:, :2].T) <= FARTHEST]
    return Compared(
        frame,
        objects,
        None if frame.actors is None else frame.actors[obstacles[visible]],
        ObjectViews(*(getattr(views, name)[visible] for name in ObjectViews.__annotations__)),
        match(objects, detections),
        detections,
    )


def fit_error_model(frames: Sequence[DetectedFrame], card: Mapping[str, Any]) -> ErrorModel:
    """The error model under which what was found is likeliest.

    Args:
        frames: Frames of a detector, under one attack.
        card: JSON-able: what the frames and the detector are; counts are added.

    Raises:
        DataError: There are no frames, or none has an object.
    """
    every = [compared(frame) for frame in frames]
    if not any(len(each.objects) for each in every):
        raise DataError(
            f"No obstacle can be seen in {len(every)} frames.",
            remedy="Fit to frames with labelled cars within 60 m.",
        )
    # How likely an object is found, by its distance and how much of it is seen.
    found = _fit_found(every)
    # How far off what is found lies; turned round by half a turn counts apart.
    errors, distance = _errors(every)
    turn = errors["turn"]
    turned = np.abs(turn) > np.pi / 2
    errors["turn"] = np.where(turned, turn - np.sign(turn) * np.pi, turn)
    spreads = {name: _fit_spread(errors[name], distance) for name in COMPONENTS}
    # Ghosts: how many there are in a frame, and a sample of those that were seen.
    ghosts = [each.detections[each.matches.ghosts] for each in every]
    places = [
        (*pose, *size)
        for boxes in ghosts
        for pose, size in zip(boxes.poses.tolist(), boxes.dimensions.tolist(), strict=True)
    ]
    model = ErrorModel(
        found,
        spreads,
        float(turned.sum() / max(len(turned), 1)),
        Ghosts(len(places) / len(every), tuple(places[:: 1 + len(places) // _MOST_GHOSTS])),
    )
    # How long misses, errors and ghosts last, given all that.
    seconds = _memories(every, model)
    return ErrorModel(
        model.found,
        model.spreads,
        model.turned_round,
        Ghosts(model.ghosts.rate, model.ghosts.seen, seconds["ghosts"] or 0.1),
        seconds["found"] or _ASSUMED_SECONDS,
        seconds["errors"] or _ASSUMED_SECONDS,
        {
            **card,
            "frames": len(every),
            "drives": len({each.frame.drive for each in every}),
            "objects": int(sum(len(each.objects) for each in every)),
            "found": len(distance),
            "ghosts": len(places),
            "seconds_measured": {name: value is not None for name, value in seconds.items()},
        },
    )


def _in_regions(detections: Boxes3D, regions: Boxes3D) -> NDArray[np.bool_]:
    """Whether the middle of each detection lies in a region of the image without labels."""
    if detections.box2d is None or regions.box2d is None or not len(regions):
        return np.zeros(len(detections), bool)
    middle = (detections.box2d[:, :2] + detections.box2d[:, 2:]) / 2
    beyond = (middle[:, None] >= regions.box2d[:, :2]) & (middle[:, None] <= regions.box2d[:, 2:])
    inside: NDArray[np.bool_] = np.any(np.asarray(beyond, bool).all(axis=2), axis=1)
    return inside


def _fit_found(every: Sequence[Compared]) -> tuple[float, ...]:
    """Logistic regression with a normal prior, which keeps weights finite where all are found."""
    x = np.concatenate([terms(each.objects, each.views) for each in every])
    sign = np.where(np.concatenate([each.found for each in every]), 1.0, -1.0)

    def loss(weights: Floats) -> float:
        prior = 0.5 * float(((weights / _PRIOR) ** 2).sum())
        return prior - float(log_expit(sign * (x @ weights)).sum())

    return tuple(map(float, minimize(loss, np.zeros(len(TERMS)), method="BFGS").x))


def _errors(every: Sequence[Compared]) -> tuple[dict[str, Floats], Floats]:
    """Errors of all matched pairs by component, and the distances of their objects."""
    rows: dict[str, list[Floats]] = defaultdict(list)
    for each in every:
        pair = (each.matches.objects, each.matches.detections)
        for name, values in zip(COMPONENTS, errors_of(each.objects, each.detections), strict=False):
            rows[name].append(values[pair])
        true, found = each.objects[pair[0]], each.detections[pair[1]]
        rows["log_length"].append(np.log(found.length / true.length))
        rows["log_width"].append(np.log(found.width / true.width))
        rows["distance"].append(each.views.distance[pair[0]])
    columns = {name: np.concatenate(parts) for name, parts in rows.items()}
    distance = columns.pop("distance")
    return columns, distance


def _fit_spread(errors: Floats, distance: Floats) -> Spread:
    """The likeliest Student's t; a few errors are held near normal by a prior."""
    if len(errors) < 2:
        return Spread()
    middle = float(np.median(errors))
    width = max(float(np.median(np.abs(errors - middle))), 1e-4)

    def loss(parameters: Floats) -> float:
        bias, log_scale, growth, log_freedom = parameters
        scales = np.exp(log_scale + growth * distance / 20.0)
        freedom = 1.0 + math.exp(min(log_freedom, 4.0))
        likelihood = student.logpdf((errors - middle - width * bias) / scales, freedom)
        prior = (growth / _PRIOR) ** 2 + ((log_freedom - 1.5) / 1.5) ** 2 + (bias / 10) ** 2
        return 0.5 * prior - float((likelihood - np.log(scales)).sum())

    start = np.array([0.0, math.log(width), 0.0, 1.5])
    bias, log_scale, growth, log_freedom = minimize(loss, start, method="Nelder-Mead").x
    freedom = 1.0 + math.exp(min(log_freedom, 4.0))
    return Spread(middle + width * float(bias), math.exp(log_scale), float(growth), freedom)


def _memories(every: Sequence[Compared], model: ErrorModel) -> dict[str, float | None]:
    """Seconds after which each kind of error is forgotten; None where nothing follows another."""
    pairs = list(_successive(every))
    if not pairs:
        return {"found": None, "errors": None, "ghosts": None}
    step = float(np.median([after.frame.time - before.frame.time for before, after, *_ in pairs]))
    chance: list[tuple[float, float]] = []
    hits: list[tuple[bool, bool]] = []
    normal: list[tuple[float, float]] = []
    for before, after, first, second in pairs:
        both = ((before, first), (after, second))
        p = [model.probabilities(part.objects, part.views)[rows] for part, rows in both]
        f = [part.found[rows] for part, rows in both]
        chance += zip(p[0].tolist(), p[1].tolist(), strict=True)
        hits += zip(f[0].tolist(), f[1].tolist(), strict=True)
        scores = [_normal_scores(part, model)[rows] for part, rows in both]
        known = np.isfinite(scores[0]) & np.isfinite(scores[1])
        normal += zip(scores[0][known].tolist(), scores[1][known].tolist(), strict=True)
    z = np.array(normal)
    error = float(np.mean(z[:, 0] * z[:, 1]) / np.mean(z**2)) if len(z) > 10 else None
    return {
        "found": _seconds(_hit_correlation(np.array(chance), np.array(hits)), step),
        "errors": None if error is None else _seconds(error, step),
        "ghosts": _ghost_seconds(pairs, step),
    }


def _successive(
    every: Sequence[Compared],
) -> list[tuple[Compared, Compared, NDArray[np.int64], NDArray[np.int64]]]:
    """Frames that follow one another, with the rows of the obstacles that are in both."""
    seen: dict[tuple[str, str], list[tuple[Compared, NDArray[np.int64]]]] = defaultdict(list)
    for each in every:
        if each.actors is not None:
            seen[each.frame.drive, each.frame.vehicle].append((each, each.actors))
    result = []
    for drive in seen.values():
        drive.sort(key=lambda each: each[0].frame.time)
        for (before, earlier), (after, later) in pairwise(drive):
            _, first, second = np.intersect1d(
                earlier, later, assume_unique=True, return_indices=True
            )
            result.append((before, after, first, second))
    return result


def _normal_scores(each: Compared, model: ErrorModel) -> Floats:
    """Radial errors as standard normal numbers, NaN where an object was missed; shape (N,)."""
    scores = np.full(len(each.objects), np.nan)
    pair = (each.matches.objects, each.matches.detections)
    radial = errors_of(each.objects, each.detections)[0][pair]
    shares = model.spreads["radial"].shares(radial, each.views.distance[pair[0]])
    scores[pair[0]] = norm.ppf(np.clip(shares, 1e-4, 1 - 1e-4))
    return scores


def _hit_correlation(chance: Floats, hits: NDArray[np.bool_]) -> float:
    """The correlation of the copula under which as often both are found, or both missed.

    Args:
        chance: Probabilities of a detection, now and next, shape (P, 2).
        hits: Whether it was detected, now and next, shape (P, 2).
    """
    if not len(chance):
        return 0.0
    seen = float(np.prod(hits - chance, axis=1).sum())
    limits = norm.ppf(np.clip(chance, 1e-6, 1 - 1e-6))
    x, weights = np.polynomial.hermite_e.hermegauss(64)
    weights = weights / weights.sum()

    def excess(correlation: float) -> float:
        # P(u < a, v < b) = E[P(u < a | w) P(v < b | w)], both correlated with w by the root.
        root, rest = math.sqrt(correlation), math.sqrt(1 - correlation)
        given = norm.cdf((limits[:, :, None] - root * x) / rest)
        return float((np.prod(given, axis=1) @ weights - np.prod(chance, axis=1)).sum()) - seen

    low, high = 0.0, 0.999
    if excess(low) >= 0:
        return low
    return high if excess(high) <= 0 else float(brentq(excess, low, high, xtol=1e-4))


def _ghost_seconds(pairs: Sequence[tuple[Any, ...]], step: float) -> float | None:
    """From how many ghosts have another one within 2 m, seen from the car, a frame later."""
    stayed = count = 0
    for before, after, *_ in pairs:
        now, then = (part.detections[part.matches.ghosts].poses[:, :2] for part in (before, after))
        count += len(now)
        if len(now) and len(then):
            stayed += int((np.hypot(*(now[:, None] - then).T).min(axis=0) < 2.0).sum())
    return _seconds(stayed / count, step) if count else None


def _seconds(correlation: float, step: float) -> float:
    """The time in which a correlation from step to step falls to 1/e; within 0.05 and 30 s."""
    if correlation <= 0:
        return 0.05
    return float(np.clip(-step / math.log(min(correlation, 0.9999)), 0.05, 30.0))
