"""Proportions of passenger cars and vans: which body a box of KITTI's sizes holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Body:
    """A body type at its usual length; lengths along the car are metres, heights shares.

    Args:
        length: Usual length of the body.
        front_overhang: Length from the front end to the front axle.
        rear_overhang: Length from the rear axle to the rear end.
        bonnet: Length from the front end to the windscreen's base.
        windscreen: Length over which the windscreen slopes.
        tailgate: Length over which the rear window slopes.
        boot: Length from the rear window's base to the rear end.
        nose: Height of the bonnet's front edge, share of the vehicle's height.
        cowl: Height of the windscreen's base.
        belt: Height of the rear windows' base.
        wheel: Radius of the wheels, metres.
        clearance: Height of the sill, metres.
        roundness: Length over which the front narrows, metres.
        squareness: Exponent of the plan's corners.
        roof: Width of the roof, share of the body's.
        windows: Rear and front edges of the windows, shares of the side from the rear to the
            windscreen.
        doors: Name of the texture that shows its seams.
        glass: Upper edge of the windows, share of the way from the belt to the roof.
        rear_glass: Lower and upper edge of the rear window; equal if there is none.
    """

    length: float
    front_overhang: float
    rear_overhang: float
    bonnet: float
    windscreen: float
    tailgate: float
    boot: float
    nose: float
    cowl: float
    belt: float
    wheel: float
    clearance: float
    roundness: float
    squareness: float
    roof: float
    windows: tuple[tuple[float, float], ...]
    doors: int
    glass: float = 0.90
    rear_glass: tuple[float, float] = (0.15, 0.85)


# fmt: off
_TWO = ((0.06, 0.46), (0.53, 0.97))
_THREE_DOOR = ((0.08, 0.40), (0.47, 0.97))
_THREE = ((0.02, 0.24), (0.29, 0.60), (0.65, 0.97))
_FRONT_ONLY = ((0.78, 0.97),)

BODIES = {
    "small": Body(
        3.7, 0.72, 0.56, 0.98, 0.80, 0.30, 0.11, 0.46, 0.63, 0.66,
        0.285, 0.19, 0.75, 2.5, 0.80, _TWO, 0,
    ),
    "three-door": Body(
        3.8, 0.76, 0.60, 1.05, 0.80, 0.34, 0.12, 0.46, 0.62, 0.67,
        0.285, 0.18, 0.70, 2.6, 0.80, _THREE_DOOR, 1,
    ),
    "compact": Body(
        4.15, 0.85, 0.72, 1.15, 0.82, 0.38, 0.12, 0.47, 0.63, 0.66,
        0.305, 0.18, 0.75, 2.7, 0.80, _TWO, 0,
    ),
    "saloon": Body(
        4.5, 0.88, 1.02, 1.28, 0.86, 0.66, 0.50, 0.46, 0.64, 0.67,
        0.31, 0.17, 0.75, 2.7, 0.77, _TWO, 0,
    ),
    "estate": Body(
        4.55, 0.88, 0.98, 1.28, 0.84, 0.36, 0.11, 0.46, 0.63, 0.66,
        0.31, 0.17, 0.75, 2.8, 0.79, _THREE, 0,
    ),
    "people carrier": Body(
        4.25, 0.88, 0.74, 0.98, 0.98, 0.26, 0.10, 0.43, 0.58, 0.59,
        0.305, 0.18, 0.75, 2.8, 0.82, _THREE, 0,
    ),
    "off-roader": Body(
        4.3, 0.80, 0.78, 1.15, 0.62, 0.24, 0.09, 0.50, 0.60, 0.61,
        0.345, 0.26, 0.45, 3.6, 0.84, _THREE, 0,
    ),
    "box car": Body(
        4.2, 0.86, 0.70, 1.02, 0.66, 0.08, 0.05, 0.44, 0.56, 0.57,
        0.30, 0.19, 0.60, 3.4, 0.86, _THREE, 2,
    ),
    "delivery car": Body(
        4.2, 0.86, 0.70, 1.02, 0.66, 0.08, 0.05, 0.44, 0.56, 0.57,
        0.30, 0.19, 0.60, 3.4, 0.86, ((0.62, 0.97),), 2, 0.86, (0.18, 0.80),
    ),
    "minibus": Body(
        4.9, 0.92, 0.98, 0.78, 0.72, 0.12, 0.05, 0.43, 0.53, 0.53,
        0.325, 0.20, 0.55, 3.8, 0.88, _THREE, 2, 0.80, (0.12, 0.76),
    ),
    "panel van": Body(
        4.9, 0.92, 0.98, 0.80, 0.72, 0.10, 0.05, 0.43, 0.53, 0.53,
        0.325, 0.20, 0.55, 3.8, 0.88, _FRONT_ONLY, 2, 0.80, (0.20, 0.72),
    ),
    "large van": Body(
        5.7, 0.98, 1.15, 0.88, 0.78, 0.05, 0.05, 0.36, 0.46, 0.47,
        0.34, 0.22, 0.55, 4.2, 0.88, _FRONT_ONLY, 2, 0.60, (0.14, 0.50),
    ),
}
# fmt: on


@dataclass(frozen=True)
class CarDesign:
    """One car in metres: x from its centre, z from the ground.

    Args:
        name: Body type.
        body: Its proportions.
        length: Length of the box.
        half_width: Half of the body's width without the mirrors.
        height: Height of the roof.
        front_axle: Coordinate x of the front axle.
        rear_axle: Coordinate x of the rear axle.
        bonnet: Coordinate x of the windscreen's base.
        roof_front: Coordinate x of the windscreen's upper edge.
        roof_rear: Coordinate x of the rear window's upper edge.
        boot: Coordinate x of the rear window's base.
        nose: Height z of the bonnet's front edge.
        cowl: Height z of the windscreen's base.
        belt: Height z of the rear windows' base.
        wheel: Radius.
        sill: Height z of the sill.
    """

    name: str
    body: Body
    length: float
    half_width: float
    height: float
    front_axle: float
    rear_axle: float
    bonnet: float
    roof_front: float
    roof_rear: float
    boot: float
    nose: float
    cowl: float
    belt: float
    wheel: float
    sill: float


def draw_design(
    rng: np.random.Generator, name: str, height: float, width: float, length: float
) -> CarDesign:
    """A car of a body type that fills a box, with small differences by chance."""
    body = BODIES[name]
    along = length / body.length
    jitter = 1.0 + 0.06 * np.clip(rng.standard_normal(6), -2, 2)
    level = 0.012 * np.clip(rng.standard_normal(3), -2, 2)
    front, rear = 0.5 * length, -0.5 * length
    wheel = float(
        np.clip(body.wheel * jitter[0] * (0.5 + 0.5 * along), 0.25, 0.185 * height + 0.08)
    )
    bonnet = front - body.bonnet * along * jitter[1]
    boot = rear + body.boot * along * (jitter[2] if body.boot > 0.1 else 1.0)
    return CarDesign(
        name=name,
        body=body,
        length=length,
        half_width=0.5 * width - 0.045,
        height=height,
        front_axle=front - body.front_overhang * along * (0.5 + 0.5 * jitter[3]),
        rear_axle=rear + body.rear_overhang * along * (0.5 + 0.5 * jitter[4]),
        bonnet=bonnet,
        roof_front=bonnet - body.windscreen * along * jitter[5],
        roof_rear=boot + body.tailgate * along * jitter[2],
        boot=boot,
        nose=height * (body.nose + level[0]),
        cowl=height * (body.cowl + level[1]),
        belt=height * (body.belt + level[2]),
        wheel=wheel,
        sill=body.clearance * min(1.0, height / 1.45),
    )


def choose_car(rng: np.random.Generator, height: float, length: float) -> str:
    """A body type for a box of the category Car."""
    if height > 1.72:
        names = ("off-roader", "people carrier", "box car")
        shares = (0.45, 0.35, 0.20) if length > 3.9 else (0.3, 0.3, 0.4)
    elif height > 1.58:
        names = ("people carrier", "off-roader", "small" if length < 3.9 else "compact")
        shares = (0.5, 0.12, 0.38)
    elif length < 3.95:
        names, shares = ("small", "three-door", "compact"), (0.45, 0.33, 0.22)
    elif length < 4.25:
        names, shares = ("compact", "saloon", "estate"), (0.68, 0.16, 0.16)
    else:
        names, shares = ("saloon", "estate", "compact"), (0.47, 0.45, 0.08)
    return str(names[int(rng.choice(3, p=shares))])


def choose_van(rng: np.random.Generator, height: float, length: float) -> str:
    """A body type for a box of the category Van."""
    if length < 4.5 and height < 2.15:
        names = ("delivery car", "box car", "minibus" if height > 1.9 else "people carrier")
        shares = (0.4, 0.35, 0.25)
    elif height < 2.25:
        names, shares = ("minibus", "panel van", "panel van"), (0.5, 0.25, 0.25)
    else:
        names, shares = ("large van", "large van", "minibus"), (0.5, 0.3, 0.2)
    return str(names[int(rng.choice(3, p=shares))])
