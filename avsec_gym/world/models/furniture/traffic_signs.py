"""Traffic signs on their poles, facing oncoming traffic (-x)."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import ALUMINIUM, GALVANISED
from avsec_gym.world.models.furniture.plate import plate
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.variants import Model, prescribed
from avsec_gym.world.shapes import box
from avsec_gym.world.textures.sign_faces import SIGN_FACES
from avsec_gym.world.textures.sign_symbols import outline

_RADIUS = 0.032
"""Radius of a pole."""
_GAP = 0.04
"""Between two signs on one pole."""


@functools.cache
def sign_plate(name: str, *, two_sided: bool = False) -> Mesh:
    """A sign without its pole, centred at the origin.

    Raises:
        KeyError: `SIGN_FACES` has no such sign.
    """
    face = SIGN_FACES[name]
    picture = Material(f"sign_{name}", mirror=0.03, infrared=1.0)
    corners = outline(face.outline, face.width, face.height)
    return plate(corners, picture, picture if two_sided else ALUMINIUM)


def traffic_sign(*names: str, clearance: float = 2.1, rise: float = 0.0) -> Mesh:
    """Signs on one pole, the first uppermost.

    Args:
        names: Names in `SIGN_FACES`.
        clearance: Height of the lowest sign's lower edge above the ground, metres.
        rise: Height of the pole above the upper edge, metres.

    Raises:
        KeyError: There is no such sign.
    """
    parts = []
    height = clearance
    for name in reversed(names):
        face = SIGN_FACES[name]
        middle = height + 0.5 * face.height
        parts.append(sign_plate(name).placed(-_RADIUS - 0.02, 0.0, middle))
        clamp = box(0.05, 0.1, 0.03, GALVANISED)
        parts += [clamp.placed(-0.005, 0.0, middle + z * face.height) for z in (-0.25, 0.22)]
        height += face.height + _GAP
    parts.append(pole(height - _GAP - 0.05 + rise, _RADIUS))
    return merge(parts)


def board_on_two_poles(name: str, clearance: float, *, two_sided: bool = False) -> Mesh:
    """A wide sign on two poles: town entrance, direction board.

    Raises:
        KeyError: There is no such sign.
    """
    face = SIGN_FACES[name]
    sign = sign_plate(name, two_sided=two_sided)
    posts = [
        pole(clearance + face.height - 0.02, _RADIUS).placed(0.0, side * 0.36 * face.width)
        for side in (-1, 1)
    ]
    return merge([sign.placed(-_RADIUS - 0.02, 0.0, clearance + 0.5 * face.height), *posts])


@prescribed
def street_name(rng: np.random.Generator) -> Mesh:
    """One or two street-name plates on a pole, readable from both sides."""
    names = [name for name in SIGN_FACES if name.startswith("street_name")]
    first, second = (names[i] for i in rng.permutation(len(names))[:2])
    return _street_name(first, second if rng.random() < 0.6 else None)


@functools.cache
def _street_name(first: str, second: str | None) -> Mesh:
    width = SIGN_FACES[first].width
    parts = [pole(2.75, _RADIUS)]
    arm = sign_plate(first, two_sided=True).placed(0.0, -0.5 * width - _RADIUS, 2.62)
    parts.append(arm)
    if second is not None:
        across = sign_plate(second, two_sided=True).placed(0.0, -0.5 * width - _RADIUS, 2.42)
        parts.append(across.placed(0.0, 0.0, 0.0, -np.pi / 2))
    return merge(parts)


def _standing(names: Sequence[str], clearance: float, rise: float) -> Model:
    @functools.cache
    def sign() -> Mesh:
        return traffic_sign(*names, clearance=clearance, rise=rise)

    return prescribed(lambda rng: sign())


def _two_poled(names: Sequence[str], clearance: float, two_sided: bool) -> Model:
    @functools.cache
    def sign(index: int) -> Mesh:
        return board_on_two_poles(names[index], clearance, two_sided=two_sided)

    return prescribed(lambda rng: sign(int(rng.integers(len(names)))))


def _family(start: str) -> list[str]:
    return [name for name in SIGN_FACES if name.startswith(start)]


_LOW = {"keep_right": 0.6, "straight_or_right": 0.6, "bend_arrows": 0.9, "exit": 0.8}
"""Signs on islands and in bends stand low; clearance in metres."""
_COMBINED = {
    "no_vehicles_but_residents": ("no_vehicles", "residents"),
    "priority_road_50": ("speed_50", "priority_road"),
    "crossing_and_children": ("children", "speed_30"),
}

SIGNS: dict[str, Model] = {
    **{
        f"sign_{name}": _standing([name], _LOW.get(name, 2.1), 0.0)
        for name in SIGN_FACES
        if not name.startswith(
            ("street_name", "town", "direction", "gantry", "bend_arrows", "exit")
        )
    },
    **{f"sign_{name}": _standing(names, 2.0, 0.3) for name, names in _COMBINED.items()},
    "sign_street_name": street_name,
    "sign_town": _two_poled(_family("town"), 1.5, True),
    "sign_direction": _two_poled(_family("direction"), 1.7, False),
    "sign_bend_arrows": _two_poled(["bend_arrows"], 0.9, False),
    "sign_exit": _two_poled(["exit"], 1.1, False),
}
