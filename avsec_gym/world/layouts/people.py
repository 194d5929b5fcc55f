"""Pedestrians and cyclists beside, on and across the road."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.layouts.dimensions import CategoryMix
from avsec_gym.world.layouts.road import Placed, join, place_freely

_WALKING = CategoryMix(Pedestrian=0.93, Cyclist=0.07)
_RIDING = CategoryMix(Cyclist=1.0)


def place_people(
    rng: np.random.Generator, right: float, left: float, *, likely: float, more: float
) -> Placed:
    """Groups of people on the pavements and at crossings, and cyclists on their way.

    Args:
        rng: The source of chance.
        right: Distance of the parked row or the kerb to the right of the ego vehicle's line,
            metres.
        left: Distance to the left, metres.
        likely: Probability that people walk here.
        more: Probability that yet another group does; groups are geometrically distributed.

    Returns:
        The people; most of them move.
    """
    parts = [_riders(rng, right, left)]
    if rng.random() < likely:
        for _ in range(min(int(rng.geometric(1.0 - more)), 8)):
            parts.append(_group(rng, right, left))
    return join(parts)


def _group(rng: np.random.Generator, right: float, left: float) -> Placed:
    """One to several people close to each other, walking along the pavement or across the road."""
    size = 1 + int(rng.poisson(9.0 if rng.random() < 0.20 else 0.12))
    along = 3.0 + 7.5 * rng.gamma(1.7) + 2.2 * rng.standard_normal(size)
    if rng.random() < 0.28:
        centre = -right + (right + left) * rng.random()
        heading = -0.5 * np.pi if rng.random() < 0.5 else 0.5 * np.pi
    else:
        beside = 0.4 + 1.2 * rng.random()
        centre = left + beside if rng.random() < 0.45 else -right - beside
        heading = np.pi if rng.random() < 0.5 else 0.0
    lateral = centre + 1.1 * rng.standard_normal(size)
    facing = heading + 0.3 * rng.standard_normal(size)
    return place_freely(rng, _WALKING, along, lateral, facing, rng.random(size) < 0.8)


def _riders(rng: np.random.Generator, right: float, left: float) -> Placed:
    """Cyclists at the edge of the road or on a path beside it."""
    count = int(rng.poisson(0.44)) if rng.random() < 0.6 else 0
    along = 5.0 + 45.0 * rng.beta(1.0, 1.5, count)
    on_left = rng.random(count) < 0.4
    beside = np.where(rng.random(count) < 0.35, -1.2, 1.2 + 1.5 * rng.random(count))
    lateral = np.where(on_left, left + beside, -right - beside)
    facing = np.where(rng.random(count) < np.where(on_left, 0.7, 0.25), np.pi, 0.0)
    facing += 0.15 * rng.standard_normal(count)
    return place_freely(rng, _RIDING, along, lateral, facing, np.ones(count, bool))
