"""Recorded traffic as a table: where every actor is at every instant of the simulation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.tracks import STEP
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.geometry import Floats


class TrafficTable(NamedTuple):
    """N recorded actors at F instants, in the world frame."""

    poses: Floats
    """x, y, heading, shape (F, N, 3)."""
    speeds: Floats
    """Speeds along the headings, m/s, shape (F, N)."""
    present: NDArray[np.bool_]
    """Whether each is there, shape (F, N)."""
    sizes: Floats
    """Length and width, metres, shape (N, 2)."""
    cars: NDArray[np.bool_]
    """Whether each is a car, shape (N,)."""


def traffic_table(scene: TrafficScene, frequency: int, frames: int) -> TrafficTable:
    """Play the tracks of a scene once, for all drives in it.

    Args:
        scene: The scene.
        frequency: Instants a second.
        frames: Number of instants, the start among them.
    """
    tracks, since = scene.tracks, np.arange(frames)
    poses, speeds = tracks.states(scene.sets_off + since * (1.0 / frequency))
    # As `RoadTraffic.show` has it.
    steps = ((scene.sets_off + since / frequency) / STEP)[:, None]
    return TrafficTable(
        poses=poses,
        speeds=speeds,
        present=(tracks.first - 1e-6 <= steps) & (steps <= tracks.last + 1e-6),
        sizes=np.ascontiguousarray(tracks.dimensions[:, [2, 1]]),
        cars=tracks.categories == "Car",
    )
