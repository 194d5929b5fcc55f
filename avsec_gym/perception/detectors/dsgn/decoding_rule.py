"""`DsgnDecodingRule`: which of DSGN's anchors become boxes."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class DsgnDecodingRule:
    """Which anchors become boxes; the defaults are those of the original car detector.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    least_score: float = 0.05
    candidates: int = 300
    """Anchors of an image, best first, that enter the suppression."""
    most_overlap: float = 0.6
    """Intersection over union seen from above of two boxes of one class that may both stay."""
    most_boxes: int = 30
    """Most boxes in an image."""
    score_times_centerness: bool = False
    voting_overlap: float | None = None
    """A box that stays becomes the mean, weighted by score, of all candidates of its class that
    overlap it by more than this seen from above.  None: it stays as it is."""
    voting_turn: float = 0.5
    """Radians: candidates that are turned farther from the box have no vote, whichever way they
    point."""
    fit_share: float = 0.0
    """Share a of the predicted fit in a score: class probability^(1 - a) * fit^a."""

    def __post_init__(self) -> None:
        if not (0 < self.least_score < 1 and 0 <= self.most_overlap <= 1):
            raise ConfigurationError(f"scores and overlaps are shares, got {self}")
        if min(self.candidates, self.most_boxes) < 1:
            raise ConfigurationError(f"an image needs candidates and boxes, got {self}")
        if not (0 <= (self.voting_overlap or 0.0) < 1 and 0 < self.voting_turn < 1.58):
            raise ConfigurationError(
                f"voters overlap by a share, and are turned by less than a right angle, got {self}"
            )
        if not 0 <= self.fit_share <= 1:
            raise ConfigurationError(f"the share of the fit is in 0..1, got {self.fit_share}")
