"""What the study of real pairs finds, as rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.tolerance import ToleranceThreshold

RULES = ("rendered", "raised", "discs")
"""The threshold of brightness from rendered frames; the same raised by clean real pairs; the mean
over discs of any of the study's sizes, against that of clean real pairs."""


@dataclass(frozen=True)
class CleanPair:
    """A real pair without an attack.

    Args:
        id: Its id.
        scene: Its scene.
        brightness: The value of `Brightness.patches`.
        pixel_noise: Standard deviation of single pixels, grey levels.
        alarms: Whether each of `RULES` alarms; a scene is judged by what the others alone have
            raised.
    """

    id: str
    scene: str
    brightness: float
    pixel_noise: float
    alarms: Mapping[str, bool]


@dataclass(frozen=True)
class DiscFloor:
    """How bright a light of one size is at least to stand out of clean pairs.

    Args:
        radius: Radius in pixels of an image 1242 wide.
        area: The disc's share of the image.
        floor: The brightest clean disc, grey levels, and what it can vouch for.
        peak: Peak of a Gaussian light whose mean over its disc is the floor, grey levels.
        noise: Three standard deviations of the mean over the disc, were single pixels' noise all
            there is; grey levels.
    """

    radius: float
    area: float
    floor: ToleranceThreshold
    peak: float
    noise: float


@dataclass(frozen=True)
class FaintLight:
    """Lights of one size and strength.

    Args:
        radius: Radius in pixels of an image 1242 wide.
        strength: Peak, grey levels.
        detected: The share of all pairs and draws that each of `RULES` detects; thresholds that
            come from real pairs are those of other scenes.
    """

    radius: float
    strength: float
    detected: Mapping[str, Share]


@dataclass(frozen=True)
class RealPairsResult:
    """The study.

    Args:
        rate: r, the designated false alarm rate.
        draws: Draws of the light's place in each pair.
        rendered: Threshold of brightness from rendered frames.
        origin: Where that comes from.
        raised: Threshold of brightness of all clean real pairs.
        pairs: Each clean pair.
        false_alarms: The share of false alarms, by `RULES`.
        floors: How bright a light has to be to stand out, by size.
        lights: The lights, by size and strength.
    """

    rate: float
    draws: int
    rendered: float
    origin: str
    raised: ToleranceThreshold
    pairs: Sequence[CleanPair]
    false_alarms: Mapping[str, Share]
    floors: Sequence[DiscFloor]
    lights: Sequence[FaintLight]
