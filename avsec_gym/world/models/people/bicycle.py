"""Bicycles: which one belongs to a number, and how it stands parked."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people.bicycle_parts import ALLOY, Bicycle, bicycle_parts
from avsec_gym.world.models.people.rings import Rings, rods
from avsec_gym.world.models.people.skin import surface

_PAINTS = (
    (0.03, 0.03, 0.035),
    (0.36, 0.37, 0.38),
    (0.04, 0.07, 0.17),
    (0.28, 0.03, 0.03),
    (0.03, 0.10, 0.07),
    (0.50, 0.48, 0.42),
    (0.08, 0.10, 0.12),
)


def make_bicycle(appearance: int) -> Mesh:
    """A bicycle that leans on its stand; about 1.8 m long."""
    bicycle = chosen_bicycle(appearance)
    lean = 0.10
    turn = np.array([(1, 0, 0), (0, np.cos(lean), -np.sin(lean)), (0, np.sin(lean), np.cos(lean))])
    top = bicycle.cranks + np.array([-0.06, 0.04, 0.0])
    tip = np.array([[top[0] - 0.03, 0.20, 0.20 * np.tan(lean) + 0.008]])
    stand = rods(top[None], tip, 0.008, ALLOY)
    mesh = surface([*bicycle_parts(bicycle, 0.1 + 0.37 * (appearance % 7)), stand]).turned(turn.T)
    low, high = mesh.bounds
    x, y = (-0.5 * (low + high)[:2]).tolist()
    return mesh.placed(x, y, -float(low[2]))


@functools.lru_cache(maxsize=512)
def chosen_bicycle(appearance: int, saddle: float = 0.95) -> Bicycle:
    """The bicycle that belongs to a number, its saddle at a height (metres)."""
    rng = np.random.Generator(np.random.PCG64((appearance, 3)))
    paint = _PAINTS[rng.integers(len(_PAINTS))]
    sporty = bool(rng.random() < 0.35)
    basket = str(rng.choice(["none", "front", "rear"], p=(0.6, 0.15, 0.25)))
    return Bicycle(
        saddle=saddle,
        step_through=not sporty and bool(rng.random() < 0.5),
        sporty=sporty,
        basket="none" if sporty else basket,
        paint=Material(tint=paint, mirror=0.05, infrared=0.35),
    )


def stretching(part: Rings, half_base: float, saddle: float, top: float) -> Rings:
    """How a part goes along when wheelbase, height and handlebar are adapted to a box.

    The wheelbase stretches along x; what is above the saddle rises with the rider's head; arms
    and handlebar widen.  Wheels know already where they belong.
    """
    middle = part.centres
    above = np.clip((middle[:, 2] - saddle) / (top - saddle), 0.0, 1.0)
    along = np.clip(middle[:, 0] / half_base, -1.0, 1.0)
    aside = middle[:, 1] / 0.3 * np.minimum(1.0, 6.0 * above)
    fixed = part.give.any(axis=1, keepdims=True)
    give = np.where(fixed, part.give, np.stack([along, aside, above], axis=1))
    return replace(part, give=give)
