"""Recorded traffic as a table: where every actor is at every instant of the simulation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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


def traffic_table(scene: TrafficScene, dt: float, frames: int) -> TrafficTable:
    """Play the tracks of a scene once, for all drives in it.

    Args:
        scene: The scene.
        dt: Seconds between two instants.
        frames: Number of instants, the start among them.
    """
    tracks = scene.tracks
    count = len(tracks)
    times = scene.sets_off + dt * np.arange(frames)
    states = np.array([[tracks.state(i, time) for i in range(count)] for time in times.tolist()])
    states = states.reshape(frames, count, 4)
    # As `Traffic.show` has it.
    steps = (times / 0.1)[:, None]
    return TrafficTable(
        poses=np.ascontiguousarray(states[..., :3]),
        speeds=np.ascontiguousarray(states[..., 3]),
        present=(tracks.first - 1e-6 <= steps) & (steps <= tracks.last + 1e-6),
        sizes=np.ascontiguousarray(tracks.dimensions[:, [2, 1]]),
        cars=tracks.categories == "Car",
    )
