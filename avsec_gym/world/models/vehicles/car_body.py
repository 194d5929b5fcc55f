"""Bodies of cars and vans: a lower skin with wheel arches, a greenhouse on it, seats in it."""

from __future__ import annotations

from typing import NamedTuple

from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.body_design import CarDesign
from avsec_gym.world.models.vehicles.greenhouse import greenhouse_panels, greenhouse_skin
from avsec_gym.world.models.vehicles.interior import interior
from avsec_gym.world.models.vehicles.lower_body import lower_panels, lower_skin
from avsec_gym.world.models.vehicles.paint import Finish


class CarBody(NamedTuple):
    """A car's surfaces, and the skins on which its lamps and plates are placed."""

    parts: list[Mesh]
    lower: Floats
    """Left side from lip to deck, shape (K, 9, 3)."""
    upper: Floats
    """Left side of the greenhouse, shape (K, 7, 3)."""


def car_body(design: CarDesign, finish: Finish) -> CarBody:
    """Skin, windows, seats and a dark underside, without wheels and lamps."""
    lower = lower_skin(design)
    plan, upper = greenhouse_skin(design)
    parts = [
        *lower_panels(design, finish, lower),
        *greenhouse_panels(design, finish, plan, upper),
        *interior(design, finish),
    ]
    return CarBody(parts, lower.left[:, 2:], upper.left)
