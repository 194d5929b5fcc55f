"""From light to pixel values: lens blur, gain, noise, interpolation, tone curve, 8 bits."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from avsec_gym.frame import Image
from avsec_gym.world.mesh import Float32s

GAMMA = 1.05
"""Gamma of the tone curve; a screen's would be 2.2."""

_BLOCK = 8
"""Pixels in a row of a block on which scattered light is computed."""
_HALO = 0.6
"""Share of the scattered light that stays near its source."""
_WHITE_BALANCE = np.array([0.91, 1.0, 1.07])


@dataclass(frozen=True)
class ImageSensor:
    """How a camera turns light into an image.

    Args:
        gain: Factors on red, green, blue: exposure and white balance of this very camera.
        blur: Standard deviation of the lens' blur, pixels.
        read_noise: Standard deviation in the dark, share of full scale.
        shot_noise: Variance of the noise for each unit of light, share of full scale.
        smoothing: Standard deviation of the blur that interpolating colours and rectifying the
            image leave, noise included, pixels.
        glare: Share of the light that the lens scatters: a halo of some pixels, and a veil over a
            wide part of the image.
        streaks: Share of dazzling light that the edges of the aperture spread along rows and
            columns.

    The defaults give plain areas the noise, and images the sharpness, of KITTI's.
    """

    gain: tuple[float, float, float] = (1.0, 1.0, 1.0)
    blur: float = 0.42
    read_noise: float = 0.0006
    shot_noise: float = 0.0001
    smoothing: float = 0.45
    glare: float = 0.025
    streaks: float = 0.012

    def resampled(self, share: float) -> ImageSensor:
        """The sensor whose image has been resampled to a share of its width.

        Blur covers fewer pixels, and each holds the mean of several noisy ones.
        """
        return replace(
            self,
            blur=share * self.blur,
            smoothing=share * self.smoothing,
            read_noise=share * self.read_noise,
            shot_noise=share**2 * self.shot_noise,
        )

    def expose(self, light: Float32s, rng: np.random.Generator) -> Image:
        """The image of linear light, shape (H, W, 3), what dazzles included."""
        # Lens, then photons and amplifier, then interpolation, then tone curve and 8 bits.
        seen = _scattered(_blurred(light, self.blur), self.glare, self.streaks)
        signal = seen * np.array(self.gain, np.float32)
        deviation = np.sqrt(self.read_noise**2 + self.shot_noise * np.maximum(signal, 0.0))
        noise = deviation * rng.standard_normal(signal.shape, np.float32)
        recorded = _blurred(np.asarray(signal + noise, np.float32), self.smoothing)
        return (tone_curve(np.clip(recorded, 0.0, 1.0)) * 255.0 + 0.5).astype(np.uint8)


def tone_curve(signal: Float32s) -> Float32s:
    """From linear light to pixel values, both in [0, 1]: harder than a screen's, like KITTI's."""
    return np.power(signal, np.float32(1.0 / GAMMA))


def metered_exposure(light: Float32s, brightness: float) -> float:
    """The exposure that gives an image a mean brightness.

    Args:
        light: Linear light of the image's pixels or of some of them, shape (n, 3).
        brightness: Mean pixel value aimed for, in [0, 1].
    """
    low, high = -8.0, 8.0
    for _ in range(24):
        middle = 0.5 * (low + high)
        if tone_curve(np.clip(light * np.float32(np.exp(middle)), 0.0, 1.0)).mean() > brightness:
            high = middle
        else:
            low = middle
    return float(np.exp(low))


def draw_sensors(rng: np.random.Generator, count: int) -> list[ImageSensor]:
    """Cameras of one make that differ a little in gain, colour and focus.

    By as much as KITTI's two colour cameras, whose images are a little green.
    """
    every = float(rng.uniform(0.32, 0.46))
    sensors = []
    for _ in range(count):
        exposure = float(np.exp(rng.normal(0.0, 0.03)))
        balance = np.exp(rng.normal(0.0, 0.012, 3)) * exposure * _WHITE_BALANCE
        sensors.append(
            ImageSensor(
                gain=(float(balance[0]), float(balance[1]), float(balance[2])),
                blur=every + float(rng.uniform(0.0, 0.2)),
            )
        )
    return sensors


def _blurred(light: Float32s, deviation: float) -> Float32s:
    if deviation <= 0:
        return light
    return np.asarray(cv2.GaussianBlur(light, (0, 0), deviation), np.float32)


def _scattered(light: Float32s, glare: float, streaks: float) -> Float32s:
    """Light with its halo, veil and streaks, computed on blocks of pixels, smooth as they are.

    Args:
        light: Linear light, shape (H, W, 3).
        glare: Share of all light that is scattered.
        streaks: Share of the light above white that goes into streaks.
    """
    height, width = light.shape[:2]
    size = (-(-width // _BLOCK), -(-height // _BLOCK))
    coarse = np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_AREA), np.float32)
    scattered = glare * (
        _HALO * cv2.GaussianBlur(coarse, (0, 0), 1.0, borderType=cv2.BORDER_REPLICATE)
        + (1.0 - _HALO) * cv2.GaussianBlur(coarse, (0, 0), 9.0, borderType=cv2.BORDER_REPLICATE)
    )
    dazzling = streaks * np.maximum(coarse - 1.0, 0.0)
    for deviations in ((6.0, 0.4), (0.4, 6.0)):
        across, down = deviations
        scattered += cv2.GaussianBlur(dazzling, (0, 0), across, sigmaY=down)
    wide = cv2.resize(scattered, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(light * np.float32(1.0 - glare) + wide, np.float32)
