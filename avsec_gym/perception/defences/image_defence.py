"""What a defence of the image is: a picture goes in, a picture comes out."""

from __future__ import annotations

from typing import Protocol

from numpy.random import Generator

from avsec_gym.frame import Image


class ImageDefence(Protocol):
    """A change of images that is meant to take an attack away, and to leave what is seen."""

    name: str

    def defend(self, image: Image, random: Generator) -> Image:
        """The image that the detector is given.

        Args:
            image: Red, green, blue, uint8, shape (H, W, 3).
            random: The generator for defences that draw something.

        Returns:
            The same shape and type.
        """
        ...
