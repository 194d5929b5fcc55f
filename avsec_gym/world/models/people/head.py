"""Heads: face, hair and hats."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.models.people.clothing import Outfit
from avsec_gym.world.models.people.rings import Floats, Rings, sweep
from avsec_gym.world.models.people.skeleton import Proportions, Skeleton
from avsec_gym.world.textures.people import HEAD_SIZE

# Level, then half sizes to the front, to the back and to the side, and how far the middle is in
# front of the neck's axis; in heights of the head from chin (0) to crown (1).
_HEAD = np.array(
    [
        (-0.30, 0.24, 0.29, 0.26, 0.00),
        (-0.06, 0.25, 0.27, 0.24, 0.04),
        (0.00, 0.37, 0.28, 0.22, 0.08),
        (0.09, 0.375, 0.32, 0.27, 0.10),
        (0.20, 0.36, 0.37, 0.30, 0.11),
        (0.31, 0.36, 0.42, 0.325, 0.11),
        (0.47, 0.35, 0.47, 0.340, 0.11),
        (0.60, 0.37, 0.49, 0.345, 0.11),
        (0.78, 0.335, 0.47, 0.330, 0.11),
        (0.92, 0.24, 0.36, 0.250, 0.10),
        (0.985, 0.12, 0.20, 0.130, 0.08),
    ]
)
_SIDES = 12


def head(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """The head with its neck, its hair and what it wears."""
    size = Proportions(skeleton.height).head
    place = skeleton.spine[3] + np.array([0.0, 0.0, 0.021 * skeleton.height]) * 1.0
    parts = [_face(size, outfit), *_hair(size, outfit), *_hat(size, outfit)]
    lifted = np.array([0.0, 0.0, 0.22 * size])
    return [
        part.attached((0.0, 0.0, 0.0)).carried(skeleton.head, place + skeleton.head @ lifted - lifted)
        if False
        else part.attached((0.0, 0.0, 0.0)).carried(skeleton.head, place)
        for part in parts
    ]


def _rows(table: Floats, size: float, outfit: Outfit, material: int = 0, **options: object) -> Rings:
    raise NotImplementedError


def _face(size: float, outfit: Outfit) -> Rings:
    raise NotImplementedError
