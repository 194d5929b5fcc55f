"""Bus shelters; the open side is the front (-x)."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.advertising import lit_poster
from avsec_gym.world.models.furniture.materials import WOOD, painted
from avsec_gym.world.models.furniture.plate import board
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box


@variants(4)
def bus_shelter(rng: np.random.Generator) -> Mesh:
    """A roof on four posts with a bench, a timetable and a poster, 4 m by 1.5 m, 2.5 m high.

    Its panes stand only as their frosted bands: clear glass shows neither to a camera nor to
    a LiDAR.
    """
    paint = painted(*((0.06, 0.07, 0.08), (0.1, 0.14, 0.3), (0.3, 0.31, 0.32))[rng.integers(3)])
    frosted = Material(tint=(0.55, 0.6, 0.6), mirror=0.08, infrared=0.3)
    posts = [
        box(0.07, 0.07, 2.4, paint).placed(x, y) for x in (-0.5, 0.6) for y in (-1.9, 0.0, 1.9)
    ]
    rails = [box(0.05, 3.8, 0.05, paint).placed(0.6, 0, z) for z in (0.2, 1.15, 2.1)]
    bands = [
        box(0.012, 1.8, 0.07, frosted).placed(0.6, y, z) for y in (-0.95, 0.95) for z in (0.85, 1.5)
    ]
    sides = [box(1.0, 0.05, 0.05, paint).placed(0.05, -1.9, z) for z in (0.2, 1.15, 2.1)]
    seat = [box(0.1, 1.7, 0.035, WOOD).placed(x, -0.9, 0.46) for x in (0.28, 0.41)]
    legs = [box(0.3, 0.05, 0.46, paint).placed(0.35, y) for y in (-1.5, -0.3)]
    timetable = board(0.6, 0.85, Material(tint=(0.75, 0.75, 0.72)), frosted).placed(
        0.56, 0.95, 1.45
    )
    poster = lit_poster(rng).placed(0.0, 0.0, 0.0, np.pi / 2).placed(0.05, 1.95, 0.35)
    roof = [
        box(1.55, 4.3, 0.06, paint).placed(0.0, 0, 2.47),
        box(1.45, 4.2, 0.09, frosted).placed(0.0, 0, 2.38),
    ]
    # The poster's foot is longer than the shelter needs; the pavement hides its end.
    return merge([*posts, *rails, *bands, *sides, *seat, *legs, timetable, poster, *roof])
