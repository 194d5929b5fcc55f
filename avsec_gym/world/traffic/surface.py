"""The height of the ground under an actor: land, kerbs, and the mouths of side streets."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.world.site import Site


def surface_height(site: Site, x: ArrayLike, y: ArrayLike) -> Floats:
    """Height of road, pavement or land, metres, of the inputs' shape."""
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    _, left = site.course.coordinates(x, y)
    above = site.section.height(left)
    right_edge, left_edge = site.section.carriageway
    for street in site.side_streets:
        away, across = street.course.coordinates(x, y)
        beyond = np.maximum(left - left_edge, right_edge - left)
        near_right, near_left = street.section.carriageway
        # The rounded corners widen the mouth.
        inside = np.clip(street.radius - beyond, 0.0, street.radius)
        corner = street.radius - np.sqrt(street.radius**2 - inside**2)
        mouth = (across > near_right - corner) & (across < near_left + corner)
        theirs = (left * street.side > 0) & (beyond > 0) & (away > 0)
        outer = site.section.edges[1] if street.side > 0 else -site.section.edges[0]
        behind = theirs & (away > outer)
        above = np.where(behind, street.section.height(across), above)
        above = np.where(theirs & mouth & (away < street.course.end), 0.0, above)
    return np.asarray(site.ground.height(x, y) + above)
