"""Where one scan was taken, seen from another of the same place: point-to-plane ICP.

Chen and Medioni, Object modelling by registration of multiple range images, 1992; with the weights
of Geman and McClure, so that what moves between the scans does not pull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from avsec_gym.errors import DataError
from avsec_gym.frame import Points
from avsec_gym.geometry import Floats, transform_points

_OWN = 3.0
"""Metres within which a return may come from the vehicle itself."""
_REACH = 60.0
_CELL = 0.3
"""Metres: of each cell one point is taken, so that near surfaces do not count for more."""
_NEIGHBOURS = 12
_SMOOTH, _BROAD = 0.05, 0.1
"""Shares of the spread of neighbours: at most off their plane, at least across it the other way."""
_UPRIGHT = 0.5
"""Normals with a smaller vertical part belong to walls, poles and vehicles."""
_CLOSE = 0.2
"""Metres off the other scan's surface within which a point lies on it."""
_LEAST_OVERLAP = 0.4
"""Scans half a second apart have 0.55 and more, those of other places 0.25 and less."""
_LEAST_HOLD = 0.01
STARTS = tuple(np.arange(-2.0, 13.0))
"""Metres ahead at which the search begins: up to 90 km/h in half a second."""


@dataclass(frozen=True, eq=False)
class Registration:
    """How a scan lies in the frame of another.

    Args:
        transform: The transform from the velodyne frame of the one to that of the other, shape
            (4, 4).
        residual: Median distance of its points from the other's surface, metres.
        overlap: Share of its points on upright surfaces that lie within 0.2 m of the other's.
    """

    transform: Floats
    residual: float
    overlap: float


def register(scan: Points, onto: Points, starts: Sequence[float] = STARTS) -> Registration:
    """Register a scan onto another.

    Args:
        scan: Points in its own velodyne frame, shape (M, 4).
        onto: Points of the other scan in its frame, shape (K, 4).
        starts: Distances ahead of the other scan at which the search begins, metres.

    Raises:
        DataError: The scans do not overlap enough, or nothing in them holds the position, as on
            an empty plain.
    """
    surface = _Surface(onto)
    # First with few points from each start, then the best alone with all of them.
    moved = thinned(scan, _CELL)
    few = moved[:: max(1, len(moved) // 2000)]
    coarse = []
    for start in starts:
        guess = np.eye(4)
        guess[0, 3] = start
        coarse.append(surface.refined(few, guess, reaches=(3.0, 2.0, 1.0, 0.5)))
    best = max(coarse, key=lambda guess: surface.judged(few, guess).overlap)
    found = surface.judged(moved, surface.refined(moved, best, reaches=(1.0, 0.5, 0.3, 0.3)))
    if found.overlap < _LEAST_OVERLAP or surface.hold(moved, found.transform) < _LEAST_HOLD:
        raise DataError(
            f"Two scans cannot be registered: {found.overlap:.0%} of the points on upright"
            " surfaces of the one lie on the other.",
            remedy="Take scans that are nearer to each other, or poses that were measured.",
        )
    return found


def thinned(points: Points, cell: float) -> Floats:
    """One point of each cell of a scan within reach, shape (M, 3)."""
    places = np.asarray(points[:, :3], np.float64)
    away = np.hypot(places[:, 0], places[:, 1])
    places = places[(away > _OWN) & (away < _REACH) & np.isfinite(places).all(axis=1)]
    _, first = np.unique(np.floor(places / cell).astype(np.int64), axis=0, return_index=True)
    return places[np.sort(first)]


class _Surface:
    """A scan as small planes, and the search for its nearest ones."""

    def __init__(self, points: Points) -> None:
        places = thinned(points, _CELL)
        if len(places) <= _NEIGHBOURS:
            raise DataError(f"A scan of {len(places)} points within reach cannot be registered.")
        _, near = cKDTree(places).query(places, _NEIGHBOURS)
        spread = places[near] - places[near].mean(axis=1, keepdims=True)
        size, axes = np.linalg.eigh(np.einsum("mki,mkj->mij", spread, spread))
        # Points of one ring alone lie on a line and have no plane.
        flat = (size[:, 0] < _SMOOTH * size[:, 1]) & (size[:, 1] > _BROAD * size[:, 2])
        if not flat.any():
            raise DataError("A scan without surfaces cannot be registered.")
        self._places = places[flat]
        self._normals: Floats = axes[flat, :, 0]
        self._tree = cKDTree(self._places)

    def refined(self, points: Floats, guess: Floats, reaches: Sequence[float]) -> Floats:
        """The transform after ten steps of ICP with each reach, metres."""
        transform = guess
        for reach in reaches:
            for _ in range(10):
                step = self._step(points, transform, reach)
                transform = step @ transform
                if np.abs(step - np.eye(4)).max() < 1e-5:
                    break
        return transform

    def judged(self, points: Floats, transform: Floats) -> Registration:
        """How well points lie on the surface."""
        _, normals, off, near = self._matched(points, transform, reach=1.0)
        upright = np.abs(normals[:, 2]) < _UPRIGHT
        on = np.abs(off[upright & near]) < _CLOSE
        return Registration(
            transform,
            float(np.median(np.abs(off[near]))) if near.any() else np.inf,
            float(on.sum() / max(upright.sum(), 1)),
        )

    def hold(self, points: Floats, transform: Floats) -> float:
        """How firmly the matched planes hold a position: 1/3 evenly, 0 if a direction is free."""
        _, normals, off, near = self._matched(points, transform, reach=1.0)
        normals = normals[near & (np.abs(off) < _CLOSE)]
        return float(np.linalg.eigvalsh(normals.T @ normals / max(len(normals), 1))[0])

    def _step(self, points: Floats, transform: Floats, reach: float) -> Floats:
        """The small rigid motion that brings the points nearer to their planes."""
        moved, normals, off, near = self._matched(points, transform, reach)
        moved, normals, off = moved[near], normals[near], off[near]
        if len(moved) < 6:
            return np.eye(4)
        # A plane half a reach away has a quarter of the weight; the ground, of which there is
        # most, weighs as much as all that stands on it.
        weight = (1.0 + (2.0 * off / reach) ** 2) ** -2.0
        upright = np.abs(normals[:, 2]) < _UPRIGHT
        weight[~upright] *= min(1.0, weight[upright].sum() / max(weight[~upright].sum(), 1e-9))
        slopes = np.concatenate([np.cross(moved, normals), normals], axis=1)
        curvature = slopes.T @ (slopes * weight[:, None]) + 1e-6 * np.eye(6)
        motion = np.linalg.solve(curvature, -slopes.T @ (weight * off))
        step = np.eye(4)
        step[:3, :3] = Rotation.from_rotvec(motion[:3]).as_matrix()
        step[:3, 3] = motion[3:]
        return step

    def _matched(
        self, points: Floats, transform: Floats, reach: float
    ) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        """The points moved, the normals of their nearest planes, how far off, which are in reach.

        Args:
            points: Points of the other scan, shape (M, 3).
            transform: The transform from its frame to that of this one.
            reach: Metres from the middle of a plane within which a point belongs to it.
        """
        moved = transform_points(transform, points)
        away, index = self._tree.query(moved)
        normals = self._normals[index]
        off = np.einsum("mi,mi->m", moved - self._places[index], normals)
        return moved, normals, off, away < reach
