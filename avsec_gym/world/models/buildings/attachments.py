"""What hangs on a facade: balconies, steps, downpipes, awnings, signs, canopies."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings.palette import ALUMINIUM
from avsec_gym.world.models.buildings.panels import Panels, boxes, quads, slab


def balconies(
    places: ArrayLike,
    width: float,
    depth: float,
    floor: Material,
    parapet: Material,
    *,
    bars: bool = False,
) -> list[Panels]:
    """Slabs with a parapet on three sides.

    Args:
        places: Middle of each at the wall: x, z of its floor, shape (n, 2).
        width: Width of each, metres.
        depth: Depth before the wall, metres.
        floor: Material of the slab.
        parapet: Material of the parapet, or of its bars.
        bars: An open railing, else solid panels.
    """
    spots = np.asarray(places, float).reshape(-1, 2)
    at = np.stack([spots[:, 0], np.zeros(len(spots)), spots[:, 1]], axis=1)
    half, front = 0.5 * width, -depth
    parts = [boxes(floor, (-half, front, -0.18), (half, 0.0, 0.0), without=("back",))]
    if bars:
        parts += _railing(parapet, half, front)
    else:
        edge, inner, low, high = half + 0.02, half - 0.04, -0.12, 0.95
        near, far = front - 0.04, front + 0.06
        parts += [
            boxes(parapet, (-edge, near, low), (edge, far, high), without=("top", "bottom")),
            boxes(
                parapet,
                [(-edge, far, low), (inner, far, low)],
                [(-inner, 0.0, high), (edge, 0.0, high)],
                without=("front", "back", "bottom"),
            ),
            boxes(
                ALUMINIUM,
                (-edge, near - 0.01, high),
                (edge, far, high + 0.05),
                without=("bottom", "left", "right"),
            ),
        ]
    return [part.at(at) for part in parts]


def steps(x: float, width: float, height: float, stone: Material) -> list[Panels]:
    """Stairs of at most 0.17 m each up to a door's threshold, before the facade."""
    count = max(1, round(height / 0.17))
    rise = height / count
    number = np.arange(count)
    reach = 0.3 * (count - number) + 0.15
    low = np.stack([np.full(count, x - 0.5 * width), -reach, rise * number - 0.3], axis=1)
    high = np.stack([np.full(count, x + 0.5 * width), np.zeros(count), rise * (number + 1)], axis=1)
    return [boxes(stone, low, high, without=("back", "bottom"))]


def downpipes(columns: ArrayLike, top: float, material: Material, out: float = 0.06) -> Panels:
    """From the gutter to the ground, before the wall."""
    x = np.atleast_1d(np.asarray(columns, float))
    low = np.stack([x - 0.05, np.full_like(x, -out - 0.1), np.full_like(x, -0.2)], axis=1)
    high = np.stack([x + 0.05, np.full_like(x, -out), np.full_like(x, top)], axis=1)
    return boxes(material, low, high, without=("top", "bottom"))


def awning(left: float, right: float, z: float, depth: float, cloth: Material) -> list[Panels]:
    """Cloth that falls from the wall at height z towards the street, with a valance."""
    fall = 0.32 * depth
    plane = [(left, -depth, z - fall), (right, -depth, z - fall), (right, 0.0, z), (left, 0.0, z)]
    skirt = boxes(
        cloth, (left, -depth - 0.02, z - fall - 0.2), (right, -depth, z - fall), without=("top",)
    )
    return [*slab(cloth, plane, 0.03, under=cloth, edge=cloth), skirt]


def canopy(x: float, width: float, depth: float, z: float, material: Material) -> Panels:
    """A flat roof over an entrance."""
    return boxes(material, (x - 0.5 * width, -depth, z), (x + 0.5 * width, 0.0, z + 0.14))


def sign(left: float, right: float, low: float, high: float, variant: int) -> list[Panels]:
    """A box with a shop's name on its front."""
    case = Material("plain", (0.12, 0.12, 0.12))
    front = Material(f"shop_sign/{variant}", mirror=0.02, infrared=0.4)
    body = boxes(case, (left, -0.16, low), (right, 0.0, high), without=("back", "front"))
    corners = np.array([[(left, low), (right, low), (right, high), (left, high)]])
    face = np.insert(corners, 1, -0.16, axis=2)
    return [body, Panels(face, np.array([[(0, 1), (1, 1), (1, 0), (0, 0)]], float), front)]


def satellite_dish(x: float, y: float, z: float) -> list[Panels]:
    """A plate on an arm, looking at the street."""
    angle = np.linspace(0.0, 2.0 * np.pi, 9)[:8]
    rim = np.stack([x + 0.4 * np.cos(angle), y - 0.1 * np.sin(angle), z + 0.4 * np.sin(angle)], 1)
    dish = Material("plain", (0.6, 0.6, 0.58))
    hub = np.array([x, y + 0.12, z])
    after = np.roll(rim, -1, axis=0)
    corners = np.stack([np.broadcast_to(hub, rim.shape), rim, after, after], axis=1)
    back = (0.0, 0.03, 0.0)
    edge = np.stack([rim, np.add(rim, back), np.add(after, back), after], axis=1)
    arm = boxes(dish, (x - 0.03, y + 0.05, z - 0.9), (x + 0.03, y + 0.11, z))
    return [
        quads(dish, np.concatenate([corners, np.add(corners[:, [0, 2, 1, 1]], back), edge])),
        arm,
    ]


def _railing(iron: Material, half: float, front: float) -> list[Panels]:
    """A hand rail on bars 0.13 m apart."""
    along = np.arange(-half + 0.02, half, 0.13)
    side = np.arange(front + 0.13, -0.05, 0.13)
    x = np.concatenate([along, np.full(len(side), -half), np.full(len(side), half - 0.03)])
    y = np.concatenate([np.full(len(along), front), side, side])
    low = np.stack([x, y, np.zeros(len(x))], axis=1)
    return [
        boxes(iron, low, np.add(low, (0.025, 0.025, 0.95)), without=("back", "top", "bottom")),
        boxes(
            iron,
            [
                (-half, front - 0.02, 0.95),
                (-half, front + 0.04, 0.95),
                (half - 0.03, front + 0.04, 0.95),
            ],
            [(half, front + 0.04, 1.0), (-half + 0.03, 0.0, 1.0), (half, 0.0, 1.0)],
        ),
    ]
