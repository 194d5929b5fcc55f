"""Recorded actors: where each of them is at every tenth of a second."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, wrap_angle

STEP = 0.1
"""Seconds between two poses."""
_SHORT = 1e-9
"""Steps by which a time may lie beyond the first or last pose."""


@dataclass(frozen=True, eq=False)
class Tracks:
    """N actors over T steps in the world frame: x forward, y left.

    Args:
        ids: Unique ids, shape (N,).
        categories: KITTI's names, such as ``Car``, shape (N,).
        dimensions: Height, width, length, metres, shape (N, 3).
        poses: x, y, heading of the centre of the footprint, shape (N, T, 3); what stands outside
            `first` to `last` is not used.
        speeds: Speeds along the heading, m/s, shape (N, T).
        first: Step of the first pose of each, shape (N,).
        last: Step of the last pose of each, shape (N,).
        below: How far the bottom lies below the car's camera, metres, shape (N,).
    """

    ids: NDArray[np.int64]
    categories: NDArray[np.str_]
    dimensions: Floats
    poses: Floats
    speeds: Floats
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    below: Floats

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: Any) -> Tracks:
        """The actors picked by a mask or an integer array."""
        return Tracks(**{field.name: getattr(self, field.name)[index] for field in fields(self)})

    def present(self, actor: int, time: float) -> bool:
        """Whether an actor is there at a time, seconds."""
        return bool(self.first[actor] - _SHORT <= time / STEP <= self.last[actor] + _SHORT)

    def state(self, actor: int, time: float) -> tuple[float, float, float, float]:
        """x, y, heading and speed of an actor at a time, linear between steps.

        Args:
            actor: Row of the actor.
            time: The time, seconds; before the first and after the last pose these hold.
        """
        step = min(max(time / STEP, float(self.first[actor])), float(self.last[actor]))
        before = min(int(step + _SHORT), int(self.last[actor]))
        after = min(before + 1, int(self.last[actor]))
        share = step - before if step - before > _SHORT else 0.0
        x, y, heading = self.poses[actor, before].tolist()
        speed = float(self.speeds[actor, before])
        if share:
            further = self.poses[actor, after].tolist()
            x, y = x + share * (further[0] - x), y + share * (further[1] - y)
            heading += share * float(wrap_angle(further[2] - heading))
            speed += share * (float(self.speeds[actor, after]) - speed)
        return x, y, heading, speed

    def states(self, times: NDArray[np.floating[Any]]) -> tuple[Floats, Floats]:
        """`state` of all actors at F times: poses, shape (F, N, 3), and speeds, shape (F, N).

        Args:
            times: The times, seconds, shape (F,).
        """
        first, last, rows = self.first, self.last, np.arange(len(self))
        step = np.minimum(np.maximum((times / STEP)[:, None], first), last)
        before = np.minimum((step + _SHORT).astype(np.int64), last)
        after = np.minimum(before + 1, last)
        share = np.where(step - before > _SHORT, step - before, 0.0)
        poses, further = self.poses[rows, before], self.poses[rows, after]
        speeds, faster = self.speeds[rows, before], self.speeds[rows, after]
        poses[..., :2] += share[..., None] * (further[..., :2] - poses[..., :2])
        poses[..., 2] += share * wrap_angle(further[..., 2] - poses[..., 2])
        return poses, speeds + share * (faster - speeds)

    @classmethod
    def at_constant_velocity(
        cls,
        categories: NDArray[np.str_],
        dimensions: Floats,
        poses: Floats,
        speeds: Floats,
        below: Floats,
        steps: int,
    ) -> Tracks:
        """Actors that stand, or drive on along their headings.

        Args:
            categories: KITTI's names, shape (N,).
            dimensions: Height, width, length, metres, shape (N, 3).
            poses: Poses at the start, shape (N, 3).
            speeds: Speeds along the headings, m/s, shape (N,).
            below: How far each bottom lies below the car's camera, see the class.
            steps: Number of steps after the first.
        """
        count, travelled = len(poses), speeds[:, None] * STEP * np.arange(steps + 1)
        track = np.repeat(np.asarray(poses, float)[:, None], steps + 1, axis=1)
        track[..., 0] += travelled * np.cos(track[..., 2])
        track[..., 1] += travelled * np.sin(track[..., 2])
        return cls(
            ids=np.arange(count),
            categories=categories,
            dimensions=dimensions,
            poses=track,
            speeds=np.repeat(np.asarray(speeds, float)[:, None], steps + 1, axis=1),
            first=np.zeros(count, np.int64),
            last=np.full(count, steps),
            below=below,
        )
