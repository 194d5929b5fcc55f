"""Other light for the views of one scene, drawn by chance: that of all, and that of each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.perception.training.configuration import Photometric

GREY = np.array([0.299, 0.587, 0.114])
"""Shares of red, green and blue in a grey level."""


class DrawnLight(NamedTuple):
    """Light that differs a little between the views.

    A change holds the logarithms of brightness, contrast, gamma, saturation, and of the factors of
    red, green and blue.
    """

    common: Floats
    """The change of all views, shape (7,)."""
    largest: Floats
    """The largest change to either side, shape (7,)."""
    between_views: float
    """The share of it by which a view may differ from the others."""
    deviation: float
    """Standard deviation of the noise, grey levels."""

    def of_view(self, randomness: np.random.Generator) -> Floats:
        """The change of one view, shape (7,)."""
        own = randomness.uniform(-self.largest, self.largest)
        return np.asarray(self.common + self.between_views * own)


def drawn_light(limits: Photometric, randomness: np.random.Generator) -> DrawnLight:
    """The light of a scene.

    Args:
        limits: The limits of the changes.
        randomness: The generator that draws it.
    """
    largest = np.array(
        [limits.brightness, limits.contrast, limits.gamma, limits.saturation, *[limits.tint] * 3]
    )
    common = randomness.uniform(-largest, largest)
    return DrawnLight(common, largest, limits.between_views, randomness.uniform(0, limits.noise))
