"""A spinning 64-beam LiDAR (Velodyne HDL-64E, as on KITTI's car)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.echoes import PULSE_ANGLE, laser_echoes
from avsec_gym.world.rendering.lasers import NOMINAL, Lasers, draw_lasers
from avsec_gym.world.rendering.moving_bodies import MovingBody, Rays, SweptScene
from avsec_gym.world.rendering.pulses import aim_pulses, place_points
from avsec_gym.world.rendering.reflectance import graded_reflectance
from avsec_gym.world.rendering.relief import raise_ground
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.section import Surface

_ENCODER = np.radians(0.09)
"""Step of the head's angle in KITTI's scans: neighbouring pulses are one or two of them apart."""
_GRID = 1000.0
"""KITTI's coordinates come in thousandths of a metre."""


class Scan(NamedTuple):
    """One turn."""

    points: Points
    """Shape (M, 4): x, y, z in the velodyne frame (metres), reflectance; beam by beam from the
    top, each from ahead over the left side, as KITTI's files have it."""
    object_id: Int32s
    """Shape (M,); -1 for scenery."""
    seconds: Float32s
    """When each pulse was sent, counted from the time at which the head faces ahead, shape (M,)."""


@dataclass(frozen=True)
class Lidar:
    """The LiDAR's properties; the defaults are those that KITTI's scans show.

    Args:
        columns: Number of pulses of each beam in a turn (0.17 degrees apart).
        nearest: Shortest range, metres.
        farthest: Longest range, metres.
        noise: Standard deviation of a near range, metres; 1.8 times that at 30 m.
        sensitivity: Reflectance of a dull surface that is just detected, square to the beam and 50
            m away.
        dropout: Share of the pulses lost for no reason.
        residual: Size of what the calibration leaves of each laser's angle and range, 1 for what
            KITTI's scans show, 0 for a perfect one.
        period: Duration of a turn, seconds.
        seed: Seed of the device: its angles, gains and errors; the nominal device if None (but
            `avsec_gym.world.capture.render` gives each vehicle a device of its own).
    """

    columns: int = 2120
    nearest: float = 0.9
    farthest: float = 80.0
    noise: float = 0.008
    sensitivity: float = 0.05
    dropout: float = 0.05
    residual: float = 1.0
    period: float = 0.1
    seed: int | None = None

    @property
    def lasers(self) -> Lasers:
        """The lasers of this device."""
        return draw_lasers(NOMINAL if self.seed is None else self.seed, _ENCODER)

    @cached_property
    def head(self) -> Floats:
        """Directions of the head at which all lasers fire, radians to the left, (columns,)."""
        even = np.arange(self.columns) * (2.0 * np.pi / self.columns)
        return np.asarray(_ENCODER * np.round(even / _ENCODER))

    @cached_property
    def firing_times(self) -> Floats:
        """When each column fires, seconds counted from the time at which the head faces ahead.

        The head turns to the left, and a turn begins and ends behind: a scan lasts from -0.05 to
        0.05 s, and its time is that of the cameras, which are triggered in the middle.  Shape
        (columns,).
        """
        turned = (self.head + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(turned * (self.period / (2.0 * np.pi)))

    @cached_property
    def directions(self) -> Float32s:
        """Of the pulses by the calibration, in the velodyne frame, shape (64 * columns, 3)."""
        lasers = self.lasers
        azimuth = self.head[None, :] + lasers.azimuth[:, None]
        up = lasers.elevation[:, None]
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
        *,
        bodies: Sequence[MovingBody] = (),
        relief: Float32s | None = None,
        compensated: bool = False,
    ) -> Scan:
        """One turn.

        Args:
            renderer: Renderer of the scene at the time of the scan.
            to_world: Transform from the velodyne frame to the world, shape (4, 4); for a LiDAR
                that moves while it turns, one for each of the `firing_times`, shape (columns, 4,
                4).
            rng: Generator of noise and losses.
            free: Whether each pulse leaves the vehicle that carries the LiDAR, shape (64 *
                columns,); all do if None.
            bodies: Objects that move while the LiDAR turns.
            relief: Unevenness of the ground, see `draw_relief`; smooth if None.
            compensated: Whether points are given in the velodyne frame at the time of the scan,
                the first column's, instead of each in that of its own pulse (KITTI's raw scans
                are not compensated).
        """
        lasers, columns = self.lasers, self.columns
        poses = np.reshape(to_world, (-1, 4, 4))
        # Aim the pulses that are not lost, nor end on the vehicle itself, and trace them.
        kept = rng.random(64 * columns, np.float32) >= self.dropout
        pulse = np.flatnonzero(kept if free is None else kept & free)
        laser, column = np.divmod(pulse, columns)
        seconds = self.firing_times.astype(np.float32)[column]
        origins, directions = np.empty((2, len(pulse), 3), np.float32)
        tilt = lasers.elevation + self.residual * lasers.elevation_error
        rotation, place = np.ascontiguousarray(poses[:, :3, :3]), poses[:, :3, 3].copy()
        of_lasers = (tilt, lasers.azimuth, lasers.height)
        aim_pulses(*of_lasers, self.head, pulse, rotation, place, origins, directions)
        rays = Rays(origins, directions, seconds)
        echo = laser_echoes(renderer, SweptScene(renderer, bodies, PULSE_ANGLE), rays)
        # Ranges: of uneven ground, with noise and what the calibration leaves.
        chance = rng.random(len(pulse), np.float32)
        distance = echo.distance
        if relief is not None:
            blades = rng.random(len(pulse), np.float32)
            raise_ground(distance, origins, directions, echo.cosine, echo.surface, relief, blades)
        noise = rng.standard_normal(len(pulse), np.float32) * np.float32(self.noise)
        near = np.minimum(distance, np.float32(self.farthest))
        noise *= np.sqrt(1.0 + np.square(near / np.float32(20.0)))
        distance = distance + noise + self.residual * lasers.range_error[laser].astype(np.float32)
        # Echoes strong enough to be detected.
        # Rough ground sends light back even at grazing angles: the root of the cosine.
        strength = echo.reflectance * np.sqrt(echo.cosine)
        signal = strength * (50.0 / np.maximum(distance, 5.0)) ** 2
        seen = (distance > self.nearest) & (distance < self.farthest)
        seen &= signal > self.sensitivity * (0.5 + chance)
        # Points by the calibrated directions, on KITTI's grid.
        which = np.flatnonzero(seen)
        places = np.empty((len(which), 3))
        of_lasers = (lasers.elevation, lasers.azimuth, lasers.height)
        place_points(*of_lasers, self.head, pulse[which], distance[which], places)
        if compensated and len(poses) > 1:
            back = np.linalg.inv(poses[0]) @ poses
            turned = back[column[which]]
            places = np.einsum("nij,nj->ni", turned[:, :3, :3], places) + turned[:, :3, 3]
        points = np.empty((len(which), 4), np.float32)
        points[:, :3] = np.round(places * _GRID) / _GRID
        points[:, 3] = graded_reflectance(
            echo.reflectance[which],
            echo.cosine[which],
            echo.mirror[which],
            echo.surface[which] == Surface.VEHICLE,
            distance[which],
            lasers.gain[laser[which]],
            lasers.floor,
            rng,
        )
        return Scan(points, echo.object_id[which], seconds[which])
