"""The trees of a German street: the numbers in which species differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from avsec_gym.world.material import Material

Detail = Literal["near", "middle", "far"]
"""How finely a plant is made: nearer than 35 m, to 80 m, and beyond."""

_SLENDER = ((0.0, 0.35), (0.25, 0.85), (0.55, 1.0), (0.85, 0.6), (1.0, 0.1))
_ROUND = ((0.0, 0.55), (0.2, 0.92), (0.45, 1.0), (0.75, 0.82), (1.0, 0.4))
_BROAD = ((0.0, 0.6), (0.25, 1.0), (0.5, 0.98), (0.8, 0.75), (1.0, 0.4))
_CONE = ((0.0, 0.85), (0.08, 1.0), (0.5, 0.55), (1.0, 0.03))
_FLAME = ((0.0, 0.5), (0.15, 0.9), (0.4, 1.0), (0.75, 0.7), (1.0, 0.12))
_DOME = ((0.0, 0.45), (0.35, 1.0), (0.7, 0.9), (1.0, 0.3))


@dataclass(frozen=True)
class Species:
    """A species' habit; lengths are shares of the tree's height unless metres are named."""

    heights: tuple[float, float]
    """Heights of the lowest and the highest variant, metres."""
    bark: Material
    leaves: str
    """Texture family."""
    clear: float
    """Height of the lowest leaves."""
    spread: float
    """Greatest radius of the crown."""
    outline: tuple[tuple[float, float], ...]
    """Height within the crown and radius relative to the greatest one, from the bottom up."""
    clusters: int = 34
    """Clusters of leaves."""
    cluster: float = 0.42
    """Radius of a cluster, as a share of the crown's radius."""
    flatness: float = 0.75
    """Height of a cluster relative to its width."""
    leader: float = 0.55
    """How far up the crown the trunk can be followed."""
    girth: float = 0.018
    """Radius of the trunk at the ground."""
    hang: float = 0.25
    """How much sprays hang: 0 they spread as they like, 1 they hang straight down."""
    cover: float = 0.42
    """Area of the leaves relative to that of the clusters."""
    shade: float = 0.78
    """Size of the dark inside of the clusters; 0 for a tree through which one sees the sky."""
    brightness: float = 1.0
    """Brightness of the leaves, relative to their texture."""
    whorled: bool = False
    """Branches in tiers round one trunk, each a flat drooping frond (spruce, fir)."""
    staked: bool = False
    """A young tree tied to posts."""


_LIME_BARK = Material("bark_rough/0")
_GREY_BARK = Material("bark_rough/1")
_DARK_BARK = Material("bark_rough/2")

SPECIES: dict[str, Species] = {
    "lime": Species(
        (11.0, 16.0), _GREY_BARK, "lime", 0.2, 0.31, _ROUND, clusters=40, cluster=0.36, hang=0.35
    ),
    "maple": Species((9.0, 14.0), _LIME_BARK, "maple", 0.24, 0.36, _BROAD, girth=0.02),
    "birch": Species(
        (10.0, 15.0),
        Material("bark_birch"),
        "birch",
        0.2,
        0.2,
        _FLAME,
        clusters=40,
        cluster=0.4,
        flatness=1.7,
        leader=0.92,
        girth=0.011,
        hang=0.85,
    ),
    "plane": Species(
        (12.0, 18.0),
        Material("bark_smooth/1"),
        "plane",
        0.26,
        0.38,
        _BROAD,
        clusters=36,
        cluster=0.36,
        leader=0.4,
        girth=0.02,
    ),
    "poplar": Species(
        (13.0, 18.0),
        _GREY_BARK,
        "poplar",
        0.07,
        0.115,
        _SLENDER,
        clusters=40,
        cluster=0.62,
        flatness=1.7,
        leader=0.9,
        girth=0.014,
        hang=-0.5,
    ),
    "spruce": Species(
        (9.0, 17.0),
        _DARK_BARK,
        "spruce",
        0.05,
        0.2,
        _CONE,
        clusters=64,
        leader=1.0,
        girth=0.012,
        hang=0.6,
        whorled=True,
        brightness=1.3,
    ),
    "pine": Species(
        (12.0, 18.0),
        Material("bark_pine"),
        "pine",
        0.55,
        0.2,
        _DOME,
        clusters=24,
        cluster=0.42,
        flatness=0.5,
        leader=0.8,
        girth=0.013,
        hang=-0.2,
        brightness=1.3,
    ),
    "copper_beech": Species(
        (8.0, 14.0),
        Material("bark_smooth/0"),
        "copper_beech",
        0.14,
        0.36,
        _ROUND,
        clusters=38,
        cluster=0.36,
        girth=0.02,
    ),
    "fruit": Species(
        (4.0, 6.0),
        _DARK_BARK,
        "fruit",
        0.28,
        0.42,
        _BROAD,
        clusters=26,
        cluster=0.4,
        leader=0.25,
        girth=0.022,
    ),
    "young": Species(
        (4.5, 6.5),
        _LIME_BARK,
        "lime",
        0.4,
        0.2,
        _ROUND,
        clusters=20,
        cluster=0.48,
        leader=0.85,
        girth=0.009,
        brightness=1.15,
        staked=True,
    ),
    "willow": Species(
        (8.0, 12.0),
        _LIME_BARK,
        "willow",
        0.12,
        0.42,
        _DOME,
        clusters=44,
        cluster=0.3,
        flatness=1.5,
        leader=0.4,
        girth=0.02,
        hang=0.95,
        cover=0.3,
        shade=0.82,
    ),
    "autumn": Species(
        (7.0, 12.0),
        _DARK_BARK,
        "autumn",
        0.22,
        0.32,
        _ROUND,
        clusters=34,
        cluster=0.36,
        leader=0.6,
        girth=0.018,
        cover=0.32,
        shade=0.0,
    ),
}
"""Species by name."""
