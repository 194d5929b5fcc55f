"""An instant by surfaces, the thesis' method: crops, meshes, grids, distances, algorithms 1, 2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.accusation import ACCUSERS, upheld_by_distances
from avsec_gym.validation.connected.admission import admitted_crops
from avsec_gym.validation.connected.base_station import (
    SurfaceComparison,
    decide,
    region_distances,
)
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.merged_proposals import MergedProposals
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.traffic import MessageKind, SentMessages
from avsec_gym.validation.connected.vehicle import scan_of_regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True, eq=False)
class ComparedSurfaces:
    """The decision from the surfaces of an instant.

    Args:
        distances: Distances of all pairs of vehicles, metres, shape (R, V, V), NaN where nothing
            was compared.
        top: The highest point that each vehicle has in each region above its bottom, metres, shape
            (R, V); NaN without points.
    """

    distances: Floats
    top: Floats


def exchange_surfaces(
    scans: Sequence[VehicleScan],
    merged: MergedProposals,
    comparison: SurfaceComparison,
    traffic: SentMessages,
) -> ComparedSurfaces:
    """Steps 3 to 5.

    Args:
        scans: The scan of each vehicle, by number.
        merged: The regions.
        comparison: How surfaces are made and compared.
        traffic: The record that takes the messages.
    """
    arrived: list[CropMessage] = []
    for number, scan in enumerate(scans):
        with traffic.step("crop"):
            message = scan_of_regions(number, scan, merged.complete_set, comparison.margins)
        read = traffic.send(MessageKind.CROPS, number, message.to_bytes(), CropMessage.from_bytes)
        arrived += [CropMessage(number, each.crops) for each in read]
    with traffic.step("compare"):
        taken = admitted_crops(arrived, merged.complete_set, comparison.margins)
        distances = region_distances(merged.complete_set, taken, len(scans), comparison)
    top = np.full(distances.shape[:2], np.nan)
    for crops in taken:
        for index, crop in enumerate(crops.crops):
            if len(crop):
                top[index, crops.sender] = crop[:, 2].max()
    return ComparedSurfaces(distances, top)


@dataclass(frozen=True, eq=False)
class SurfaceDecision:
    """What is decided of each region; see `ConnectedResult`."""

    score: Floats
    probability: Floats
    ghost: Floats
    removal: Floats
    named: NDArray[np.int64]


def decide_by_surfaces(
    compared: ComparedSurfaces, merged: MergedProposals, constants: ConnectedConstants
) -> SurfaceDecision:
    """Step 6, with accusations that enough independent vehicles uphold.

    The thesis names vehicles; whether the one that is named has something too much or too little
    is read off the tops of the surfaces: a ghost stands out of what the others saw.
    """
    distances, authors = compared.distances, merged.authors
    vehicles = distances.shape[1]
    largest = np.where(np.isnan(distances), -np.inf, distances).max(axis=(1, 2), initial=-np.inf)
    named = np.full(len(distances), NO_ATTACK)
    ghost, removal = np.zeros((2, len(distances), vehicles))
    needed = ACCUSERS + constants.rule.liars
    for index, decided in enumerate(decide(distances, constants.theta)):
        if not decided.alarm:
            continue
        upheld = upheld_by_distances(
            decided.attacked,
            decided.distances,
            constants.theta,
            int(authors[index]),
            needed,
        )
        # Of several that are named in one region, a sole one would be no finding.
        named[index] = next(iter(upheld)) if len(upheld) == 1 else CANNOT_TELL
        victims = sorted(decided.attacked) or list(range(vehicles))
        median = np.nanmedian(compared.top[index])
        for victim in victims:
            stands_out = bool(compared.top[index, victim] >= median)
            (ghost if stands_out else removal)[index, victim] = 1 / len(victims)
    probability = constants.of_distance.probability(np.maximum(largest, 0.0))
    return SurfaceDecision(
        largest, np.where(np.isfinite(largest), probability, 0.0), ghost, removal, named
    )
