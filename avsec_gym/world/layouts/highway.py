"""Highway scenes: traffic ahead and oncoming, and standing queues in the lanes beside.

The numbers are choices calibrated on aggregate statistics of the labelled driving-safety
scenarios; `docs/layouts.md` compares the outcome.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.world.layouts.dimensions import CategoryMix
from avsec_gym.world.layouts.road import LayoutRoad, Placed, join, place_freely, place_row

_FLOWING = CategoryMix(Car=0.73, Truck=0.175, Van=0.085, Misc=0.01)
_QUEUE = CategoryMix(Car=0.73, Van=0.14, Misc=0.115, Truck=0.015)
_CYCLIST = CategoryMix(Cyclist=0.85, Pedestrian=0.15)

_QUEUE_SHARE = 0.30
_LANE_WIDTH = 3.75


def highway(rng: np.random.Generator) -> tuple[LayoutRoad, Placed]:
    """Draw one highway: free flow with oncoming traffic, or queues beside the ego vehicle."""
    # The road: its lanes, and a bend now and then.
    queue = rng.random() < _QUEUE_SHARE
    first = 3.8 + 1.2 * rng.random()
    oncoming = 10.6 + 3.6 * rng.random()
    shift = 0.4 + 0.3 * rng.standard_normal()
    bending = rng.random() < 0.30 and not queue
    heading, curvature = rng.standard_normal(2)
    road = LayoutRoad(
        heading=float(heading) * (0.05 if bending else 0.012),
        curvature=float(curvature) * (0.0045 if bending else 0.0003),
        lane_offsets=(0.0, float(first)),
        lane_width=_LANE_WIDTH,
    )
    # The ego vehicle's direction: its own lane, and queues or free lanes beside it.
    parts = [_lane_ahead(rng, shift)]
    if queue:
        parts += _queues(rng, first)
    else:
        parts += [
            _lane_ahead(rng, shift + side, likely)
            for side, likely in ((_LANE_WIDTH, 0.14), (-_LANE_WIDTH, 0.24))
        ]
    # Oncoming traffic on one or two lanes, and what stands beside the road.
    if rng.random() < (0.12 if queue else 0.85):
        parts += [
            place_row(
                rng,
                _FLOWING,
                start=-8.0,
                end=77.0,
                left=oncoming + lane,
                gap=7.0,
                fullness=0.0,
                lull=38.0,
                backwards=1.0,
                jitter=0.35,
                moving=True,
            )
            for lane in (0.0, _LANE_WIDTH)[: 1 + int(rng.random() < 0.5)]
        ]
    if rng.random() < 0.12:
        parts.append(_beside_the_road(rng))
    return road, join(parts)


def _lane_ahead(rng: np.random.Generator, left: float, likely: float = 0.96) -> Placed:
    """A lane of the ego vehicle's direction, vehicles at highway distances."""
    empty = rng.random() >= likely
    return place_row(
        rng,
        _FLOWING,
        start=-1.0 + 24.0 * rng.random(),
        end=0.0 if empty else 77.0,
        left=left,
        gap=8.0,
        fullness=0.0,
        lull=24.0,
        jitter=0.25,
        moving=True,
    )


def _queues(rng: np.random.Generator, first: float) -> list[Placed]:
    """One to three lanes to the left in which the traffic stands."""
    lanes = 1 + int(np.searchsorted((0.1, 0.65), rng.random()))
    return [
        place_row(
            rng,
            _QUEUE,
            start=-5.0 + 12.0 * rng.random(),
            end=38.0 + 34.0 * rng.random(),
            left=first + 3.6 * lane,
            gap=2.4,
            fullness=0.88,
            lull=9.0,
            jitter=0.22,
        )
        for lane in range(lanes)
    ]


def _beside_the_road(rng: np.random.Generator) -> Placed:
    """Cyclists and people on a path to the right of the road, beyond its shoulder."""
    count = 1 + int(rng.poisson(0.6))
    along = 15.0 + 40.0 * rng.random(count)
    lateral = -(7.0 + 4.0 * rng.random(count))
    heading = np.where(rng.random(count) < 0.4, np.pi, 0.0) + 0.1 * rng.standard_normal(count)
    return place_freely(rng, _CYCLIST, along, lateral, heading, np.ones(count, bool))
