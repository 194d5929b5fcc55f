"""What rays and surfaces state of a region, as numbers that a small model learns from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.decision import DecisionRule, decide
from avsec_gym.validation.connected.rays.rates import RayRates, decidable, log_likelihood_ratio
from avsec_gym.validation.connected.regions import Regions

FEATURES = (
    "rays through, of the pair with most",
    "rays through, of all pairs",
    "rays that support, of all pairs",
    "rays without a return, of all pairs",
    "log-likelihood ratio, highest of a pair",
    "log-likelihood ratio, best explanation",
    "distance of surfaces, largest",
    "distance of surfaces, median",
    "surfaces compared",
    "witnesses",
    "claims that they tell of",
    "nearest vehicle",
    "second nearest vehicle",
)
"""Counts of rays and distances to vehicles as log(1 + x), ratios in nats, distances of surfaces in
metres; 0 where nothing was compared."""
_LARGEST_RATIO = 30.0
"""Nats beyond which ratios count no more."""
_FARTHEST = 100.0
"""Metres: how far a vehicle is that does not exist, or whose pose did not arrive."""


@dataclass(frozen=True, eq=False)
class RegionEvidence:
    """What the base station has heard of R regions by both methods, of V vehicles.

    Args:
        regions: The regions, world frame.
        counts: What witness ``k`` reports of the claim of ``j``, shape (R, V, V, 3).
        distances: Distances of the surfaces of all pairs, metres, shape (R, V, V), NaN where
            nothing was compared (equation 4.1).
        poses: The pose that each vehicle reported, by its number, shape (4, 4) each.
    """

    regions: Regions
    counts: NDArray[np.int64]
    distances: Floats
    poses: Mapping[int, Floats]

    def compared(self, rates: RayRates) -> NDArray[np.bool_]:
        """Whether rays or surfaces of two vehicles were compared in each region, shape (R,)."""
        by_rays = decidable(self.counts, rates).any(axis=(1, 2))
        return np.asarray(by_rays | np.isfinite(self.distances).any(axis=(1, 2)))


def region_features(evidence: RegionEvidence, rates: RayRates, rule: DecisionRule) -> Floats:
    """The features of each region, shape (R, F), in the order of `FEATURES`.

    They do not depend on how vehicles are numbered, and are of any number of vehicles.

    Args:
        evidence: What was heard of R regions.
        rates: The chances of rays.
        rule: How evidence of rays becomes a score.
    """
    counts = evidence.counts
    known = decidable(counts, rates) & ~np.eye(counts.shape[1], dtype=bool)
    # Rays: those of all testimonies that decide something, and what they weigh.
    rays = np.where(known[..., None], counts, 0)
    total = rays.sum(axis=(1, 2))
    through = rays[..., 1].max(axis=(1, 2), initial=0)
    ratio = np.where(known, log_likelihood_ratio(counts, rates), -np.inf)
    highest = _weighed(ratio.max(axis=(1, 2), initial=-np.inf))
    best = _weighed(decide(counts, rates, rule).score)
    # Surfaces: each pair once.
    largest, median, pairs = _of_surfaces(evidence.distances)
    # Who looks, and from how far.
    witnesses, claimers = known.any(axis=1).sum(axis=1), known.any(axis=2).sum(axis=1)
    nearest = _vehicle_distances(evidence)
    columns = (
        np.log1p(through),
        np.log1p(total[:, 1]),
        np.log1p(total[:, 0]),
        np.log1p(total[:, 2]),
        highest,
        best,
        largest,
        median,
        pairs,
        witnesses,
        claimers,
        np.log1p(nearest[:, 0]),
        np.log1p(nearest[:, 1]),
    )
    return np.stack([np.asarray(column, np.float64) for column in columns], axis=1)


def _weighed(ratio: Floats) -> Floats:
    """Ratios within `_LARGEST_RATIO`; 0, which speaks for nothing, where there is none."""
    return np.where(np.isfinite(ratio), np.clip(ratio, -_LARGEST_RATIO, _LARGEST_RATIO), 0.0)


def _of_surfaces(distances: Floats) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Largest and median distance of the pairs of each region, 0 without one, and their number."""
    upper = np.triu(np.ones(distances.shape[1:], bool), 1)
    of_pairs = np.sort(distances[:, upper], axis=1)
    number = np.isfinite(of_pairs).sum(axis=1)
    largest, median = np.zeros((2, len(of_pairs)))
    # What was not compared is sorted to the end.
    for region in np.flatnonzero(number):
        compared = of_pairs[region, : number[region]]
        largest[region], median[region] = compared[-1], np.median(compared)
    return largest, median, number


def _vehicle_distances(evidence: RegionEvidence) -> Floats:
    """Distances of the nearest and the second nearest vehicle along the ground, shape (R, 2)."""
    places = [pose[:2, 3] for pose in evidence.poses.values()]
    away = np.full((len(evidence.regions), max(len(places), 2)), _FARTHEST)
    for vehicle, place in enumerate(places):
        away[:, vehicle] = np.hypot(*(evidence.regions.centre[:, :2] - place).T)
    return np.minimum(np.sort(away, axis=1)[:, :2], _FARTHEST)
