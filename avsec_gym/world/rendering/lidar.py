"""A spinning 64-beam LiDAR (Velodyne HDL-64E, as on KITTI's car)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.camera import Renderer


class Scan(NamedTuple):
    """One turn."""

    points: Points
    """Shape (M, 4): x, y, z in the velodyne frame (metres), reflectance; beam by beam from the
    top, each from behind over the left side, as KITTI's files have it."""
    object_id: Int32s
    """Shape (M,); -1 for scenery."""


@dataclass(frozen=True)
class Lidar:
    """How the LiDAR sees.

    Args:
        columns: Pulses of each beam in a turn (0.17 degrees apart).
        nearest: Shortest range, metres.
        farthest: Longest range, metres.
        noise: Standard deviation of a range, metres.
        sensitivity: A dull surface of this reflectance, square to the beam and 50 m away, is
            just seen.
        dropout: Share of the pulses lost for no reason.
        seed: Of the beams' own small errors: one seed, one device.
    """

    columns: int = 2083
    nearest: float = 0.9
    farthest: float = 120.0
    noise: float = 0.015
    sensitivity: float = 0.05
    dropout: float = 0.01
    seed: int = 64

    @cached_property
    def elevations(self) -> Floats:
        """Of the 64 beams, radians: 32 from +2 degrees a third of a degree apart, 32 below half
        a degree apart (the HDL-64E manual), each a little off."""
        upper = np.linspace(2.0, -8.33, 32)
        lower = np.linspace(-8.83, -24.33, 32)
        rng = np.random.Generator(np.random.PCG64(self.seed))
        return np.radians(np.concatenate([upper, lower]) + rng.normal(0.0, 0.03, 64))

    @cached_property
    def directions(self) -> Float32s:
        """In the velodyne frame, shape (64 * columns, 3)."""
        rng = np.random.Generator(np.random.PCG64(self.seed + 1))
        azimuth = np.linspace(np.pi, -np.pi, self.columns, endpoint=False)[None, :]
        azimuth = azimuth + np.radians(rng.uniform(-0.08, 0.08, 64))[:, None]
        up = self.elevations[:, None]
        rays = np.stack(
            [np.cos(up) * np.cos(azimuth), np.cos(up) * np.sin(azimuth), np.sin(up) + 0 * azimuth],
            axis=-1,
        )
        return np.ascontiguousarray(rays.reshape(-1, 3), np.float32)

    def scan(
        self,
        renderer: Renderer,
        to_world: Floats,
        rng: np.random.Generator,
        free: NDArray[np.bool_] | None = None,
    ) -> Scan:
        """One turn.

        Args:
            renderer: Of the scene.
            to_world: From the velodyne frame to the world, shape (4, 4).
            rng: Of noise and losses.
            free: Which pulses leave the vehicle that carries the LiDAR, shape (64 * columns,);
                all if None.
        """
        beams = self.directions
        directions = np.ascontiguousarray(beams @ to_world[:3, :3].T.astype(np.float32))
        origins = np.empty_like(directions)
        origins[:] = to_world[:3, 3]
        echo = renderer.echoes(origins, directions)
        chance = rng.random(len(beams), np.float32)
        noise = rng.standard_normal(len(beams), np.float32) * np.float32(self.noise)
        distance = echo.distance + noise
        # Rough ground sends light back even at grazing angles: the root of the cosine.
        strength = echo.reflectance * np.sqrt(echo.cosine)
        signal = strength * (50.0 / np.maximum(distance, 5.0)) ** 2
        seen = (distance > self.nearest) & (distance < self.farthest)
        seen &= signal > self.sensitivity * (0.5 + chance)
        seen &= chance > self.dropout
        if free is not None:
            seen &= free
        points = np.empty((int(seen.sum()), 4), np.float32)
        points[:, :3] = beams[seen] * distance[seen, None]
        shown = echo.reflectance[seen] * (0.35 + 0.65 * echo.cosine[seen])
        # KITTI's reflectances come in hundredths.
        points[:, 3] = np.round(np.clip(shown, 0.0, 0.99), 2)
        return Scan(points, echo.object_id[seen])
