"""Places of connected vehicles at the usual errors: what the studies of chapter 4 judge."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from avsec_gym.experiments.chapter4.instant_cells import constants_under
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import FIVE, USUAL, ConnectedCondition, Part
from avsec_gym.progress import Progress, no_progress
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit

SEED = 7
"""Seed of these studies' places, which no run of the experiment has."""


def usual(vehicles: int) -> ConnectedCondition:
    """Positions 0.2 m, headings 0.2 degrees, clocks up to 0.1 s apart."""
    return replace(USUAL, vehicles=vehicles)


def usual_places(
    part: Part, limit: int, seed: int = SEED, on_progress: Progress = no_progress
) -> Iterator[ScannedPlace]:
    """The first places, each with five vehicles.

    Args:
        part: `FITTED`, of the training assets, or `JUDGED`, of the others.
        limit: Number of places.
        seed: Seed of the places.
        on_progress: Function that gets the number of places that are done, and of all.
    """
    for number in range(limit):
        yield ScannedPlace(seed, part, number, FIVE.vehicles)
        on_progress(number + 1, limit)


def shipped_constants() -> ConnectedConstants:
    """What the package's own fit makes of evidence, at the usual errors of poses."""
    return constants_under(read_connected_fit(SHIPPED_FIT), USUAL)
