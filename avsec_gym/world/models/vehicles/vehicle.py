"""Vehicles of KITTI's categories, made to measure from a seed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avsec_gym.world.assets import Assets, part_of
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.vehicles.block import block
from avsec_gym.world.models.vehicles.body_design import BodyDesign, CarDesign, draw_design
from avsec_gym.world.models.vehicles.bus import bus, tram
from avsec_gym.world.models.vehicles.car_body import car_body
from avsec_gym.world.models.vehicles.car_details import car_details
from avsec_gym.world.models.vehicles.designs import body_designs, choose_design
from avsec_gym.world.models.vehicles.lorry import lorry
from avsec_gym.world.models.vehicles.paint import BLACK_GLOSS, STEEL, draw_finish
from avsec_gym.world.models.vehicles.trailer import misc
from avsec_gym.world.models.vehicles.wheel import RIMS, wheel
from avsec_gym.world.shapes import tube

_CAMERAS = (-0.27, -0.21, 0.27, 0.33)
"""y of the cameras on the ego vehicle, metres."""


def make_vehicle(category: str, dimensions: tuple[float, float, float], appearance: int) -> Mesh:
    """A vehicle that fills its box.

    Args:
        category: Car, Van, Truck, Misc or Tram.
        dimensions: Height, width, length, metres.
        appearance: Seed of body type, paint and details.

    Raises:
        ValueError: The category is unknown.
    """
    height, width, length = dimensions
    if category not in _MAKERS:
        raise ValueError(f"a vehicle is one of {', '.join(_MAKERS)}, got {category!r}")
    rng = np.random.default_rng((appearance, len(_MAKERS), list(_MAKERS).index(category)))
    parts = _MAKERS[category](rng, part_of(appearance), height, width, length)
    return merge(parts).fitted(length, width, height)


def make_ego_vehicle(part: Assets = Assets.ALL) -> Mesh:
    """A car with a rack of cameras and a LiDAR on its roof, as others see it: a dark estate.

    4.7 m long and 1.8 m wide; its roof is 1.5 m high, the LiDAR's top 1.9 m.

    Args:
        part: The part of the assets; the estates of either have names of their own.
    """
    length, width, height = 4.7, 1.8, 1.5
    estates = [body for body in body_designs("Car", part) if "estate" in body.name]
    parts = car(np.random.default_rng(3), estates[0], height, width, length)
    body = merge(parts).fitted(length, width, height)
    bars = [block(0.05, 1.2, 0.05, STEEL).placed(x, 0.0, 1.53) for x in (-0.9, 0.1)]
    posts = [
        block(0.05, 0.05, 0.12, STEEL).placed(x, y, 1.44)
        for x in (-0.9, 0.1)
        for y in (-0.55, 0.55)
    ]
    cameras = [block(0.10, 0.06, 0.06, BLACK_GLOSS).placed(0.16, y, 1.58) for y in _CAMERAS]
    lidar = [
        tube([(-0.15, 0.0, 1.50), (-0.15, 0.0, 1.66)], 0.05, STEEL, sides=8),
        tube([(-0.15, 0.0, 1.66), (-0.15, 0.0, 1.90)], 0.10, BLACK_GLOSS, sides=14),
    ]
    plate = block(1.05, 0.10, 0.04, STEEL).placed(-0.4, 0.0, 1.54)
    return merge([body, *bars, *posts, *cameras, *lidar, plate])


def car(
    rng: np.random.Generator, body: BodyDesign, height: float, width: float, length: float
) -> list[Mesh]:
    """Parts of a car or van of a body design."""
    design = draw_design(rng, body, height, width, length)
    commercial = body.kind in ("delivery car", "panel van", "large van")
    finish = draw_finish(rng, f"car_side/{body.doors}", commercial=commercial)
    skin = car_body(design, finish)
    return [*skin.parts, *car_details(rng, design, finish, skin), *_wheels(rng, design)]


def _wheels(rng: np.random.Generator, design: CarDesign) -> list[Mesh]:
    left = wheel(int(rng.integers(RIMS))).scaled(*[design.wheel] * 3)
    y = design.half_width - 0.045
    pair = [left.placed(axle, y, design.wheel) for axle in (design.rear_axle, design.front_axle)]
    return [*pair, *(mesh.mirrored() for mesh in pair)]


def _passenger_car(
    rng: np.random.Generator, part: Assets, height: float, width: float, length: float
) -> list[Mesh]:
    body = choose_design(rng, body_designs("Car", part), height, length)
    return car(rng, body, height, width, length)


def _van(
    rng: np.random.Generator, part: Assets, height: float, width: float, length: float
) -> list[Mesh]:
    body = choose_design(rng, body_designs("Van", part), height, length)
    return car(rng, body, height, width, length)


def _truck(
    rng: np.random.Generator, _: Assets, height: float, width: float, length: float
) -> list[Mesh]:
    is_bus = 8.0 < length < 14.0 and height > 2.7 and rng.random() < 0.2
    return (bus if is_bus else lorry)(rng, height, width, length)


def _misc(
    rng: np.random.Generator, _: Assets, height: float, width: float, length: float
) -> list[Mesh]:
    return misc(rng, height, width, length)


def _tram(
    rng: np.random.Generator, _: Assets, height: float, width: float, length: float
) -> list[Mesh]:
    return tram(rng, height, width, length)


_MAKERS: dict[str, Callable[[np.random.Generator, Assets, float, float, float], list[Mesh]]] = {
    "Car": _passenger_car,
    "Van": _van,
    "Truck": _truck,
    "Misc": _misc,
    "Tram": _tram,
}
