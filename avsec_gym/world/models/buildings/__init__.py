"""Buildings along the streets of Karlsruhe, and the walls and fences before them.

A building's footprint is centred in x; its street facade lies in the plane y = 0 and looks at -y;
its body extends to y = depth.  The ground is z = 0, and walls go on 0.6 m below it, for slopes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.buildings.apartment import apartment
from avsec_gym.world.models.buildings.campus import campus
from avsec_gym.world.models.buildings.detached import detached
from avsec_gym.world.models.buildings.fences import garden_wall, picket_fence
from avsec_gym.world.models.buildings.sheds import garage, hall
from avsec_gym.world.models.buildings.terrace import shop, terrace

__all__ = [
    "FRONT_OVERHANG",
    "KINDS",
    "SIDE_OVERHANG",
    "garden_wall",
    "make_building",
    "picket_fence",
]

FRONT_OVERHANG = 2.0
"""How far eaves, balconies, awnings and steps reach before the facade, metres."""

KINDS: dict[str, Callable[[float, float, np.random.Generator], Mesh]] = {
    "detached": detached,
    "terrace": terrace,
    "apartment": apartment,
    "shop": shop,
    "garage": garage,
    "campus": campus,
    "hall": hall,
}
"""Kind of building to the function that makes it from width, depth (metres) and chance."""

SIDE_OVERHANG: dict[str, float] = {
    "detached": 0.75,
    "terrace": 0.05,
    "apartment": 0.65,
    "shop": 0.05,
    "garage": 0.1,
    "campus": 0.35,
    "hall": 0.2,
}
"""How far eaves and rims reach beyond the footprint, left and right, metres."""


def make_building(kind: str, width: float, depth: float, rng: np.random.Generator) -> Mesh:
    """One building; see the module for its frame.

    Args:
        kind: Kind of the building, one of `KINDS`.
        width: Width of the footprint along the street, metres; 7 or more (garages 3, halls 10).
        depth: Depth of the footprint, metres; 6 or more.
        rng: Generator that draws everything else: style, storeys, colours, windows.

    Raises:
        ConfigurationError: No such kind.
    """
    if kind not in KINDS:
        raise ConfigurationError(f"{kind!r} is no kind of building; there are {', '.join(KINDS)}")
    return KINDS[kind](width, depth, rng)
