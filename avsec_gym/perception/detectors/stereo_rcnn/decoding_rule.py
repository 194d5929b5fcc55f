"""`DecodingRule`: which of Stereo R-CNN's regions become boxes."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class DecodingRule:
    """Which regions become boxes; the defaults are the published numbers.

    Args:
        least_score: Below this, a region is no detection.
        overlap: Left boxes that overlap more than this suppress each other.

    Raises:
        ConfigurationError: A number beyond 0..1.
    """

    least_score: float = 0.05
    overlap: float = 0.3

    def __post_init__(self) -> None:
        if not (0 <= self.least_score <= 1 and 0 <= self.overlap <= 1):
            raise ConfigurationError(f"scores and overlaps are in 0..1, got {self}")
