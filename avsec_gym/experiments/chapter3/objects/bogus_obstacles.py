"""Is a bogus return taken for an obstacle?

The thesis (section 3.2.4) does not state how it decides.  Here it is where a box covers half of the
bogus patch or more, seen from above, with half a metre to spare: a network that looks for whole
cars puts one behind the face that it sees.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.box_overlap import ground_rectangles, rectangle_overlap
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import transform_points

SPARE = 0.5
"""Metres around a box that still count as it."""
COVERED = 0.5
"""Share of the patch."""
_THICKNESS = 0.1


def bogus_patch(tampered: TamperedFrame) -> Boxes3D:
    """Where the bogus points of `LidarSpoofing` stand, as one box as thin as a screen.

    Empty where no beam met the patch.
    """
    frame = tampered.frame
    places = transform_points(
        frame.calibration.velodyne_to_camera, frame.points[tampered.points, :3]
    )
    if not len(places):
        return Boxes3D.empty()
    bearing = tampered.settings["bearing"]
    cos, sin = np.cos(bearing), np.sin(bearing)
    # Across the bearing, and along it: positive bearings are to the left, x is to the right.
    across = places[:, 0] * cos + places[:, 2] * sin
    middle, ahead = (
        np.ptp(across) / 2 + across.min(),
        (places[:, 2] * cos - places[:, 0] * sin).mean(),
    )
    return Boxes3D(
        location=np.array(
            [[middle * cos - ahead * sin, places[:, 1].max(), middle * sin + ahead * cos]]
        ),
        dimensions=np.array([[np.ptp(places[:, 1]), _THICKNESS, np.ptp(across)]]),
        rotation_y=np.array([-bearing]),
        score=np.ones(1),
        category=np.array(["Misc"]),
    )


def taken_for_an_obstacle(found: Boxes3D, patch: Boxes3D) -> bool:
    """Whether one of the boxes covers the patch.

    Args:
        found: The boxes of a detector, in space.
        patch: The bogus patch, see `bogus_patch`.
    """
    return bool(covering(found, patch).any())


def covering(found: Boxes3D, place: Boxes3D) -> NDArray[np.bool_]:
    """Which of N boxes cover a place, shape (N,).

    Args:
        found: The boxes of a detector, in space.
        place: One box; no box covers an empty place.
    """
    if not len(place):
        return np.zeros(len(found), bool)
    grown = ground_rectangles(found.location, found.dimensions + 2 * SPARE, found.rotation_y)
    own = ground_rectangles(place.location, place.dimensions, place.rotation_y)
    common = rectangle_overlap(grown, own)
    return np.asarray((common >= COVERED * own[:, 2] * own[:, 3]).any(axis=1))
