"""Builds up a site: everything that stands beside its road."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import shapely

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.plants import distant_woods, hills
from avsec_gym.world.scenery.built_up import campus, city, residential
from avsec_gym.world.scenery.open_country import highway, rural
from avsec_gym.world.scenery.plot import Placement, Plot
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Site, Style

MANNERS = 24
"""Ways in which a place of a style is built up: shares of shops, gardens or none, which trees and
lamps; some of them are for training and some for judging, see `avsec_gym.world.assets`."""

_STYLES: dict[Style, Callable[[Plot, np.random.Generator, np.random.Generator], None]] = {
    Style.CITY: city,
    Style.RESIDENTIAL: residential,
    Style.CAMPUS: campus,
    Style.HIGHWAY: highway,
    Style.RURAL: rural,
}


def compose(
    site: Site, start: float, end: float, keep_clear: Iterable[shapely.Geometry] = ()
) -> list[Placement]:
    """Place the scenery of a site; same site, same scenery.

    Args:
        site: The place.
        start: Road coordinate along the main course at which scenery begins, metres.
        end: Road coordinate at which it ends, metres.
        keep_clear: Areas where nothing may stand (actors, lines of sight), in the world's
            ground plane.
    """
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((site.seed, 1))))
    plot = Plot(site, start, end, keep_clear)
    # Manner and scenery are two sources of chance: streets of one manner differ in every house.
    number = plot.draw(rng, f"place/{site.style}", MANNERS)
    manner = np.random.default_rng((list(Style).index(site.style), number))
    _STYLES[site.style](plot, manner, rng)
    middle = site.course.poses(0.5 * (start + end), 0.0)
    for backdrop in (distant_woods(rng, 190.0 + 0.5 * (end - start), 420.0), hills(rng)):
        x, y = float(middle[0]), float(middle[1])
        plot.add(_grounded(backdrop.placed(x, y), site), Surface.VEGETATION, (x, y), np.inf)
    return plot.placements


def _grounded(mesh: Mesh, site: Site) -> Mesh:
    """The mesh raised by as much as the ground under each of its points."""
    x, y, z = mesh.vertices.T
    vertices = np.stack([x, y, z + site.ground.height(x, y)], axis=-1)
    return replace(mesh, vertices=vertices.astype(np.float32))
