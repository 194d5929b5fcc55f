"""How the other camera sees a patch: projected by the calibration.

A rectified pair ought to differ by a shift along the rows alone.  KITTI's real calibrations do not
quite: P2 and P3 also differ in their second and third rows' last entries, by up to 3.8 pixels x
metres and 2.7 mm, which moves a patch at 8 m by up to 0.4 pixels, mostly up or down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class PatchView:
    """A patch in one image of a pair.

    Args:
        centre: Column and row of its centre, pixels, shape (2,).
        to_left: Matrix from an offset from that centre, in pixels of this image, to the offset that
            the left image shows the same point at, shape (2, 2).
        reach: Number of columns and rows by which it extends either way from its centre, shape
            (2,).
    """

    centre: Floats
    to_left: Floats
    reach: Floats

    def is_inside(self, height: int, width: int, rim: float = 0.0) -> bool:
        """Whether an image of such a size shows all of it but a rim of some pixels."""
        last = np.array([width - 1, height - 1])
        first = self.centre - self.reach
        return bool((first >= -rim).all() and (self.centre + self.reach <= last + rim).all())


def left_view(place: PatchPlace) -> PatchView:
    """The left image shows the disc at its place."""
    return PatchView(np.array([place.u, place.v]), np.eye(2), np.full(2, place.radius))


def right_view(place: PatchPlace, left: Floats, right: Floats) -> PatchView:
    """What the right camera sees of the poster that the left one sees as a disc.

    The poster is the part of the plane at a constant depth before the left camera that the disc
    hides.  Where the cameras differ by a shift along x alone, this is exactly the same disc,
    `PatchPlace.disparity` further left.

    Args:
        place: Place of the patch in pixels of these projections.
        left: P of the left camera, shape (3, 4), third row 0 0 1 t_z.
        right: P of the right camera.
    """
    # A pixel p of the left image at depth w is seen at (turn p + shift / w) in the right one, in
    # homogeneous coordinates: X = K_l^-1 (w p - t_l), and w' p' = K_r X + t_r.
    turn = np.eye(3)
    if not np.array_equal(left[:, :3], right[:, :3]):
        turn = right[:, :3] @ np.linalg.inv(left[:, :3])
    shift = right[:, 3] - turn @ left[:, 3]
    # 1 / w = disparity / (focal length x baseline), see `patch_placement.focal_times_baseline`.
    focal_times_baseline = left[0, 3] - right[0, 3] * (left[0, 0] / right[0, 0])
    seen = turn @ [place.u, place.v, 1.0] + place.disparity * (shift / focal_times_baseline)
    # One depth for all of the poster: from disc to disc the change is linear.
    from_left = turn[:2, :2] / seen[2]
    reach = place.radius * np.hypot(from_left[:, 0], from_left[:, 1])
    return PatchView(seen[:2] / seen[2], np.linalg.inv(from_left), reach)
