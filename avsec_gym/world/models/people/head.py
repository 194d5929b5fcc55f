"""Heads: face, hair and hats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.models.people.clothing import Outfit
from avsec_gym.world.models.people.rings import Rings, sweep
from avsec_gym.world.models.people.skeleton import Proportions, Skeleton
from avsec_gym.world.textures.people import HEAD_SIZE

# Level, half sizes to the front, to the back and to the side, and how far the middle is in front
# of the neck's axis; in heights of the head, from chin (level 0) to crown (1).
_HEAD = np.array(
    [
        (-0.32, 0.24, 0.30, 0.27, -0.02),
        (-0.07, 0.25, 0.26, 0.235, 0.03),
        (0.00, 0.36, 0.29, 0.20, 0.08),
        (0.13, 0.37, 0.35, 0.28, 0.09),
        (0.31, 0.36, 0.42, 0.325, 0.10),
        (0.47, 0.35, 0.46, 0.340, 0.10),
        (0.60, 0.37, 0.48, 0.345, 0.10),
        (0.78, 0.335, 0.46, 0.330, 0.10),
        (0.91, 0.26, 0.37, 0.270, 0.09),
        (0.985, 0.14, 0.22, 0.150, 0.07),
        (1.010, 0.03, 0.05, 0.030, 0.05),
    ]
)
_CROWNS = {
    "cap": np.array(
        [
            (0.64, 0.42, 0.52, 0.39, 0.1),
            (0.80, 0.41, 0.52, 0.385, 0.1),
            (0.97, 0.32, 0.40, 0.30, 0.1),
            (1.05, 0.14, 0.18, 0.14, 0.08),
        ]
    ),
    "hat": np.array(
        [
            (0.66, 0.68, 0.76, 0.64, 0.08),
            (0.72, 0.42, 0.50, 0.38, 0.1),
            (1.02, 0.36, 0.44, 0.33, 0.1),
            (1.10, 0.26, 0.32, 0.24, 0.1),
        ]
    ),
    "helmet": np.array(
        [
            (0.62, 0.44, 0.54, 0.40, 0.1),
            (0.82, 0.45, 0.56, 0.41, 0.1),
            (1.02, 0.34, 0.46, 0.32, 0.08),
            (1.12, 0.14, 0.22, 0.14, 0.06),
        ]
    ),
}
_PEAK = np.array([(0.62, 0.30, 0.10, 0.26, 0.48), (0.66, 0.30, 0.10, 0.28, 0.46)])
_SIDES = 12
_HAIR = {"short": 0.035, "receding": 0.02, "bald": 0.0, "long": 0.06, "bob": 0.07}


def head(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """The head with its neck, its hair and what it wears."""
    size = Proportions(skeleton.height).head
    lift = np.array([0.0, 0.0, 0.024 * skeleton.height])
    parts = [_face(outfit), *_hair(outfit), *_hat(outfit)]
    sized = [
        replace(part, centres=part.centres * size + lift, sizes=part.sizes * size) for part in parts
    ]
    return [part.carried(skeleton.head, skeleton.spine[3]) for part in sized]


def _face(outfit: Outfit) -> Rings:
    """The face's own shape, with nose and ears, under a coat of hair."""
    rings = _rows(_HEAD, outfit.head, _SIDES)
    level = rings.centres[:, 2]
    behind = np.interp(np.arange(_SIDES), [0, 2, 4, 6, 8, 10, 12], [0, 0.3, 1, 1, 1, 0.3, 0])
    covered = np.interp(level, [0.05, 0.3, 0.55, 0.75], [0, 0.6, 0.9, 1.0])[:, None] * behind
    covered = np.maximum(covered, np.interp(level, [0.75, 0.9], [0, 1])[:, None])
    bulge = 1.0 + _HAIR.get(outfit.style, 0.035) / 0.36 * covered
    bulge[:, 0] += np.interp(level, [0.13, 0.31, 0.47, 0.56], [0, 0.27, 0.05, 0])
    bulge[:, [3, 9]] += np.interp(level, [0.13, 0.31, 0.47, 0.6], [0, 0.10, 0.15, 0])[:, None]
    turns = (np.arange(_SIDES + 1) / _SIDES + 0.5) * HEAD_SIZE[0]
    down = (1.05 - level) / 1.35 * HEAD_SIZE[1]
    uv = np.stack(np.broadcast_arrays(turns, down[:, None]), axis=-1)
    return replace(rings, bulge=bulge, uv=uv)


def _hair(outfit: Outfit) -> list[Rings]:
    """What stands off the head: long hair over the shoulders, tails and buns."""
    if outfit.style in ("long", "bob"):
        low = -0.62 if outfit.style == "long" else -0.12
        table = np.array(
            [
                (low, 0.04, 0.10, 0.16, -0.30),
                (0.6 * low, 0.08, 0.14, 0.33, -0.22),
                (0.10, 0.15, 0.27, 0.37, -0.14),
                (0.50, 0.16, 0.36, 0.385, -0.09),
                (0.85, 0.16, 0.24, 0.30, -0.06),
            ]
        )
        return [_rows(table, outfit.hair)]
    if outfit.style == "ponytail":
        table = np.array(
            [
                (-0.40, 0.03, 0.03, 0.04, -0.50),
                (0.05, 0.08, 0.08, 0.09, -0.53),
                (0.45, 0.08, 0.08, 0.08, -0.50),
                (0.62, 0.06, 0.06, 0.06, -0.42),
            ]
        )
        return [_rows(table, outfit.hair, sides=6)]
    if outfit.style == "bun":
        table = np.array(
            [
                (0.58, 0.10, 0.10, 0.10, -0.42),
                (0.72, 0.15, 0.15, 0.16, -0.43),
                (0.85, 0.10, 0.10, 0.10, -0.40),
            ]
        )
        return [_rows(table, outfit.hair, sides=6)]
    return []


def _hat(outfit: Outfit) -> list[Rings]:
    if outfit.hat not in _CROWNS:
        return []
    parts = [_rows(_CROWNS[outfit.hat], outfit.headgear)]
    if outfit.hat == "cap":
        parts.append(_rows(_PEAK, outfit.headgear))
    return parts


def _rows(table: Floats, material: Material, sides: int = 8) -> Rings:
    anchors = np.stack([table[:, 4], np.zeros(len(table)), table[:, 0]], axis=1)
    return sweep(anchors, (0, 0, 1), (1, 0, 0), table[:, 1:4], material, sides=sides)
