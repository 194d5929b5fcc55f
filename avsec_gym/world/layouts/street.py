"""Street scenes: parked rows, standing and flowing traffic, side streets, quiet streets.

The numbers are choices calibrated on aggregate statistics of KITTI's labels and of the labelled
driving-safety scenarios; `docs/layouts.md` compares the outcome.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.layouts.dimensions import CategoryMix
from avsec_gym.world.layouts.people import place_people
from avsec_gym.world.layouts.road import LayoutRoad, Placed, join, place_freely, place_row

_PARKED = CategoryMix(Car=0.91, Van=0.06, Misc=0.022, Truck=0.008)
_FLOWING = CategoryMix(Car=0.90, Van=0.07, Misc=0.015, Truck=0.015)

_PARKED_SHARE, _FLOWING_SHARE = 319 / 432, 69 / 432
"""Shares of the street scenes; the rest has no cars at all."""

_ROWS = ((0,), (1,), (0, 1))
_ROW_STEPS = (0.20, 0.38)
"""Parked rows on the right only (20 %), on the left only (18 %), or on both sides."""


def street(rng: np.random.Generator) -> tuple[LayoutRoad, Placed]:
    """Draw one street: with parked rows, with flowing traffic, or quiet (people only).

    The shares are those of the labelled scenarios.  Nothing but people moves beside parked rows:
    there all traffic stands, as those scenarios have it.
    """
    kind = rng.random()
    if kind < _PARKED_SHARE:
        return _residential(rng)
    if kind < _PARKED_SHARE + _FLOWING_SHARE:
        return _flowing(rng)
    road = _road(rng, (0.0, 3.5))
    kerb = 2.0 + 2.5 * rng.random()
    return road, place_people(rng, kerb, kerb, likely=1.0, more=0.42)


def _residential(rng: np.random.Generator) -> tuple[LayoutRoad, Placed]:
    """Parked rows on one or both sides, perhaps standing traffic and side streets."""
    sight = 26.0 + 42.0 * rng.beta(1.1, 1.7)
    fullness = rng.beta(0.60, 0.46)
    # A few rows on the right stand beyond a lane of their own, a cycle path or a green strip.
    right = 2.35 + 0.5 * rng.standard_exponential()
    right += float(rng.random() < 0.14) * (1.5 + 4.0 * rng.random())
    wide = rng.random() < 0.55
    left = 4.8 + 1.9 * rng.random() if wide else 2.5 + 1.1 * rng.random()
    angles = _bay_angles(rng, 0.20, 0.38 if wide else 0.10)
    rows = _ROWS[int(np.searchsorted(_ROW_STEPS, rng.random()))]
    starts = np.where(rng.random(2) < 0.80, -9.0 + 6.0 * rng.random(2), 22.0 * rng.random(2))
    road = _road(rng, (0.0, 0.55 * left) if wide else (0.0,))

    parts = []
    for side in rows:
        line, angle = (-right, left)[side], float(angles[side])
        parts.append(
            place_row(
                rng,
                _PARKED,
                start=float(starts[side]),
                end=sight,
                left=line + np.sign(line) * 1.5 * abs(np.sin(angle)),
                gap=0.55 if angle == 0.0 else 0.35,
                fullness=fullness,
                lull=30.0,
                backwards=(0.22, 0.93)[side] if angle == 0.0 else 0.45,
                angle=angle,
                jitter=0.16 if angle == 0.0 else 0.3,
            )
        )
    parts.append(_standing_traffic(rng, sight, 0.5 * left if wide else None))
    parts.append(_side_street(rng, right, left))
    if rng.random() < 0.38:
        parts.append(_car_park(rng, right, left, sight))
    parts.append(place_people(rng, right, left, likely=0.31, more=0.33))
    return road, join(parts)


def _flowing(rng: np.random.Generator) -> tuple[LayoutRoad, Placed]:
    """A wider street with vehicles ahead and oncoming ones, few of them parked."""
    oncoming = 3.2 + 1.5 * rng.random() if rng.random() < 0.35 else 8.5 + 4.0 * rng.random()
    road = _road(rng, (0.0, oncoming))
    # Traffic ahead, and oncoming traffic.
    parts = [
        place_row(
            rng,
            _FLOWING,
            start=7.0 + 22.0 * rng.random(),
            end=66.0,
            left=0.7 * rng.standard_normal() + 0.4,
            gap=5.0,
            fullness=0.1,
            lull=26.0,
            moving=True,
        ),
        place_row(
            rng,
            _FLOWING,
            start=8.0,
            end=66.0,
            left=oncoming,
            gap=5.0,
            fullness=0.15,
            lull=24.0,
            backwards=1.0,
            jitter=0.35,
            moving=True,
        ),
    ]
    # Beside the road: a parked row now and then, a side street, people.
    kerb = 3.0 + 1.2 * rng.random()
    if rng.random() < 0.45:
        parts.append(
            place_row(
                rng,
                _PARKED,
                start=2.0 + 20.0 * rng.random(),
                end=45.0,
                left=-kerb,
                gap=0.8,
                fullness=0.5,
                lull=14.0,
                backwards=0.1,
            )
        )
    parts.append(_side_street(rng, kerb, oncoming + 2.0))
    parts.append(place_people(rng, kerb + 1.0, oncoming + 2.0, likely=0.30, more=0.2))
    return road, join(parts)


def _standing_traffic(rng: np.random.Generator, sight: float, oncoming: float | None) -> Placed:
    """Vehicles that wait in the lanes: a short queue ahead, a stopped oncoming one."""
    ahead = int(rng.integers(1, 4)) if rng.random() < 0.13 else 0
    against = int(rng.random() < 0.25) if oncoming is not None else 0
    along = np.concatenate(
        [
            8.0 + 22.0 * rng.random() + np.cumsum(8.0 + 6.0 * rng.standard_exponential(ahead)),
            10.0 + (sight - 10.0) * rng.random(against),
        ]
    )
    left = np.repeat([0.2, oncoming or 0.0], [ahead, against]) + 0.4 * rng.standard_normal(
        ahead + against
    )
    heading = np.repeat([0.0, np.pi], [ahead, against]) + 0.04 * rng.standard_normal(len(along))
    return place_freely(rng, _PARKED, along, left, heading, np.zeros(len(along), bool))


def _side_street(rng: np.random.Generator, right: float, left: float) -> Placed:
    """Vehicles that stand across, at the mouths of side streets and in drives."""
    count = int(rng.poisson(0.8))
    along = 10.0 + 45.0 * rng.random(count)
    on_left = rng.random(count) < 0.55
    beside = 4.0 + 10.0 * rng.random(count)
    lateral = np.where(on_left, left + beside, -right - beside)
    heading = np.where(rng.random(count) < 0.5, -0.5, 0.5) * np.pi + 0.22 * rng.standard_normal(
        count
    )
    return place_freely(rng, _PARKED, along, lateral, heading, np.zeros(count, bool))


def _car_park(rng: np.random.Generator, right: float, left: float, sight: float) -> Placed:
    """A further row away from the road, along it or at a right angle."""
    angle = 0.5 * np.pi if rng.random() < 0.45 else 0.0
    away = 5.5 + 8.0 * rng.random()
    return place_row(
        rng,
        _PARKED,
        start=8.0 + 25.0 * rng.random(),
        end=sight,
        left=left + away if rng.random() < 0.48 else -right - away,
        gap=0.5,
        fullness=0.82,
        lull=12.0,
        backwards=0.55,
        angle=angle,
        jitter=0.25,
    )


def _bay_angles(rng: np.random.Generator, right: float, left: float) -> Floats:
    """How the cars of the two rows park: along the road (0), across it, or slanted."""
    bays = rng.random(2) < (right, left)
    slanted = rng.random(2) < 0.40
    slant = np.where(rng.random() < 0.5, -1.0, 1.0) * (0.72 + 0.12 * rng.standard_normal(2))
    return np.where(bays, np.where(slanted, slant, 0.5 * np.pi), 0.0)


def _road(rng: np.random.Generator, lane_offsets: tuple[float, ...]) -> LayoutRoad:
    """A mostly straight street that the ego vehicle mostly follows."""
    turning, bending = rng.random(2)
    heading, curvature = rng.standard_normal(2)
    return LayoutRoad(
        heading=float(heading) * (0.024 if turning < 0.8 else 0.13),
        curvature=float(curvature) * (0.0006 if bending < 0.75 else 0.006),
        lane_offsets=tuple(float(offset) for offset in lane_offsets),
    )
