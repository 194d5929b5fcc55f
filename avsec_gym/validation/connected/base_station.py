"""What the base station does (thesis, section 4.4): merge regions, distribute, compare, decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.cropping import CropMargins
from avsec_gym.validation.connected.merging import merged_regions, regions_in_world
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.region_message import (
    BASE_STATION,
    MOST_REGIONS,
    RegionMessage,
)
from avsec_gym.validation.connected.naming import attacked_vehicles, is_alarm
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh
from avsec_gym.validation.connected.surfaces.distance import THESIS_EPSILON, distances_of_all
from avsec_gym.validation.connected.surfaces.grid import surface_grid
from avsec_gym.validation.connected.surfaces.mesh import Mesher


@dataclass(frozen=True)
class SurfaceComparison:
    """How the base station compares surfaces.

    Args:
        mesher: The mesher, which makes the surface mesh of a crop.
        epsilon: The mean distance of ground surfaces, metres; see `ground_epsilon`.
        margins: How much more than a region the vehicles crop, which the grids cover.
        fewest_points: Crops with fewer points have no surface.
    """

    mesher: Mesher = delaunay_mesh
    epsilon: float = THESIS_EPSILON
    margins: CropMargins = field(default_factory=CropMargins)
    fewest_points: int = 10


@dataclass(frozen=True, eq=False)
class RegionDecision:
    """What the base station decides of a region.

    Args:
        distances: Distances of all pairs of vehicles, metres, shape (n, n), NaN where nothing was
            compared.
        attacked: The vehicles that are named.
        alarm: Whether some distance exceeds theta, whoever is attacked.
    """

    distances: Floats
    attacked: frozenset[int]
    alarm: bool


def complete_set_of_regions(messages: Sequence[RegionMessage]) -> RegionMessage:
    """Step 2, second half: all proposals in the world frame, duplicates joined, for every vehicle.

    Its frame has the axes of the world and its origin in the midst of the regions, so that they are
    exact to the centimetre wherever in the world they are.
    """
    proposed = [regions_in_world(message.regions, message.pose) for message in messages]
    regions = merged_regions(proposed, most=MOST_REGIONS)
    pose = np.eye(4)
    if len(regions):
        pose[:3, 3] = np.round((regions.centre.min(axis=0) + regions.centre.max(axis=0)) / 2)
    local = Regions(regions.centre - pose[:3, 3], regions.size, regions.heading)
    return RegionMessage(BASE_STATION, pose, local)


def region_distances(
    complete_set: RegionMessage,
    messages: Sequence[CropMessage],
    vehicles: int,
    comparison: SurfaceComparison = SurfaceComparison(),
) -> Floats:
    """Steps 4 and 5: surfaces of every region and vehicle, and their distances.

    Args:
        complete_set: The regions that were distributed.
        messages: The vehicles' crops; one that does not answer for each region is left out.
        vehicles: Number of vehicles, n.
        comparison: How surfaces are made and compared.

    Returns:
        Shape (regions, n, n), metres; NaN where nothing was compared.
    """
    count = len(complete_set.regions)
    crops = {message.sender: message.crops for message in messages if len(message.crops) == count}
    distances = np.full((count, vehicles, vehicles), np.nan)
    for index in range(count):
        grids: list[Floats | None] = [None] * vehicles
        for sender, of_sender in crops.items():
            if sender < vehicles and len(of_sender[index]) >= comparison.fewest_points:
                size = complete_set.regions.size[index]
                grids[sender] = region_surface(of_sender[index], size, comparison)
        distances[index] = distances_of_all(grids, comparison.epsilon)
    return distances


def region_surface(points: Floats, size: Floats, comparison: SurfaceComparison) -> Floats:
    """dsm_{i,j}: the surface of a region as a vehicle scanned it, as a grid of heights.

    Args:
        points: The vehicle's mirrored crop, in the region's frame, shape (M, 3).
        size: Length, width, height of the region, metres.
        comparison: How surfaces are made.
    """
    length, width = size[:2] + 2 * comparison.margins.sides
    return surface_grid(comparison.mesher(points), length, width)


def decide(distances: Floats, threshold: float) -> list[RegionDecision]:
    """Step 6: for each region, whether there was an attack, and on whom.

    Args:
        distances: Distances as `region_distances` returns them, shape (regions, n, n).
        threshold: Theta, metres; see `distance_threshold`.
    """
    return [
        RegionDecision(each, attacked_vehicles(each, threshold), is_alarm(each, threshold))
        for each in distances
    ]
