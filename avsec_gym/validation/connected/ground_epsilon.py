"""Epsilon: how far apart surfaces of one piece of ground are (thesis, section 4.4.4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.base_station import SurfaceComparison, region_surface
from avsec_gym.validation.connected.cropping import cropped, mirrored
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.surfaces.distance import cell_differences
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_SIZE = (4.0, 2.0, 1.5)
_FLAT = 0.3
"""Metres: in a piece of ground no point of any vehicle is higher above the lowest one."""
_FEWEST = 20
_TRIALS = 400


def ground_epsilon(
    instants: Sequence[Sequence[VehicleScan]],
    comparison: SurfaceComparison = SurfaceComparison(),
    *,
    pieces: int = 20,
    seed: int = 0,
) -> float:
    """The mean distance between discretised surfaces of the ground.

    Pieces as large as a vehicle's region are drawn where two vehicles or more see nothing but
    ground; each is surfaced as a region is, and the differences of all cells are averaged.

    Args:
        instants: The attack-free scans of each instant.
        comparison: How surfaces are made; its epsilon plays no part.
        pieces: Pieces of ground of each instant, at most.
        seed: The seed that decides where they are.

    Returns:
        Metres.

    Raises:
        DataError: No two vehicles see one piece of ground.
    """
    random = np.random.default_rng(seed)
    means = []
    for scans in instants:
        if not any(len(scan.points) for scan in scans):
            continue
        regions = _anywhere(scans, random)
        of_vehicles = [cropped(scan, regions, comparison.margins) for scan in scans]
        found = 0
        for crops, size in zip(zip(*of_vehicles, strict=True), regions.size, strict=True):
            seen = [crop for crop in crops if len(crop) >= _FEWEST]
            if len(seen) < 2 or np.ptp(np.concatenate(seen)[:, 2]) > _FLAT:
                continue
            grids = [region_surface(mirrored(crop), size, comparison) for crop in seen]
            differences = cell_differences(grids[0], grids[1])
            if len(differences):
                means.append(float(differences.mean()))
                found += 1
            if found == pieces:
                break
    if not means:
        raise DataError(
            "No two vehicles see one piece of ground, so that epsilon cannot be measured.",
            remedy="Give more instants, or vehicles that are nearer to each other.",
        )
    return float(np.mean(means))


def _anywhere(scans: Sequence[VehicleScan], random: np.random.Generator) -> Regions:
    """Regions about points that some vehicle scanned, at any heading."""
    every: Floats = np.concatenate([scan.in_world() for scan in scans])
    centre = every[random.integers(len(every), size=_TRIALS)]
    heading = random.uniform(-np.pi, np.pi, _TRIALS)
    return Regions(centre, np.tile(_SIZE, (_TRIALS, 1)), heading)
