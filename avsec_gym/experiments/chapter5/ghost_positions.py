"""Where ghosts appear: on the road, or in its side area (thesis, section 5.5.1).

The thesis sees "almost all" ghosts beside the road.  Since there is more to see beside a road than
on it, their share is compared here with chance.  Frames are drawn together in the
intervals, for ghosts of one frame depend on each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.side_area import RoadView
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats, project
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap, Sampled
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.ghosts import ghosts

LANE_WIDTH = 3.5
CORRIDOR = 1.5 * LANE_WIDTH
"""Metres on either side within which the three intentions of the thesis drive."""
FARTHEST = 40.0
"""Metres ahead up to which ghosts and ground count; detectors look little further."""
_CELL = 0.5
"""Metres; side of the squares by which visible ground is measured."""
_NAMES = ("share_on_road", "chance", "ratio", "share_in_lanes")
"""Figures of `GhostSummary` that have intervals."""


class GhostPlace(StrEnum):
    """Where a ghost stands."""

    ROAD = "road"
    SIDE = "side"
    UNKNOWN = "unknown"
    """Outside of the image, or something that is neither road nor side area hides its foot."""


@dataclass(frozen=True)
class GhostCount:
    """Ghosts of one frame, and where they could have been.

    Args:
        road: Ghosts on the road.
        side: Ghosts beside it.
        unknown: Ghosts whose place the image does not show.
        in_lanes: Ghosts of `road` that reach into the lanes that are driven on.
        road_area: Visible ground of the road, m2.
        side_area: Visible ground beside it, m2.
    """

    road: int
    side: int
    unknown: int
    in_lanes: int
    road_area: float
    side_area: float


def in_corridor(
    boxes: Boxes3D, half_width: float = CORRIDOR, middle: float = 0.0
) -> NDArray[np.bool_]:
    """Whether footprints reach into the lanes that are driven on straight ahead, shape (N,).

    Args:
        boxes: The boxes in the camera frame.
        half_width: Half the width of the corridor, metres.
        middle: Metres to the left of the camera at which the corridor's middle lies.
    """
    poses = boxes.poses
    sideways = (
        np.abs(np.sin(poses[:, 2])) * boxes.length + np.abs(np.cos(poses[:, 2])) * boxes.width
    )
    return np.asarray(np.abs(poses[:, 1] - middle) - sideways / 2 < half_width)


def places(boxes: Boxes3D, view: RoadView, calibration: Calibration) -> list[GhostPlace]:
    """Where the middles of boxes' feet stand, by what the left image shows there.

    Args:
        boxes: The boxes in the camera frame.
        view: Road and side area of the left image.  With what stands beside the road in the side
            area (`EVERYTHING`), a foot hidden by it counts as beside the road.
        calibration: The calibration of the frame.
    """
    pixels, depth = project(calibration.projection(), boxes.location)
    height, width = view.road.shape
    result = []
    for (u, v), far in zip(np.rint(np.clip(pixels, -1e6, 1e6)).astype(int), depth, strict=True):
        if not (far > 0 and 0 <= u < width and 0 <= v < height):
            result.append(GhostPlace.UNKNOWN)
        elif view.road[v, u]:
            result.append(GhostPlace.ROAD)
        else:
            result.append(GhostPlace.SIDE if view.side[v, u] else GhostPlace.UNKNOWN)
    return result


def visible_areas(
    view: RoadView, calibration: Calibration, *, farthest: float = FARTHEST, highest: float = 0.5
) -> tuple[float, float]:
    """Visible ground of road and side area, m2: chance spreads ghosts evenly over it.

    Squares of 0.5 m count that at least one pixel shows; what stands on the ground does not.

    Args:
        view: Road and side area of the left image.
        calibration: The calibration of the frame.
        farthest: Metres ahead up to which ground counts.
        highest: Metres above the plane of the road up to which something is ground.
    """
    p = calibration.projection()
    rows, columns = np.nonzero((view.road | view.side) & (view.disparity > 0))
    depth = (
        calibration.focal_length()
        * calibration.baseline()
        / view.disparity[rows, columns].astype(float)
    )
    near = depth < farthest
    rows, columns, depth = rows[near], columns[near], depth[near]
    x, y = (columns - p[0, 2]) * depth / p[0, 0], (rows - p[1, 2]) * depth / p[1, 1]
    on_road = view.road[rows, columns]
    if not on_road.any():
        return 0.0, _area(x, depth)
    columns_of_plane = np.column_stack([np.ones_like(x), x, depth])
    plane, *_ = np.linalg.lstsq(columns_of_plane[on_road], y[on_road], rcond=None)
    ground = columns_of_plane @ plane - y < highest
    road, side = (_area(x[each], depth[each]) for each in (on_road, ground & ~on_road))
    return road, side


def placed_ghosts(
    detections: Boxes3D,
    truth: Boxes3D,
    view: RoadView,
    calibration: Calibration,
    *,
    threshold: float = 0.0,
    farthest: float = FARTHEST,
) -> tuple[Boxes3D, list[GhostPlace]]:
    """A frame's ghosts, and where each stands.

    Args:
        detections: The detections of one frame.
        truth: The scene's labels.
        view: Road and side area of its left image.
        calibration: The calibration of the frame.
        threshold: Least score.
        farthest: Metres ahead up to which ghosts count.
    """
    near = (detections.location[:, 2] < farthest) & (detections.score >= threshold)
    found = detections[near]
    unreal = found[ghosts(found, truth)]
    return unreal, places(unreal, view, calibration)


def count_ghosts(
    unreal: Boxes3D, where: Sequence[GhostPlace], areas: tuple[float, float]
) -> GhostCount:
    """A frame's ghosts in numbers.

    Args:
        unreal: Flags as `placed_ghosts` gives them.
        where: The places of the ghosts, likewise.
        areas: Areas as `visible_areas` gives them.
    """
    road, side, unknown = (where.count(place) for place in GhostPlace)
    on_road = np.array([place == GhostPlace.ROAD for place in where], bool)
    return GhostCount(road, side, unknown, int((on_road & in_corridor(unreal)).sum()), *areas)


@dataclass(frozen=True)
class GhostSummary:
    """The ghosts of all frames, and how their places compare with chance.

    Args:
        frames: Number of frames.
        ghosts: Number of ghosts.
        road: Number of ghosts on the road.
        side: Number of ghosts beside it.
        unknown: Number of ghosts whose place the image does not show; they do not count below.
        in_lanes: Number of ghosts on the road in the lanes that are driven on.
        ghosts_per_100_m2: Ghosts on 100 m2 of visible ground of ``road`` and ``side``.
        share_on_road: Share of the ghosts that is on the road.
        chance: The road's share of the visible ground, each frame weighted by its ghosts: the share
            of ghosts on the road if they were spread evenly over the ground of their frames.
        ratio: The odds of the two, divided: 1 where ghosts do not care, below 1 where they prefer
            the side area.
        share_in_lanes: Share of the ghosts that is on the road where it is driven on.
    """

    frames: int
    ghosts: int
    road: int
    side: int
    unknown: int
    in_lanes: int
    ghosts_per_100_m2: Mapping[str, float | None]
    share_on_road: Estimate
    chance: Estimate
    ratio: Estimate
    share_in_lanes: Estimate


def ghost_summary(
    frames: Sequence[GhostCount], *, resamples: int = 10_000, seed: int = 0
) -> GhostSummary:
    """The share of ghosts on the road, and how it compares with chance.

    Intervals hold 95 % of a bootstrap over frames; there are none without ghosts, and with those of
    a single frame.

    Args:
        frames: The counts of each frame.
        resamples: Number of bootstrap samples.
        seed: Seed of the bootstrap.
    """
    # 1. Sums of each frame: ghosts on the road, ghosts that count, those expected there, in lanes.
    table = np.array(
        [[f.road, f.side, f.in_lanes, f.road_area, f.side_area] for f in frames], float
    ).reshape(-1, 5)
    area = table[:, 3:].sum(axis=1)
    expected = np.divide(table[:, 3], area, out=np.zeros(len(table)), where=area > 0)
    known = table[:, :2].sum(axis=1) * (area > 0)
    sums = np.column_stack(
        [table[:, 0] * (area > 0), known, expected * known, table[:, 2] * (area > 0)]
    )
    # 2. Shares of all frames, and of bootstrap samples of frames.
    frames_drawn = ClusterBootstrap(len(sums), resamples, seed)
    several = bool((known > 0).sum() > 1)
    shares = {
        name: _estimate(frames_drawn.statistic(partial(_share, name, sums)), several)
        for name in _NAMES
    }
    return GhostSummary(
        frames=len(frames),
        ghosts=sum(f.road + f.side + f.unknown for f in frames),
        road=sum(f.road for f in frames),
        side=sum(f.side for f in frames),
        unknown=sum(f.unknown for f in frames),
        in_lanes=sum(f.in_lanes for f in frames),
        ghosts_per_100_m2={
            name: 100 * float(table[:, i].sum() / table[:, i + 3].sum())
            if table[:, i + 3].any()
            else None
            for i, name in enumerate(("road", "side"))
        },
        share_on_road=shares["share_on_road"],
        chance=shares["chance"],
        ratio=shares["ratio"],
        share_in_lanes=shares["share_in_lanes"],
    )


def _estimate(share: Sampled, several: bool) -> Estimate:
    """A share with the interval of its samples, if they are of several frames."""
    return share.estimate if several else Estimate(share.estimate.value)


def _share(name: str, sums: Floats, weights: NDArray[np.int64]) -> Floats:
    """One of `_NAMES`, of sets in which frames count so often, shape (K, frames)."""
    on_road, known, expected, in_lanes = (weights @ sums).T
    with np.errstate(invalid="ignore", divide="ignore"):
        share, chance = on_road / known, expected / known
        ratio = (share / (1 - share)) / (chance / (1 - chance))
        found = dict(zip(_NAMES, (share, chance, ratio, in_lanes / known), strict=True))
    return np.asarray(found[name])


def _area(x: Floats, depth: Floats) -> float:
    """Of the squares that points lie in, m2."""
    across, ahead = (np.floor(values / _CELL).astype(np.int64) for values in (x, depth))
    return float(len(np.unique(across * 1_000_000 + ahead)) * _CELL**2)
