"""What a body design consists of, and one car of it cut to a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Lamp(NamedTuple):
    """One of a pair of lamps at an end of the car.

    Args:
        inner: Place of its inner edge, share of the half width.
        wrap: Length by which it reaches round the corner, metres.
        tall: Height, metres.
        sweep: Share of the height that its inner end lacks (headlamps: below, tail lamps: above).
        look: Number of its texture.
    """

    inner: float
    wrap: float
    tall: float
    sweep: float
    look: int


class Grille(NamedTuple):
    """The air intake between the headlamps.

    Args:
        width: Share of the half width.
        tall: Height, metres.
        look: Number of its texture.
        intake: Width of the intake under the number plate, share of the half width.
    """

    width: float
    tall: float
    look: int
    intake: float


_HEADLAMP = Lamp(0.60, 0.20, 0.17, 0.3, 0)
_TAIL_LAMP = Lamp(0.70, 0.12, 0.24, 0.2, 0)
_GRILLE = Grille(0.52, 0.10, 0, 0.7)


@dataclass(frozen=True)
class BodyDesign:
    """A body at its usual size; lengths are metres, heights shares of the vehicle's height.

    Args:
        name: Stable name.
        kind: Family: hatchback, saloon, estate, ...
        share: How often it is seen, relative to others of its size.
        length: Usual length of the body, metres.
        height: Usual height, metres.
        front_overhang: Length from the front end to the front axle.
        rear_overhang: Length from the rear axle to the rear end.
        bonnet: Length from the front end to the windscreen's base.
        windscreen: Length over which the windscreen slopes.
        tailgate: Length over which the rear window slopes.
        boot: Length from the rear window's base to the rear end.
        nose: Height of the bonnet's front edge.
        cowl: Height of the windscreen's base.
        belt: Height of the rear windows' base.
        wheel: Radius of the wheels, metres.
        clearance: Height of the sill, metres.
        roundness: Length over which the front narrows.
        squareness: Exponent of the plan's corners.
        roof: Width of the roof, share of the body's.
        windows: Rear and front edges of the windows, shares of the side from the rear to the
            windscreen.
        doors: Number of the texture that shows its seams.
        glass: Upper edge of the windows, share of the way from the belt to the roof.
        rear_glass: Lower and upper edge of the rear window; equal if there is none.
        roof_drop: Height by which the roof falls towards its rear edge, metres.
        rake: Length by which the bonnet's edge lies behind the bumper.
        bumper: Length by which the bumpers stand out.
        tumble: Length by which the flank leans in from its widest line to the shoulder.
        crease: Depth of the hollow in the doors below the shoulder.
        flare: Width of the lips round the wheel arches.
        headlamp: The headlamps.
        tail_lamp: The tail lamps.
        grille: The grille.
        rails: How often its roof carries rails, a share.
    """

    name: str
    kind: str
    share: float
    length: float
    height: float
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
    roof_drop: float = 0.0
    rake: float = 0.20
    bumper: float = 0.02
    tumble: float = 0.035
    crease: float = 0.010
    flare: float = 0.010
    headlamp: Lamp = _HEADLAMP
    tail_lamp: Lamp = _TAIL_LAMP
    grille: Grille = _GRILLE
    rails: float = 0.0


@dataclass(frozen=True)
class CarDesign:
    """One car in metres: x from its centre, z from the ground.

    Args:
        body: The body design.
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

    body: BodyDesign
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
    rng: np.random.Generator, body: BodyDesign, height: float, width: float, length: float
) -> CarDesign:
    """A car of a body design that fills a box, with the small differences of years and makes."""
    along = length / body.length
    jitter = 1.0 + 0.02 * np.clip(rng.standard_normal(6), -2, 2)
    level = 0.005 * np.clip(rng.standard_normal(3), -2, 2)
    front, rear = 0.5 * length, -0.5 * length
    wheel = float(
        np.clip(body.wheel * jitter[0] * (0.5 + 0.5 * along), 0.25, 0.185 * height + 0.08)
    )
    bonnet = front - body.bonnet * along * jitter[1]
    boot = rear + body.boot * along * (jitter[2] if body.boot > 0.1 else 1.0)
    return CarDesign(
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
