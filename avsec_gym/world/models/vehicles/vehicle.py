"""Vehicles of KITTI's categories, made to measure from a seed."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.vehicles.car_body import car_body
from avsec_gym.world.models.vehicles.car_details import car_details
from avsec_gym.world.models.vehicles.designs import CarDesign, choose_car, choose_van, draw_design
from avsec_gym.world.models.vehicles.paint import draw_finish
from avsec_gym.world.models.vehicles.wheel import RIMS, wheel


def make_vehicle(
    category: str, dimensions: tuple[float, float, float], appearance: int
) -> Mesh:
    """A vehicle that fills its box.

    Args:
        category: Car, Van, Truck, Misc or Tram.
        dimensions: Height, width, length, metres.
        appearance: Seed of body type, paint and details.

    Raises:
        ValueError: The category is unknown.
    """
    height, width, length = dimensions
    rng = np.random.default_rng((appearance, len(category)))
    parts = car(rng, choose_car(rng, height, length) if category == "Car" else choose_van(rng, height, length), height, width, length)
    return merge(parts).fitted(length, width, height)


def car(
    rng: np.random.Generator, name: str, height: float, width: float, length: float
) -> list[Mesh]:
    """Parts of a car or van of a body type."""
    design = draw_design(rng, name, height, width, length)
    commercial = name in ("delivery car", "panel van", "large van")
    finish = draw_finish(rng, f"car_side/{design.body.doors}", commercial=commercial)
    body = car_body(design, finish)
    return [*body.parts, *car_details(rng, design, finish, body), *_wheels(rng, design)]


def _wheels(rng: np.random.Generator, design: CarDesign) -> list[Mesh]:
    left = wheel(int(rng.integers(RIMS))).scaled(*[design.wheel] * 3)
    y = design.half_width - 0.045
    pair = [left.placed(axle, y, design.wheel) for axle in (design.rear_axle, design.front_axle)]
    return [*pair, *(mesh.mirrored() for mesh in pair)]
