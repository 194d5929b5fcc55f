"""`StereoRcnnDecodingRule`: which of Stereo R-CNN's regions become boxes."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class StereoRcnnDecodingRule:
    """Which regions become boxes; the defaults are the published numbers.

    Args:
        least_score: The probability of its class below which a region is no detection.
        overlap: Left boxes that overlap more than this suppress each other.
        fit_share: Share a of the predicted fit in a score: class probability^(1 - a) * fit^a.

    Raises:
        ConfigurationError: A number beyond 0..1.
    """

    least_score: float = 0.05
    overlap: float = 0.3
    fit_share: float = 0.0

    def __post_init__(self) -> None:
        if not all(0 <= share <= 1 for share in (self.least_score, self.overlap, self.fit_share)):
            raise ConfigurationError(f"scores, overlaps and shares are in 0..1, got {self}")
