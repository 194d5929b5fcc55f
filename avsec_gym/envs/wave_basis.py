"""Patterns of few numbers that cover an image: sums of plane waves, of which the sign is kept.

Detectors built of convolutions answer to waves as long as their objects' parts, and patterns of
this kind fool classifiers as black boxes (procedural noise: Co et al., CCS 2019;
Fourier basis functions: Yin et al., NeurIPS 2019).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number_range, whole_number
from avsec_gym.geometry import Floats

MOST_WAVES = 256
"""More make patterns slow: every pixel is a sum over all waves."""
LENGTHS = (2.0, 10_000.0)
"""Pixels: the finest pattern that pixels can show, and one that hardly changes across an image."""

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class WaveBasis:
    """Waves whose directions are spread evenly over half a turn, and lengths over a range.

    Args:
        waves: The number of waves, each with two coefficients: its cosine's and its sine's; at most
            `MOST_WAVES`.
        wavelengths: The shortest and the longest, pixels, within `LENGTHS`; the others lie between
            them, evenly spread on a logarithmic scale.

    Raises:
        ConfigurationError: A number is out of range, or the longest comes first.
    """

    waves: int = 8
    wavelengths: tuple[float, float] = (12.0, 60.0)

    def __post_init__(self) -> None:
        lengths = number_range("wavelengths", self.wavelengths, *LENGTHS, may_be_one=True)
        object.__setattr__(self, "waves", whole_number("waves", self.waves, 1, MOST_WAVES))
        object.__setattr__(self, "wavelengths", lengths)

    @property
    def size(self) -> int:
        """Coefficients of a pattern."""
        return 2 * self.waves

    def pattern(self, coefficients: Floats, size: tuple[int, int]) -> NDArray[np.int8]:
        """The sign of the sum of the waves.

        Args:
            coefficients: Factors of the cosines, then of the sines, shape (2 waves,).
            size: Height and width of the pattern, pixels.

        Returns:
            -1 or 1, and 0 where the sum is 0, shape (height, width).
        """
        across, down = self._frequencies
        rows, columns = np.arange(size[0])[:, None] * down, across[:, None] * np.arange(size[1])
        cosine, sine = coefficients.reshape(2, -1, 1)
        # Of the sum of two angles; einsum adds up in one order whatever the number of threads.
        total = np.einsum(
            "hk,kw->hw",
            np.hstack([np.cos(rows), np.sin(rows)]),
            np.vstack(
                [
                    cosine * np.cos(columns) + sine * np.sin(columns),
                    sine * np.cos(columns) - cosine * np.sin(columns),
                ]
            ),
        )
        return np.sign(total).astype(np.int8)

    @property
    def _frequencies(self) -> tuple[Floats, Floats]:
        """Radians a pixel, to the right and down, shape (waves,) each."""
        number = np.arange(self.waves)
        shortest, longest = self.wavelengths
        lengths = shortest * (longest / shortest) ** (number * _GOLDEN % 1.0)
        direction = np.pi * number / self.waves
        return 2 * np.pi * np.cos(direction) / lengths, 2 * np.pi * np.sin(direction) / lengths
