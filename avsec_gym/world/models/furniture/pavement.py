"""What stands on pavements: benches, letter boxes, bicycle stands, cabinets."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import (
    BLACK_PLASTIC,
    CAST_IRON,
    GALVANISED,
    RAW_CONCRETE,
    UPRIGHT_WOOD,
    WOOD,
    painted,
)
from avsec_gym.world.models.furniture.plate import board
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box, prism, tube

_YELLOW = painted(0.85, 0.5, 0.005, infrared=0.8)


@variants(3)
def bench(rng: np.random.Generator) -> Mesh:
    """A bench of 1.8 m along y with a back of slats; one sits looking to -x."""
    tint = ((1.0, 1.0, 1.0), (0.55, 0.4, 0.3), (0.25, 0.5, 0.3))[rng.integers(3)]
    wood, across = (Material(f"weathered_wood/{i}", tint, infrared=0.5) for i in (0, 1))
    seat = [box(0.11, 1.8, 0.035, wood, top=across).placed(x, 0, 0.43) for x in (-0.2, -0.07, 0.06)]
    back = [box(0.03, 1.8, 0.11, wood).placed(0.17 + 0.25 * (z - 0.5), 0, z) for z in (0.55, 0.7)]
    sides = []
    for y in (-0.7, 0.7):
        sides += [
            box(0.45, 0.05, 0.05, CAST_IRON).placed(-0.03, y, 0.38),
            box(0.05, 0.05, 0.4, CAST_IRON).placed(-0.2, y),
            tube([(0.14, y, 0), (0.15, y, 0.45), (0.26, y, 0.82)], 0.03, CAST_IRON, sides=5),
        ]
    return merge([*seat, *back, *sides])


@variants(3)
def bench_block(rng: np.random.Generator) -> Mesh:
    """A concrete block with a wooden seat, 1.6 to 2.2 m along y."""
    length = float(rng.uniform(1.6, 2.2))
    slats = [
        box(0.12, length - 0.1, 0.04, WOOD, top=UPRIGHT_WOOD).placed(x, 0, 0.42)
        for x in (-0.15, 0.0, 0.15)
    ]
    return merge([box(0.45, length, 0.42, RAW_CONCRETE), *slats])


@variants(2)
def post_box(rng: np.random.Generator) -> Mesh:
    """A yellow letter box on a post, 1.4 m, or on two legs."""
    body = box(0.32, 0.5, 0.62, _YELLOW).placed(0, 0, 0.75)
    roof = prism(
        [(0.17, -0.26), (0.17, 0.26), (-0.2, 0.26), (-0.2, -0.26)],
        1.41,
        _YELLOW,
        top=_YELLOW,
        bottom=1.37,
    )
    slot = box(0.01, 0.34, 0.035, BLACK_PLASTIC).placed(-0.162, 0, 1.24)
    notice = board(0.16, 0.22, Material(tint=(0.8, 0.8, 0.78)), GALVANISED).placed(-0.17, 0, 0.98)
    legs = (0.0,) if rng.random() < 0.5 else (-0.18, 0.18)
    return merge([body, roof, slot, notice, *[pole(0.8, 0.035).placed(0.02, y) for y in legs]])


@variants(3)
def bicycle_stand(rng: np.random.Generator) -> Mesh:
    """Three to five steel hoops in a row along y, 0.8 m high; bicycles stand along x."""
    count = int(rng.integers(3, 6))
    half = 0.32
    turn = np.linspace(0, np.pi, 5)
    bow = [(0, half * np.cos(a), 0.55 + 0.25 * np.sin(a)) for a in turn]
    hoop = tube([(0, half, -0.1), *bow, (0, -half, -0.1)], 0.024, GALVANISED, sides=5, capped=False)
    return merge(
        [hoop.placed(0, 0.9 * (i - 0.5 * (count - 1)), 0, np.pi / 2) for i in range(count)]
    )


@variants(6)
def junction_box(rng: np.random.Generator) -> Mesh:
    """A grey cabinet of the power or telephone grid, 0.9 to 1.4 m, with stickers and scrawls."""
    wide, deep, high = rng.uniform((0.6, 0.3, 0.9), (1.3, 0.4, 1.4)).tolist()
    tint = ((0.36, 0.37, 0.36), (0.42, 0.43, 0.38), (0.3, 0.33, 0.32))[rng.integers(3)]
    paint = painted(*tint, worn=int(rng.integers(4)))
    plain = painted(*tint)
    gaps = [
        box(0.008, 0.012, high - 0.24, BLACK_PLASTIC).placed(-0.5 * deep, y, 0.16)
        for y in ((0.0,) if wide < 0.9 else (-wide / 6, wide / 6))
    ]
    return merge(
        [
            box(deep - 0.04, wide - 0.04, 0.12 + 0.2, RAW_CONCRETE).placed(0, 0, -0.2),
            box(deep, wide, high - 0.16, paint).placed(0, 0, 0.12),
            box(deep + 0.06, wide + 0.06, 0.05, plain).placed(0, 0, high - 0.05),
            *gaps,
        ]
    )
