"""Where a road runs, and road coordinates: metres along it and to its left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats, wrap_angle


@dataclass(frozen=True, eq=False)
class Course:
    """A line in the ground plane, sampled evenly; at its ends it runs on straight.

    Args:
        start: Road coordinate `along` of the first point, metres.
        spacing: Distance between points, metres.
        points: Points of the line in the world frame, shape (n, 2), metres.
        headings: Direction of the line at the points, shape (n,), radians, without jumps.
    """

    start: float
    spacing: float
    points: Floats
    headings: Floats

    @property
    def end(self) -> float:
        """Road coordinate of the last point."""
        return self.start + self.spacing * (len(self.points) - 1)

    def poses(self, along: ArrayLike, left: ArrayLike, heading: ArrayLike = 0.0) -> Floats:
        """From road coordinates, each of shape (N,), to poses (x, y, heading), shape (N, 3)."""
        along, left, heading = np.broadcast_arrays(*map(np.asarray, (along, left, heading)))
        station = (along.astype(float) - self.start) / self.spacing
        index = np.clip(station.astype(int), 0, len(self.points) - 2)
        share = (station - index)[..., None]
        line = self.points[index] * (1 - share) + self.points[index + 1] * share
        inside = np.clip(share[..., 0], 0.0, 1.0)
        direction = self.headings[index] * (1 - inside) + self.headings[index + 1] * inside
        x = line[..., 0] - left * np.sin(direction)
        y = line[..., 1] + left * np.cos(direction)
        return np.stack([x, y, direction + heading], axis=-1)

    def coordinates(self, x: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats]:
        """The inverse of `poses` near the road: `along` and `left`, of the inputs' shape."""
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        places = np.stack([x.ravel(), y.ravel()], axis=-1)
        nearest = np.concatenate(
            [
                ((part[:, None] - self.points[None]) ** 2).sum(-1).argmin(1)
                for part in np.array_split(places, max(1, len(places) * len(self.points) // 10**6))
            ]
        )
        tangent = np.stack([np.cos(self.headings), np.sin(self.headings)], axis=-1)[nearest]
        offset = places - self.points[nearest]
        ahead = (offset * tangent).sum(-1)
        left = tangent[:, 0] * offset[:, 1] - tangent[:, 1] * offset[:, 0]
        # A step of ds on the line moves a place beside it by ds (1 - curvature * left).
        bend = np.gradient(self.headings, self.spacing)[nearest]
        ends = (nearest == 0) | (nearest == len(self.points) - 1)
        shrink = np.where(ends, 1.0, np.maximum(1.0 - bend * left, 0.2))
        left = left - np.where(ends, 0.0, 0.5 * bend * ahead**2 / shrink)
        along = self.start + self.spacing * nearest + ahead / shrink
        return along.reshape(x.shape), left.reshape(x.shape)


def course_from_curvature(
    curvature: ArrayLike,
    *,
    start: float = 0.0,
    spacing: float = 1.0,
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Course:
    """Integrate a curvature profile.

    Args:
        curvature: Curvature at each point, 1/m, positive to the left, shape (n,).
        start: Road coordinate of the first point, metres.
        spacing: Distance between points, metres.
        pose: World pose (x, y, heading) of road coordinate 0; `start` <= 0 <= end.
    """
    bend = np.asarray(curvature, float)
    middle = 0.5 * (bend[1:] + bend[:-1])
    headings = np.concatenate([[0.0], np.cumsum(middle * spacing)])
    between = 0.5 * (headings[1:] + headings[:-1])
    steps = spacing * np.sinc(0.5 * middle * spacing / np.pi)[:, None]
    points = np.concatenate(
        [
            np.zeros((1, 2)),
            np.cumsum(steps * np.stack([np.cos(between), np.sin(between)], -1), axis=0),
        ]
    )
    # Turn and shift everything so that road coordinate 0 comes to lie on the pose.
    zero = Course(start, spacing, points, headings).poses(0.0, 0.0)
    turn = float(wrap_angle(pose[2] - zero[2]))
    cos, sin = np.cos(turn), np.sin(turn)
    points = (points - zero[:2]) @ np.array([[cos, sin], [-sin, cos]]) + np.array(pose[:2])
    return Course(start, spacing, points, headings + turn)
