"""What happened in a drive, time step by time step; every metric is computed from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I


@dataclass(frozen=True, eq=False)
class DriveLog:
    """T instants of a drive among N actors, in the world frame.

    Args:
        dt: Seconds between two instants.
        car: x, y of the centre, velocity, heading, steering angle of the car, shape (T, 5).
        sizes: Length and width of each actor, metres, shape (N, 2).
        poses: x, y, heading of each actor, shape (T, N, 3).
        speeds: Speeds along the headings, m/s, shape (T, N).
        present: Whether each is there, shape (T, N).
    """

    dt: float
    car: Floats
    sizes: Floats
    poses: Floats
    speeds: Floats
    present: NDArray[np.bool_]

    @property
    def duration(self) -> float:
        """Seconds from the first to the last instant."""
        return (len(self.car) - 1) * self.dt

    def footprints(self) -> NDArray[np.object_]:
        """The car's footprints, shape (T,)."""
        return rectangle_polygons(self.car[:, [0, 1, 3]], BMW_320I.length, BMW_320I.width)


@dataclass(frozen=True)
class DriveContact:
    """The first touch of the car and an actor."""

    step: int
    """Instant of the log."""
    actor: int
    """Row of the actor."""


def touched(
    car: Floats, sizes: Floats, poses: Floats, present: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which actors the car touches at one instant, shape (N,).

    Args:
        car: The car's state, shape (5,).
        sizes: Length and width of the actors, shape (N, 2).
        poses: The actors' poses, shape (N, 3).
        present: Whether each is there, shape (N,).
    """
    reach = 0.5 * (np.hypot(*sizes.T) + np.hypot(BMW_320I.length, BMW_320I.width))
    near = present & (np.hypot(*(poses[:, :2] - car[:2]).T) <= reach)
    rows = np.nonzero(near)[0]
    if not len(rows):
        return near
    own = rectangle_polygons(car[[0, 1, 3]], BMW_320I.length, BMW_320I.width)
    others = rectangle_polygons(poses[rows], sizes[rows, 0], sizes[rows, 1])
    near[rows] = shapely.intersects(own, others)
    return near


def first_contact(log: DriveLog) -> DriveContact | None:
    """The first instant at which the car touches an actor that it has not touched all along.

    A scene may begin with touches, which labels that are centimetres off make; no driver caused
    them.  Once such a touch has ended, the next one counts.
    """
    excused = touched(log.car[0], log.sizes, log.poses[0], log.present[0])
    reach = 0.5 * (np.hypot(*log.sizes.T) + np.hypot(BMW_320I.length, BMW_320I.width))
    apart = np.hypot(*np.moveaxis(log.poses[..., :2] - log.car[:, None, :2], -1, 0))
    near = log.present & (apart <= reach)
    held = np.logical_and.accumulate(near)
    for step in np.flatnonzero(near.any(axis=1)).tolist():
        touching = touched(log.car[step], log.sizes, log.poses[step], near[step])
        counted = touching & ~(excused & held[step])
        if counted.any():
            return DriveContact(step, int(np.argmax(counted)))
        excused &= touching
    return None


def smallest_distance(log: DriveLog) -> float:
    """Least distance between the car and any actor, m; inf where there never is one."""
    if not len(log.sizes):
        return float("inf")
    reach = 0.5 * (np.hypot(*log.sizes.T) + np.hypot(BMW_320I.length, BMW_320I.width))
    apart = np.hypot(*np.moveaxis(log.poses[..., :2] - log.car[:, None, :2], -1, 0)) - reach
    apart = np.where(log.present, np.maximum(apart, 0.0), np.inf)
    bound = np.hypot(*np.moveaxis(log.poses[..., :2] - log.car[:, None, :2], -1, 0))
    # A lower bound above the smallest upper bound cannot win.
    t, i = np.nonzero(apart <= np.where(log.present, bound, np.inf).min())
    if not len(t):
        return float("inf")
    others = rectangle_polygons(log.poses[t, i], log.sizes[i, 0], log.sizes[i, 1])
    return float(shapely.distance(log.footprints()[t], others).min())
