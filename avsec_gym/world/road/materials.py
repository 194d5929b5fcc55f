"""Which textures a place's ground wears."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.section import Strip, Surface
from avsec_gym.world.site import Site, Style

_ASPHALTS = {
    Style.CITY: (0, 1, 2, 3, 5, 6),
    Style.RESIDENTIAL: (0, 1, 3, 4, 5, 7),
    Style.CAMPUS: (3, 4, 7),
    Style.HIGHWAY: (0, 1, 2, 6, 7),
    Style.RURAL: (0, 1, 2, 6),
}
_PATH = 1.25
_INFRARED = 0.2
"""Bitumen and stones; what traffic polishes bright looks no brighter to a LiDAR."""
_GREEN_INFRARED = 0.5
"""Grass is bright in the infrared."""


def ground_materials(site: Site) -> dict[str, Material]:
    """For each kind of strip (`Strip.material`, and some for the land) what it is made of.

    Depends on the site's style and seed alone, so that road and land fit together.
    """
    rng = np.random.default_rng((site.seed, 2011))
    shade = float(rng.uniform(1.65, 2.3))
    asphalts = rng.permutation(_ASPHALTS[site.style])

    def of(
        texture: str, variants: int = 1, infrared: float | None = None, grainy: bool = False
    ) -> Material:
        name = f"{texture}/{rng.integers(variants)}" if variants > 1 else texture
        level = float(rng.uniform(0.88, 1.08))
        return Material(name, (level, level, level), infrared=infrared, grainy=grainy)

    return {
        "asphalt": Material(
            f"asphalt/{asphalts[0]}", (shade, shade, shade), infrared=_INFRARED, grainy=True
        ),
        "footway": Material(f"asphalt/{asphalts[1]}", (_PATH, _PATH, _PATH), grainy=True),
        "concrete": of("road_concrete", grainy=True),
        "red_asphalt": of("red_asphalt", grainy=True),
        "cobbles": of("setts", 3),
        "slabs": of("slabs", 4),
        "clinker": of("clinker", 2),
        "kerb": of("kerb_stone"),
        "gravel": of("gravel", grainy=True),
        "grass": of("grass", 4, _GREEN_INFRARED, grainy=True),
        "meadow": of("meadow", 4, _GREEN_INFRARED, grainy=True),
        "soil": of("soil", 2, grainy=True),
        "leaves": of("leaf_litter", grainy=True),
    }


def strip_material(materials: dict[str, Material], strip: Strip) -> Material:
    """Of one strip; asphalt off the carriageway has its own looks."""
    if strip.surface == Surface.KERB:
        return materials["kerb"]
    paths = (Surface.PAVEMENT, Surface.CYCLE_PATH)
    if strip.material == "asphalt" and strip.surface in paths:
        return materials["footway"]
    return materials[strip.material]
