"""Witnesses: the rays of one vehicle, held against what another vehicle claims."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.claims import Claims, heading_vectors
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.rays.ray_outcomes import WitnessView, fill_counts, fill_outcomes
from avsec_gym.validation.connected.regions import Regions

_LEAST_REACH = 1e-4
"""Radians: narrower is no sensor's beam."""
_MOST = {
    "reach": 0.1,
    "around": 10.0,
    "around_sigmas": 10.0,
    "side": 10.0,
    "beyond": 10.0,
    "below": 10.0,
    "resolved": 1000.0,
    "fastest": 100.0,
    "farthest": 1000.0,
    "position_noise": 10.0,
    "heading_noise": 1.0,
}
"""The largest number of each margin, in its unit."""


@dataclass(frozen=True)
class WitnessMargins:
    """How far things may lie apart and still be the same.

    Args:
        reach: Smallest angle up to which rays around a voxel are looked at, radians; at least two
            rays of the sensor must lie within.
        around: How far from a voxel rays are looked at, metres...
        around_sigmas: ... and by so many standard deviations of the poses, to the sides.
        side: What a region's box is grown by at its sides, metres.  Little: with errors of poses,
            rays around a voxel are looked at, and what ends beside a box but near the voxel
            decides nothing; a wider box would let a ghost's neighbours speak for it.
        beyond: How far behind a voxel a ray must end to have passed through it, metres.
        below: How far below a voxel rays that end in the region's box show that something stands
            there, only lower: what rays pass over its top then decides nothing, metres.
        resolved: Farthest distance at which a witness' rays count, metres: beyond, low or narrow
            things fit between them.
        fastest: Greatest speed of things that no vehicle tracks, m/s; see `count_rays`.
        farthest: Distance up to which a ray that returns nothing is one that met nothing, metres;
            dark things far away send nothing back.
        position_noise: Standard deviation of measured positions along x and along y, metres.
        heading_noise: Standard deviation of measured headings, radians.

    Raises:
        ConfigurationError: A number that is below 0, or above what any sensor or road has.
    """

    reach: float = float(np.radians(0.4))
    around: float = 0.15
    around_sigmas: float = 1.5
    side: float = 0.1
    beyond: float = 0.5
    below: float = 0.5
    resolved: float = 50.0
    fastest: float = 35.0
    farthest: float = 40.0
    position_noise: float = 0.2
    heading_noise: float = float(np.radians(0.2))

    def __post_init__(self) -> None:
        for name, most in _MOST.items():
            number(name, getattr(self, name), _LEAST_REACH if name == "reach" else 0.0, most)

    def apart(self, distance: Floats) -> Floats:
        """Standard deviation of a place that a vehicle sees so far away, metres."""
        return np.asarray(np.hypot(self.position_noise, self.heading_noise * distance))


def _look_of(
    witness: Observer, claims: Claims, regions: Regions, margins: WitnessMargins, since: Floats
) -> WitnessView:
    """What one witness needs to look at claims.

    Args:
        witness: Who looks.
        claims: What is looked at, C claims.
        regions: The regions of the claims.
        margins: How far things may lie apart.
        since: When each claim holds, seconds after the instant, shape (C,).
    """
    chosen = regions[claims.region]
    away = np.hypot(*(chosen.centre[:, :2] - witness.pose[:2, 3]).T)
    apart = np.sqrt(2.0) * margins.apart(away)
    return WitnessView(
        witness.image,
        witness.pose,
        np.asarray(np.linalg.inv(witness.pose)),
        witness.motion,
        claims.places(regions),
        claims.count,
        witness.scan.time - since,
        chosen.centre,
        heading_vectors(chosen),
        chosen.size / 2 + margins.side,
        margins.around + margins.around_sigmas * apart,
        margins.reach,
        margins.around,
        margins.beyond,
        margins.below,
        margins.farthest,
        margins.resolved,
    )


def outcomes(
    witness: Observer,
    claims: Claims,
    regions: Regions,
    margins: WitnessMargins,
    velocity: Floats | None = None,
) -> NDArray[np.int8]:
    """What each claimed voxel meets in a witness' range image.

    Args:
        witness: The vehicle that looks.
        claims: What another vehicle claims.
        regions: The regions that all vehicles share.
        margins: What may lie apart.
        velocity: How fast what is claimed moves along the world's x and y, since the time of the
            claim, m/s, shape (C, 2); None: as the claims have it, since the instant.

    Returns:
        `SUPPORT`, `THROUGH`, ... for each voxel, shape (V,).
    """
    since = claims.time
    if velocity is None:
        velocity, since = claims.velocity, np.zeros(len(claims))
    result = np.empty(len(claims.voxel), np.int8)
    fill_outcomes(_look_of(witness, claims, regions, margins, since), velocity, result)
    return result


def count_outcomes(
    witness: Observer,
    claims: Claims,
    regions: Regions,
    margins: WitnessMargins,
    velocities: Floats | None = None,
    needed: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]:
    """How many voxels of each claim a witness' rays support, pass through, and miss.

    Args:
        witness: The vehicle that looks.
        claims: What another vehicle claims.
        regions: The regions that all vehicles share.
        margins: What may lie apart.
        velocities: Several velocities that what is claimed may have had along the world's x and y,
            since the time of the claim, m/s, shape (S, C, 2); None: one, as of `outcomes`.
        needed: Number of supported voxels below which it does not matter how many, shape (C,);
            None: all are counted.

    Returns:
        Numbers of `SUPPORT`, `THROUGH` and `MISSING`, shape (S, C, 3); 0 for less than what is
        needed.
    """
    since = claims.time
    if velocities is None:
        velocities, since = claims.velocity[None], np.zeros(len(claims))
    if needed is None:
        needed = np.zeros(len(claims), np.int64)
    counts = np.zeros((*velocities.shape[:2], 3), np.int64)
    fill_counts(_look_of(witness, claims, regions, margins, since), velocities, needed, counts)
    return counts
