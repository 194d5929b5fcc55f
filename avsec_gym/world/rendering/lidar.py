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
from avsec_gym.world.rendering.echoes import laser_echoes
from avsec_gym.world.rendering.renderer import Renderer

_BEAM_GRADES, _GRADE_NOISE, _DARK = 0.2, 0.06, 0.08


class Scan(NamedTuple):
    """One turn."""

    points: Points
    """Shape (M, 4): x, y, z in the velodyne frame (metres), reflectance; beam by beam from the
    top, each from ahead over the left side, as KITTI's files have it."""
    object_id: Int32s
    """Shape (M,); -1 for scenery."""


@dataclass(frozen=True)
class Lidar:
    """The LiDAR's properties; the defaults are those that KITTI's scans show.

    Args:
        columns: Number of pulses of each beam in a turn (0.17 degrees apart).
        nearest: Shortest range, metres.
        farthest: Longest range, metres.
        noise: Standard deviation of a range, metres.
        sensitivity: Reflectance of a dull surface that is just detected, square to the beam and 50
            m away.
        dropout: Share of the pulses lost for no reason.
        seed: Seed of the beams' own small errors: one seed, one device.
    """

    columns: int = 2120
    nearest: float = 0.9
    farthest: float = 80.0
    noise: float = 0.010
    sensitivity: float = 0.05
    dropout: float = 0.05
    seed: int = 64

    @cached_property
    def elevations(self) -> Floats:
        """Of the 64 beams, radians.

        32 from +2.4 degrees a third of a degree apart, 32 below half a degree apart, each a
        little off.
        """
        upper = np.linspace(2.42, -7.91, 32)
        lower = np.linspace(-8.32, -23.51, 32)
        rng = np.random.Generator(np.random.PCG64(self.seed))
        return np.radians(np.concatenate([upper, lower]) + rng.normal(0.0, 0.06, 64))

    @cached_property
    def directions(self) -> Float32s:
        """In the velodyne frame, shape (64 * columns, 3)."""
        rng = np.random.Generator(np.random.PCG64(self.seed + 1))
        azimuth = (np.arange(self.columns) + 0.5)[None, :] * (2 * np.pi / self.columns)
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
            renderer: Renderer of the scene.
            to_world: Transform from the velodyne frame to the world, shape (4, 4).
            rng: Generator of noise and losses.
            free: Whether each pulse leaves the vehicle that carries the LiDAR, shape (64 *
                columns,); all do if None.
        """
        # Trace all pulses of a turn.
        beams = self.directions
        directions = np.ascontiguousarray(beams @ to_world[:3, :3].T.astype(np.float32))
        origins = np.empty_like(directions)
        origins[:] = to_world[:3, 3]
        echo = laser_echoes(renderer, origins, directions)
        # Ranges with noise, and echoes strong enough to be detected.
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
        points[:, 3] = self._graded(echo.reflectance, echo.cosine, distance, rng)[seen]
        return Scan(points, echo.object_id[seen])

    def _graded(
        self, reflectance: Float32s, cosine: Float32s, distance: Float32s, rng: np.random.Generator
    ) -> Float32s:
        """Reflectances as KITTI's scans give them, fitted to their distribution.

        The device evens out dull surfaces, grades each beam with an error of its own, and gives
        0 for what is too dark, and often for what is beyond 25 m.
        """
        own = np.random.Generator(np.random.PCG64(self.seed + 2)).normal(1.0, _BEAM_GRADES, 64)
        beam = np.repeat(np.clip(own, 0.3, 1.5).astype(np.float32), self.columns)
        # All but retro-reflectors end in the lower half of the scale.
        even = 0.51 * reflectance**0.35 * (0.8 + 0.2 * cosine) + 0.55 * reflectance**6
        weaker = 1.0 - 0.4 * np.clip((distance - 20.0) / 40.0, 0.0, 1.0)
        shown = even * beam * weaker + _GRADE_NOISE * rng.standard_normal(len(beam), np.float32)
        ungraded = np.clip((distance - 25.0) / 45.0, 0.05, 0.95) + 0.6 * (reflectance < _DARK)
        shown[rng.random(len(beam), np.float32) < ungraded] = 0.0
        # KITTI's reflectances come in hundredths.
        return np.asarray(np.round(np.clip(shown, 0.0, 0.99), 2), np.float32)
