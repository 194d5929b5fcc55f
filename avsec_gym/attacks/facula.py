"""A facula: the round spot of a laser that shines into a camera (thesis, section 3.2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import (
    camera_number,
    keep_checked,
    label,
    number,
    number_or_range,
    numbers,
)
from avsec_gym.attacks.argument_domains import PIXELS, RADII, SHARES, STRENGTHS
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.rig import KITTI_SIZE
from avsec_gym.sensor_system import Sensor

THESIS_RADII = (187.0, 375.0)
"""Pixels of images of 1242 x 375 (thesis, section 3.2.4)."""
EDGE = float(np.exp(-2.0))
"""What is left of the peak at the radius, 13.5 %: how laser optics measures a Gaussian beam."""
_FULL = 255.0
_MOST_SATURATION = 0.999
"""Share of the radius: where nothing is left of it, nothing falls off."""


@dataclass(frozen=True)
class Facula:
    """Light with a Gaussian profile, added to one camera's image; the defaults are the thesis'.

    The radius is where the light has fallen to `EDGE` of its peak, so that a disc of it is the
    thesis' contaminated area: 0.95 % of an image of 1242 x 375 at 37.5 pixels, 34.15 % at 225,
    whether or not the image holds all of it.  Of a `TamperedFrame`, `pixels` are those in that
    disc which are other than they were: what was white already stays as it was, and the weaker
    light farther out brightens the scene, but does not hide it.

    Args:
        camera: Number of the attacked camera.
        radius: Radius in pixels of an image 1242 wide, in proportion in others; two numbers: drawn
            between them.
        centre: Column and row in the image's own pixels, also beyond its border; None: drawn from
            all of the image.
        strength: Brightness of the light at its peak, grey levels; what goes beyond 255 is cut off.
        colour: Share of the strength in red, green and blue.
        saturation: Share of the radius in which the sensor overflows: there all is white, whatever
            the colour, and the Gaussian falls from there on.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    camera: int = 2
    radius: float | tuple[float, float] = THESIS_RADII
    centre: tuple[float, float] | None = None
    strength: float = _FULL
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    saturation: float = 0.0
    name: str = "facula"

    def __post_init__(self) -> None:
        checked = {
            "camera": camera_number("camera", self.camera),
            "radius": number_or_range("radius", self.radius, *RADII),
            "centre": None if self.centre is None else numbers("centre", self.centre, 2, *PIXELS),
            "strength": number("strength", self.strength, *STRENGTHS),
            "colour": numbers("colour", self.colour, 3, *SHARES),
            "saturation": number("saturation", self.saturation, 0.0, _MOST_SATURATION),
            "name": label("name", self.name),
        }
        keep_checked(self, checked)
        if not any(self.colour):
            raise ConfigurationError("colour takes three shares, not all of them 0")

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The camera."""
        return frozenset({self.camera})

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The frame with the facula in one image; settings: radius as given, u, v.

        See `OpticalAttack.attack`.
        """
        image = frame.image(self.camera)
        height, width = image.shape[:2]
        random = np.random.default_rng(seed)
        # All are drawn, so that to give one leaves the others as they were.
        radius = random.uniform(*np.broadcast_to(self.radius, 2))
        drawn = random.uniform((0.0, 0.0), (width - 1.0, height - 1.0))
        u, v = drawn if self.centre is None else self.centre
        scaled = radius * width / KITTI_SIZE[0]
        profile = facula_profile((height, width), (u, v), scaled, self.saturation)
        tampered = self._lit(image, profile)
        return TamperedFrame(
            frame.with_image(self.camera, tampered),
            pixels={self.camera: (profile >= EDGE) & (tampered != image).any(axis=2)},
            settings={"radius": float(radius), "u": float(u), "v": float(v)},
        )

    def _lit(self, image: Image, profile: NDArray[np.float32]) -> Image:
        colour = np.array(self.colour, np.float32)
        if (image[..., :1] == image).all():
            # A grey camera sees how bright the light is, not which colour it has.
            colour[:] = colour.mean()
        light = self.strength * profile[..., None] * colour
        if self.saturation:
            light[profile >= 1] = _FULL
        lit = np.minimum(image + light, _FULL)
        return np.asarray(np.rint(lit) if image.dtype == np.uint8 else lit).astype(image.dtype)


def facula_profile(
    shape: tuple[int, int], centre: tuple[float, float], radius: float, saturation: float = 0.0
) -> NDArray[np.float32]:
    """How much of its peak a facula has at each pixel.

    1 within the saturated core, `EDGE` at the radius, Gaussian from the one to the other and on.

    Args:
        shape: Height and width of the image.
        centre: Column and row of the centre, pixels.
        radius: Radius in pixels of this image.
        saturation: The core's share of the radius.

    Returns:
        Shape (H, W), in [0, 1].

    Example:
        >>> (100 * facula_profile((1, 5), (0, 0), 2.0, 0.5)).round().astype(int)
        array([[100, 100,  14,   0,   0]])
    """
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    squared = np.add(((rows - centre[1]) / radius) ** 2, ((columns - centre[0]) / radius) ** 2)
    fallen = np.maximum(squared - saturation**2, 0.0).astype(np.float32) / (1.0 - saturation**2)
    return np.exp(np.float32(np.log(EDGE)) * fallen)
