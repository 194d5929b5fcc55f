"""How many regions of an image are proposed, and how many are learned from."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class ProposalCount:
    """How many proposals of one image go into non-maximum suppression, and how many come out.

    Raises:
        ConfigurationError: None, or more come out than go in.
    """

    before: int
    after: int

    def __post_init__(self) -> None:
        if not 0 < self.after <= self.before:
            raise ConfigurationError(f"suppression keeps some of what it is given, got {self}")


@dataclass(frozen=True)
class SampleCount:
    """How much of an image is learned at a time; the defaults are Stereo R-CNN's numbers.

    Args:
        anchors: The number of anchors in all.
        true_anchors: Largest share of them on an object.
        regions: The number of regions in all.
        true_regions: Largest share of them on an object.

    Raises:
        ConfigurationError: No sample, or shares beyond 0..1.
    """

    anchors: int = 512
    true_anchors: float = 0.5
    regions: int = 512
    true_regions: float = 0.25

    def __post_init__(self) -> None:
        shares = (self.true_anchors, self.true_regions)
        if min(self.anchors, self.regions) < 1 or not all(0 <= share <= 1 for share in shares):
            raise ConfigurationError(f"a sample has a size and shares in 0..1, got {self}")
