"""All actors at one instant: vehicles, cyclists, pedestrians, and which of them carry sensors."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, Integers
from avsec_gym.world.assets import Assets, seed_of


@dataclass(frozen=True, eq=False)
class Actors:
    """N objects in the world frame.

    Args:
        id: Unique, the same over time, shape (N,).
        category: KITTI's name, shape (N,).
        dimensions: Height, width, length, metres, shape (N, 3).
        pose: Position x, y and heading of the bottom centre, shape (N, 3).
        z: Height of the bottom, metres, shape (N,).
        speed: Speed along the heading, m/s, negative when reversing, shape (N,).
        moving: Whether each moves at this instant (a car that waits at a light does not), shape
            (N,).
        appearance: Seed of the looks, shape (N,).
        phase: Phase of the gait or the pedals in [0, 1), shape (N,).
    """

    id: Integers
    category: NDArray[np.str_]
    dimensions: Floats
    pose: Floats
    z: Floats
    speed: Floats
    moving: NDArray[np.bool_]
    appearance: Integers
    phase: Floats

    def __len__(self) -> int:
        return len(self.id)

    def pick(self, which: NDArray[np.bool_] | Integers) -> Actors:
        """Some of them."""
        return Actors(**{field.name: getattr(self, field.name)[which] for field in fields(self)})

    def of_part(self, assets: Assets) -> Actors:
        """The same actors, with looks of a part of the assets."""
        seeds = [seed_of(assets, seed) for seed in self.appearance.tolist()]
        return replace(self, appearance=np.array(seeds, np.int64))


@dataclass(frozen=True, eq=False)
class Instant:
    """The actors of a scene at one instant.

    Args:
        time: Time since the start, seconds.
        actors: All actors, the sensor vehicles among them.
        egos: Indices into `actors` of those that carry sensors.
        turn_rate: How fast each actor turns to the left, rad/s, shape (N,); none turns if None.
    """

    time: float
    actors: Actors
    egos: tuple[int, ...] = (0,)
    turn_rate: Floats | None = None
