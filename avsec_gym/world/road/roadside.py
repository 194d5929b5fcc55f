"""What lies beside the carriageway: parking, kerb, cycle path, trees, pavement, verge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.world.section import Surface
from avsec_gym.world.site import Style


class RoadsidePart(NamedTuple):
    """A strip without its place."""

    surface: Surface
    width: float
    height: float
    material: str


def roadside(
    rng: np.random.Generator, style: Style, parked: float, road_material: str
) -> list[RoadsidePart]:
    """Strips from the carriageway's edge outwards.

    Args:
        rng: The source of chance.
        style: Style in which the place is built up.
        parked: Depth of the parking strip, metres; 0 for none.
        road_material: Material of the carriageway.
    """
    if style == Style.RURAL:
        return _country(rng, parked)
    if style == Style.CAMPUS:
        return _campus(rng, parked)
    parts = []
    if parked > 0:
        setts = parked < 4.0 and rng.random() < (0.6 if style == Style.RESIDENTIAL else 0.35)
        if setts:
            parts.append(RoadsidePart(Surface.KERB, 0.14, 0.0, "kerb"))
            parked -= 0.14
        material = "cobbles" if setts else road_material
        parts.append(RoadsidePart(Surface.PARKING, parked, 0.0, material))
    elif rng.random() < 0.6:
        material = str(rng.choice(["cobbles", "concrete"]))
        parts.append(RoadsidePart(Surface.ROAD, float(rng.uniform(0.16, 0.32)), 0.0, material))
    height = 0.12 if style == Style.CITY or rng.random() < 0.5 else 0.08
    parts.append(RoadsidePart(Surface.KERB, 0.14, height, "kerb"))
    parts += _pavement(rng, style, height)
    return parts


def parking(rng: np.random.Generator) -> float:
    """Depth of a parking strip along the road, metres."""
    return float(rng.uniform(2.0, 2.3))


def _pavement(rng: np.random.Generator, style: Style, height: float) -> list[RoadsidePart]:
    city = style == Style.CITY
    width = float(rng.uniform(2.2, 4.0) if city else rng.uniform(1.5, 2.4))
    usual = [0.6, 0.2, 0.2] if city else [0.4, 0.35, 0.25]
    material = str(rng.choice(["slabs", "asphalt", "clinker"], p=usual))
    parts = []
    if rng.random() < (0.25 if city else 0.15):
        green = str(rng.choice(["grass", "soil"]))
        parts.append(RoadsidePart(Surface.VERGE, float(rng.uniform(1.2, 2.2)), height, green))
    if city and rng.random() < 0.25:
        parts.append(RoadsidePart(Surface.CYCLE_PATH, 1.5, height, "red_asphalt"))
    parts.append(RoadsidePart(Surface.PAVEMENT, width, height, material))
    return parts


def _campus(rng: np.random.Generator, parked: float) -> list[RoadsidePart]:
    parts = []
    if parked > 0:
        parts.append(
            RoadsidePart(Surface.PARKING, parked, 0.0, str(rng.choice(["cobbles", "gravel"])))
        )
    parts.append(RoadsidePart(Surface.KERB, 0.10, 0.0, "kerb"))
    if rng.random() < 0.5:
        parts.append(RoadsidePart(Surface.VERGE, float(rng.uniform(1.0, 3.0)), 0.0, "grass"))
        parts.append(RoadsidePart(Surface.PAVEMENT, float(rng.uniform(1.8, 3.0)), 0.0, "slabs"))
    parts.append(RoadsidePart(Surface.VERGE, 3.0, 0.0, str(rng.choice(["grass", "leaves"]))))
    return parts


def _country(rng: np.random.Generator, parked: float) -> list[RoadsidePart]:
    parts = []
    if parked > 0:
        parts.append(RoadsidePart(Surface.PARKING, parked, 0.0, "gravel"))
    elif rng.random() < 0.6:
        parts.append(RoadsidePart(Surface.VERGE, float(rng.uniform(0.3, 0.9)), 0.0, "gravel"))
    parts.append(RoadsidePart(Surface.VERGE, float(rng.uniform(1.5, 3.0)), 0.0, "grass"))
    if rng.random() < 0.3:
        parts.append(RoadsidePart(Surface.CYCLE_PATH, float(rng.uniform(2.0, 2.5)), 0.0, "asphalt"))
        parts.append(RoadsidePart(Surface.VERGE, 1.0, 0.0, "grass"))
    return parts
