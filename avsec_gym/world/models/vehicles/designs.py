"""The registry of body designs: every car and van on the road is one of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from avsec_gym.world.assets import Assets, members
from avsec_gym.world.models.vehicles.body_design import BodyDesign, Grille, Lamp

_TWO = ((0.06, 0.46), (0.53, 0.97))
_TWO_AND_QUARTER = ((0.01, 0.15), (0.20, 0.52), (0.57, 0.97))
_THREE_DOOR = ((0.08, 0.40), (0.47, 0.97))
_COUPE = ((0.04, 0.32), (0.38, 0.97))
_THREE = ((0.02, 0.24), (0.29, 0.60), (0.65, 0.97))
_FRONT_ONLY = ((0.78, 0.97),)

_MEASURED = 0.95
"""Length of a car's labelled box relative to its maker's figure, in KITTI's labels."""
_LONG, _TALL = 0.25, 0.07
"""Metres by which a box's length and height usually differ from a design's."""

# fmt: off
_HATCHBACK = BodyDesign(
    "", "hatchback", 1.0, 4.1, 1.47, 0.84, 0.70, 1.10, 0.84, 0.38, 0.12,
    0.47, 0.63, 0.665, 0.305, 0.18, 0.62, 2.7, 0.79, _TWO, 0,
)
_CITY = replace(
    _HATCHBACK, kind="city car", length=3.55, height=1.50, front_overhang=0.70,
    rear_overhang=0.52, bonnet=0.88, windscreen=0.80, tailgate=0.28, boot=0.10,
    nose=0.45, cowl=0.62, belt=0.655, wheel=0.275, roof=0.80, doors=1, windows=_THREE_DOOR,
)
_SALOON = BodyDesign(
    "", "saloon", 1.0, 4.55, 1.43, 0.88, 1.02, 1.28, 0.88, 0.70, 0.50,
    0.47, 0.645, 0.675, 0.315, 0.17, 0.60, 2.8, 0.76, _TWO_AND_QUARTER, 0,
)
_ESTATE = BodyDesign(
    "", "estate", 1.0, 4.6, 1.47, 0.88, 0.98, 1.26, 0.86, 0.36, 0.11,
    0.465, 0.635, 0.665, 0.315, 0.17, 0.60, 2.8, 0.78, _THREE, 0, rails=0.7,
)
_MPV = BodyDesign(
    "", "people carrier", 1.0, 4.3, 1.63, 0.88, 0.74, 0.98, 1.00, 0.28, 0.10,
    0.44, 0.585, 0.595, 0.31, 0.18, 0.62, 2.8, 0.81, _THREE, 0, rails=0.4,
)
_SUV = BodyDesign(
    "", "off-roader", 1.0, 4.4, 1.70, 0.84, 0.82, 1.18, 0.72, 0.30, 0.10,
    0.50, 0.605, 0.62, 0.345, 0.25, 0.50, 3.2, 0.81, _THREE, 0,
    rake=0.12, flare=0.028, rails=0.6, headlamp=Lamp(0.58, 0.16, 0.18, 0.2, 1),
    tail_lamp=Lamp(0.78, 0.12, 0.34, 0.1, 0), grille=Grille(0.54, 0.13, 1, 0.8),
)
_COUPE_BODY = BodyDesign(
    "", "coupé", 0.6, 4.35, 1.36, 0.86, 0.86, 1.34, 0.86, 0.88, 0.26,
    0.46, 0.63, 0.68, 0.32, 0.15, 0.68, 2.6, 0.74, _COUPE, 1, roof_drop=0.06, rake=0.28,
)
_BOX_CAR = BodyDesign(
    "", "box car", 1.0, 4.2, 1.82, 0.86, 0.70, 1.02, 0.72, 0.10, 0.05,
    0.45, 0.57, 0.575, 0.30, 0.19, 0.52, 3.3, 0.86, _THREE, 2,
    rake=0.16, tail_lamp=Lamp(0.86, 0.05, 0.36, 0.0, 0), headlamp=Lamp(0.60, 0.14, 0.22, 0.1, 2),
)
_VAN = BodyDesign(
    "", "panel van", 1.0, 4.9, 1.97, 0.92, 0.98, 0.80, 0.74, 0.10, 0.05,
    0.44, 0.535, 0.535, 0.325, 0.20, 0.50, 3.8, 0.88, _FRONT_ONLY, 2, 0.80, (0.20, 0.72),
    rake=0.18, tail_lamp=Lamp(0.88, 0.04, 0.42, 0.0, 0), headlamp=Lamp(0.62, 0.14, 0.24, 0.2, 2),
    grille=Grille(0.56, 0.12, 3, 0.8), crease=0.004,
)


def _of(base: BodyDesign, name: str, **numbers: Any) -> BodyDesign:
    return replace(base, name=name, **numbers)


_CARS = (
    _of(_CITY, "round city car", length=3.45, height=1.47, roundness=0.78, squareness=2.4,
        roof=0.77, belt=0.65, rake=0.24, headlamp=Lamp(0.56, 0.16, 0.20, 0.1, 3),
        tail_lamp=Lamp(0.74, 0.10, 0.22, 0.1, 2), grille=Grille(0.30, 0.06, 2, 0.5)),
    _of(_CITY, "tall city car", length=3.55, height=1.55, nose=0.48, windscreen=0.74, tailgate=0.16,
        roof=0.84, windows=_TWO, doors=0, headlamp=Lamp(0.62, 0.22, 0.23, 0.4, 0),
        tail_lamp=Lamp(0.84, 0.06, 0.42, 0.0, 1), grille=Grille(0.58, 0.07, 3, 0.6)),
    _of(_CITY, "retro city car", length=3.62, height=1.42, nose=0.52, cowl=0.645, belt=0.66,
        windscreen=0.56, tailgate=0.24, bonnet=1.02, roundness=0.46, roof=0.76, wheel=0.295,
        rake=0.12, flare=0.024, headlamp=Lamp(0.56, 0.04, 0.19, 0.0, 3),
        tail_lamp=Lamp(0.74, 0.04, 0.26, 0.0, 0), grille=Grille(0.50, 0.13, 0, 0.7)),
    _of(_CITY, "wedge city car", length=3.6, height=1.49, belt=0.70, nose=0.44, windscreen=0.92,
        rake=0.26, tailgate=0.34, headlamp=Lamp(0.58, 0.34, 0.22, 0.6, 1),
        tail_lamp=Lamp(0.80, 0.14, 0.36, 0.4, 1), grille=Grille(0.42, 0.05, 2, 0.9)),
    _of(_HATCHBACK, "round hatchback", length=3.85, height=1.46, bonnet=1.02, roundness=0.74,
        squareness=2.5, tailgate=0.40, wheel=0.29, headlamp=Lamp(0.54, 0.18, 0.18, 0.2, 3),
        tail_lamp=Lamp(0.72, 0.12, 0.22, 0.1, 2), grille=Grille(0.34, 0.07, 2, 0.6)),
    _of(_HATCHBACK, "boxy hatchback", share=0.8, length=4.0, height=1.42, windscreen=0.66,
        tailgate=0.30, nose=0.49, cowl=0.635, belt=0.65, roundness=0.36, squareness=3.6, rake=0.08,
        tumble=0.022, crease=0.004, wheel=0.285, bumper=0.045,
        headlamp=Lamp(0.62, 0.05, 0.15, 0.0, 4), tail_lamp=Lamp(0.70, 0.04, 0.19, 0.0, 3),
        grille=Grille(0.60, 0.12, 1, 0.5)),
    _of(_HATCHBACK, "classic hatchback", share=1.6, length=4.2, height=1.48, bonnet=1.14,
        headlamp=Lamp(0.58, 0.18, 0.19, 0.25, 0), tail_lamp=Lamp(0.66, 0.12, 0.20, 0.15, 2)),
    _of(_HATCHBACK, "swept hatchback", length=4.28, height=1.46, belt=0.69, tailgate=0.52,
        roof_drop=0.05, windscreen=0.96, rake=0.28, crease=0.016,
        headlamp=Lamp(0.56, 0.42, 0.17, 0.6, 1), tail_lamp=Lamp(0.66, 0.24, 0.24, 0.5, 1),
        grille=Grille(0.50, 0.06, 2, 0.9)),
    _of(_HATCHBACK, "sharp hatchback", length=4.33, height=1.49, tailgate=0.30, rake=0.16,
        crease=0.018, tumble=0.045, squareness=3.1, headlamp=Lamp(0.60, 0.26, 0.18, 0.4, 1),
        tail_lamp=Lamp(0.84, 0.12, 0.50, 0.2, 0), grille=Grille(0.55, 0.10, 0, 0.85)),
    _of(_HATCHBACK, "three-door hatchback", length=3.82, height=1.43, windows=_THREE_DOOR, doors=1,
        bonnet=1.05, belt=0.675, wheel=0.29, tail_lamp=Lamp(0.70, 0.12, 0.20, 0.2, 0),
        headlamp=Lamp(0.58, 0.16, 0.17, 0.2, 4)),
    _of(_HATCHBACK, "small five-door hatchback", length=3.95, height=1.45, bonnet=1.0, rake=0.22,
        headlamp=Lamp(0.56, 0.30, 0.21, 0.5, 0), tail_lamp=Lamp(0.80, 0.10, 0.34, 0.3, 1),
        grille=Grille(0.46, 0.09, 3, 0.8), wheel=0.295),
    _of(_HATCHBACK, "premium hatchback", share=0.8, length=4.26, height=1.43, bonnet=1.32,
        front_overhang=0.78, nose=0.49, cowl=0.655, belt=0.68, wheel=0.32, tumble=0.045,
        crease=0.018, headlamp=Lamp(0.52, 0.18, 0.15, 0.3, 5), grille=Grille(0.38, 0.12, 1, 0.9),
        tail_lamp=Lamp(0.60, 0.12, 0.20, 0.3, 4)),
    _of(_SALOON, "classic saloon", share=1.5, headlamp=Lamp(0.56, 0.18, 0.16, 0.25, 0),
        tail_lamp=Lamp(0.56, 0.14, 0.18, 0.2, 0)),
    _of(_SALOON, "long saloon", length=4.88, height=1.47, bonnet=1.42, boot=0.55, wheel=0.33,
        nose=0.49, front_overhang=0.86, squareness=3.0, headlamp=Lamp(0.54, 0.20, 0.17, 0.3, 5),
        tail_lamp=Lamp(0.54, 0.16, 0.20, 0.2, 4), grille=Grille(0.40, 0.15, 1, 0.8), crease=0.016),
    _of(_SALOON, "arched saloon", share=0.7, length=4.65, height=1.41, roof_drop=0.06,
        windscreen=0.98, tailgate=0.90, boot=0.38, rake=0.28, belt=0.69,
        headlamp=Lamp(0.56, 0.34, 0.17, 0.55, 1), tail_lamp=Lamp(0.58, 0.22, 0.18, 0.4, 1),
        grille=Grille(0.50, 0.09, 2, 0.9)),
    _of(_SALOON, "compact saloon", length=4.35, height=1.43, bonnet=1.18, tailgate=0.58, boot=0.52,
        windows=_TWO, headlamp=Lamp(0.60, 0.16, 0.17, 0.2, 4), rear_overhang=0.98,
        tail_lamp=Lamp(0.66, 0.12, 0.18, 0.1, 3), grille=Grille(0.50, 0.09, 3, 0.6)),
    _of(_SALOON, "boxy saloon", share=0.7, length=4.46, height=1.41, windscreen=0.70, tailgate=0.52,
        boot=0.62, nose=0.50, roundness=0.34, squareness=3.8, rake=0.07, tumble=0.02, crease=0.004,
        bumper=0.05, windows=_TWO, belt=0.655, wheel=0.29, headlamp=Lamp(0.58, 0.03, 0.14, 0.0, 4),
        tail_lamp=Lamp(0.52, 0.05, 0.16, 0.0, 3), grille=Grille(0.54, 0.13, 1, 0.5)),
    _of(_ESTATE, "classic estate", share=1.3, headlamp=Lamp(0.58, 0.18, 0.17, 0.25, 0),
        tail_lamp=Lamp(0.68, 0.14, 0.24, 0.2, 2)),
    _of(_ESTATE, "sports estate", length=4.70, height=1.44, roof_drop=0.06, tailgate=0.54,
        belt=0.69, wheel=0.33, rake=0.22, crease=0.018, headlamp=Lamp(0.54, 0.24, 0.15, 0.4, 5),
        tail_lamp=Lamp(0.62, 0.20, 0.18, 0.3, 4), grille=Grille(0.42, 0.16, 1, 0.9)),
    _of(_ESTATE, "boxy estate", share=0.7, length=4.76, height=1.49, tailgate=0.14, windscreen=0.72,
        roundness=0.40, squareness=3.6, rake=0.10, nose=0.49, bumper=0.045, crease=0.006,
        headlamp=Lamp(0.60, 0.05, 0.16, 0.0, 4), tail_lamp=Lamp(0.84, 0.05, 0.52, 0.0, 3),
        grille=Grille(0.54, 0.14, 0, 0.6)),
    _of(_ESTATE, "small estate", length=4.25, height=1.48, bonnet=1.08, rear_overhang=0.90,
        wheel=0.295, rails=0.5, headlamp=Lamp(0.58, 0.28, 0.20, 0.45, 1),
        tail_lamp=Lamp(0.82, 0.10, 0.36, 0.2, 0), grille=Grille(0.46, 0.08, 2, 0.8)),
    _of(_MPV, "compact people carrier", length=4.38, height=1.65, squareness=3.1, share=1.4,
        headlamp=Lamp(0.58, 0.20, 0.21, 0.2, 0), tail_lamp=Lamp(0.76, 0.12, 0.28, 0.1, 2),
        grille=Grille(0.54, 0.10, 3, 0.8)),
    _of(_MPV, "round people carrier", length=4.2, height=1.62, roundness=0.74, squareness=2.5,
        windscreen=1.08, tailgate=0.38, headlamp=Lamp(0.54, 0.30, 0.22, 0.5, 3),
        tail_lamp=Lamp(0.80, 0.14, 0.34, 0.3, 1), grille=Grille(0.42, 0.07, 2, 0.7)),
    _of(_MPV, "large people carrier", length=4.72, height=1.73, rear_overhang=0.92, bonnet=1.04,
        wheel=0.33, squareness=3.0, headlamp=Lamp(0.58, 0.22, 0.21, 0.3, 1),
        tail_lamp=Lamp(0.80, 0.12, 0.40, 0.1, 0), grille=Grille(0.56, 0.12, 1, 0.8)),
    _of(_MPV, "small people carrier", length=3.95, height=1.60, bonnet=0.90, front_overhang=0.80,
        rear_overhang=0.62, windows=_TWO, headlamp=Lamp(0.60, 0.26, 0.23, 0.4, 1),
        tail_lamp=Lamp(0.84, 0.08, 0.44, 0.1, 1), wheel=0.295),
    _of(_SUV, "compact off-roader", share=1.2),
    _of(_SUV, "boxy off-roader", share=0.7, length=4.25, height=1.80, windscreen=0.44,
        tailgate=0.12, nose=0.545, cowl=0.61, belt=0.61, roundness=0.26, squareness=4.4, rake=0.05,
        roof=0.87, crease=0.004, tumble=0.018, bumper=0.06, flare=0.035, clearance=0.29,
        headlamp=Lamp(0.62, 0.02, 0.19, 0.0, 3), tail_lamp=Lamp(0.82, 0.03, 0.24, 0.0, 3),
        grille=Grille(0.58, 0.15, 1, 0.6)),
    _of(_SUV, "large off-roader", length=4.75, height=1.76, bonnet=1.30, wheel=0.37, crease=0.016,
        headlamp=Lamp(0.56, 0.24, 0.19, 0.4, 5), tail_lamp=Lamp(0.68, 0.18, 0.26, 0.3, 4),
        grille=Grille(0.46, 0.18, 1, 0.9), rails=0.8),
    _of(_SUV, "three-door off-roader", share=0.5, length=3.85, height=1.70, windows=_THREE_DOOR,
        doors=1, rear_overhang=0.66, bonnet=1.06, squareness=3.6, rails=0.3,
        headlamp=Lamp(0.62, 0.10, 0.19, 0.1, 4), tail_lamp=Lamp(0.82, 0.06, 0.26, 0.0, 2)),
    _of(_COUPE_BODY, "wedge coupé", headlamp=Lamp(0.56, 0.34, 0.14, 0.5, 1),
        tail_lamp=Lamp(0.56, 0.18, 0.16, 0.3, 4), grille=Grille(0.44, 0.06, 2, 0.9)),
    _of(_COUPE_BODY, "round coupé", length=4.08, height=1.40, bonnet=1.16, roundness=0.80,
        squareness=2.3, windscreen=0.74, tailgate=0.98, boot=0.22, nose=0.48, flare=0.03,
        headlamp=Lamp(0.54, 0.14, 0.20, 0.0, 3), tail_lamp=Lamp(0.66, 0.10, 0.20, 0.0, 2),
        grille=Grille(0.30, 0.05, 2, 0.8)),
    _of(_COUPE_BODY, "roadster", kind="roadster", share=0.4, length=4.0, height=1.29, bonnet=1.36,
        windscreen=0.60, tailgate=0.62, boot=0.62, cowl=0.645, belt=0.67, windows=((0.20, 0.97),),
        roof_drop=0.02, headlamp=Lamp(0.54, 0.26, 0.15, 0.4, 5),
        tail_lamp=Lamp(0.58, 0.12, 0.16, 0.2, 4), grille=Grille(0.36, 0.08, 1, 0.8)),
    _of(_SUV, "pick-up", kind="pick-up", share=0.5, length=4.95, height=1.74, boot=1.55,
        tailgate=0.22, rear_overhang=1.10, front_overhang=0.88, bonnet=1.22, windows=_TWO, doors=0,
        belt=0.60, rails=0.0, tail_lamp=Lamp(0.86, 0.04, 0.34, 0.0, 3)),
    _of(_BOX_CAR, "box car"),
)
_VANS = (
    _of(_BOX_CAR, "box car with windows", length=4.3, height=1.85,
        headlamp=Lamp(0.58, 0.22, 0.23, 0.35, 0)),
    _of(_BOX_CAR, "delivery car", kind="delivery car", windows=((0.62, 0.97),), glass=0.86,
        rear_glass=(0.18, 0.80), share=1.2),
    _of(_MPV, "seven-seat people carrier", length=4.6, height=1.75, share=0.8, rear_overhang=0.92),
    _of(_VAN, "minibus", kind="minibus", windows=_THREE, rear_glass=(0.12, 0.76)),
    _of(_VAN, "panel van"),
    _of(_VAN, "round panel van", length=4.8, height=1.95, bonnet=0.92, roundness=0.66,
        squareness=3.0, windscreen=0.86, roof=0.86, headlamp=Lamp(0.60, 0.30, 0.27, 0.4, 1),
        grille=Grille(0.48, 0.08, 2, 0.8)),
    _of(_VAN, "large van", kind="large van", length=5.7, height=2.5, front_overhang=0.98,
        rear_overhang=1.15, bonnet=0.88, windscreen=0.78, tailgate=0.05, nose=0.37, cowl=0.465,
        belt=0.47, wheel=0.34, clearance=0.22, squareness=4.2, glass=0.60, rear_glass=(0.14, 0.50),
        share=1.4),
    _of(_VAN, "large minibus", kind="minibus", length=5.6, height=2.45, windows=_THREE, nose=0.37,
        cowl=0.465, belt=0.47, wheel=0.34, squareness=4.2, glass=0.62, rear_glass=(0.14, 0.52),
        share=0.5),
)
# fmt: on


def body_designs(category: str | None = None, part: Assets = Assets.ALL) -> tuple[BodyDesign, ...]:
    """The body designs in a fixed order; new ones are added at the end of their category.

    Each kind of body is split by the rule of `avsec_gym.world.assets`, so that there are saloons
    in both parts; the only design of its kind trains.

    Args:
        category: Car or Van; both if None.
        part: The part of the assets that the designs belong to.
    """
    every = {"Car": _CARS, "Van": _VANS}
    designs = every[category] if category else (*_CARS, *_VANS)
    return tuple(design for design in designs if design.name in _names(design.kind, part))


@cache
def _names(kind: str, part: Assets) -> tuple[str, ...]:
    """The names of a kind's designs that belong to a part."""
    names = tuple(design.name for design in (*_CARS, *_VANS) if design.kind == kind)
    if len(names) == 1 and part == Assets.JUDGE:
        return ()
    return members(f"vehicle/{kind}", names, part)


def body_design(name: str) -> BodyDesign:
    """One design by its name.

    Raises:
        ValueError: There is no such design.
    """
    for design in body_designs():
        if design.name == name:
            return design
    raise ValueError(f"there is no body design {name!r}")


def choose_design(
    rng: np.random.Generator, designs: Sequence[BodyDesign], height: float, length: float
) -> BodyDesign:
    """A design for a box: the nearer its usual size, and the more often seen, the likelier.

    Args:
        rng: The source of chance.
        designs: The designs that may be chosen.
        height: Height of the box, metres.
        length: Length of the box, metres.
    """
    far = np.array(
        [
            ((_MEASURED * d.length - length) / _LONG) ** 2 + ((d.height - height) / _TALL) ** 2
            for d in designs
        ]
    )
    shares = np.array([design.share for design in designs]) * np.exp(-0.5 * (far - far.min()))
    return designs[int(rng.choice(len(designs), p=shares / shares.sum()))]
