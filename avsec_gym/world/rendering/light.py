"""Sun, sky and air at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from avsec_gym.world.mesh import Float32s
from avsec_gym.world.textures.noise import fractal_noise

_ROWS, _COLUMNS = 96, 512


@dataclass(frozen=True, eq=False)
class Light:
    """Daylight.

    Args:
        azimuth: Direction of the sun, radians from the world's x axis, counter-clockwise.
        elevation: Height of the sun, radians.
        cloudiness: Cover from 0 for a clear sky to 1 for an overcast one: it hides the sun by as
            much.
        haze: Distance at which the air has removed 63 % of the contrast, metres.
        seed: Seed of the clouds.
        brightness: Mean of the images that cameras aim for by their exposure, in [0, 1]; those
            of KITTI have 0.36 on average.
    """

    azimuth: float = 2.2
    elevation: float = 0.75
    cloudiness: float = 0.1
    haze: float = 1500.0
    seed: int = 0
    brightness: float = 0.36

    @property
    def sun(self) -> Float32s:
        """Direction towards the sun, shape (3,)."""
        flat = np.cos(self.elevation)
        return np.array(
            [flat * np.cos(self.azimuth), flat * np.sin(self.azimuth), np.sin(self.elevation)],
            np.float32,
        )

    @property
    def sun_colour(self) -> Float32s:
        """Light of the sun on a surface square to it, shape (3,): redder when it is low."""
        air = 1.0 / (np.sin(self.elevation) + 0.15)
        colour = np.exp(-np.array([0.050, 0.085, 0.160]) * air) * 3.1
        return np.asarray(colour * (1.0 - 0.93 * self.cloudiness), np.float32)

    @cached_property
    def panorama(self) -> Float32s:
        """Light of the sky, shape (96, 512, 3).

        Rows lead from the horizon to the zenith, evenly in the sine of the elevation, columns
        round the horizon from -pi to pi, counted from the world's x axis.
        """
        rng = np.random.Generator(np.random.PCG64(self.seed))
        height = ((np.arange(_ROWS) + 0.5) / _ROWS)[:, None, None]
        azimuth = (np.arange(_COLUMNS) + 0.5) / _COLUMNS * 2 * np.pi - np.pi
        flat = np.sqrt(1.0 - height**2)
        direction = np.stack(
            np.broadcast_arrays(
                flat[..., 0] * np.cos(azimuth), flat[..., 0] * np.sin(azimuth), height[..., 0]
            ),
            axis=-1,
        )
        # A clear sky: pale at the horizon, brighter around the sun.
        towards_sun = np.clip(direction @ self.sun, -1.0, 1.0)[..., None]
        zenith, horizon = np.array([0.36, 0.48, 0.76]), np.array([1.25, 1.36, 1.48])
        veil = (1.0 - height) ** 4
        clear = zenith * (1 - veil) + horizon * veil
        clear = clear * (1.0 + 0.35 * towards_sun**2 + 0.9 * np.maximum(towards_sun, 0) ** 24)
        # Clouds over it, as many as the cloudiness asks for.
        noise = fractal_noise(rng, _ROWS, _COLUMNS, cells=7, octaves=6, persistence=0.55)
        cover = np.clip(0.5 + 0.45 * noise + 2.2 * (self.cloudiness - 0.5), 0.0, 1.0)[..., None]
        cover = cover * cover * (3.0 - 2.0 * cover)
        shade = 1.0 - 0.55 * self.cloudiness * np.clip(0.6 + 0.4 * noise, 0, 1)[..., None]
        cloud = np.array([1.90, 1.93, 2.00]) * shade * (1.0 + 0.5 * np.maximum(towards_sun, 0) ** 6)
        return np.asarray(clear * (1 - cover) + cloud * cover, np.float32)

    @cached_property
    def horizon(self) -> Float32s:
        """Light of the air between here and afar, shape (3,)."""
        return np.asarray(self.panorama[:6].mean(axis=(0, 1)) * 0.7, np.float32)


def draw_light(rng: np.random.Generator) -> Light:
    """Some daylight hour: mostly sunny as in KITTI, sometimes hazy or overcast."""
    cloudiness = float(rng.choice([0.02, 0.15, 0.35, 0.6, 0.95], p=[0.32, 0.28, 0.2, 0.1, 0.1]))
    return Light(
        azimuth=float(rng.uniform(-np.pi, np.pi)),
        elevation=float(np.radians(rng.uniform(22.0, 58.0))),
        cloudiness=cloudiness,
        haze=float(rng.uniform(1200.0, 6000.0) * (1.0 - 0.6 * cloudiness)),
        seed=int(rng.integers(2**31)),
        brightness=float(np.clip(rng.normal(0.355, 0.02), 0.30, 0.42)),
    )
