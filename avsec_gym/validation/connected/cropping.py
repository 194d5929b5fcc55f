"""A vehicle's part of step 3: its scan, cropped to each region and joined with its mirror image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True)
class CropMargins:
    """How much more than a proposal is cropped: every region is to hold some of the ground.

    Beside it nothing is, as in the thesis: surfaces that reach down to the ground there halve the
    distance of what stands in it.

    Args:
        sides: Metres at each of the four sides.
        below: Metres below the bottom.
        above: Metres above the top.

    Raises:
        ConfigurationError: A negative margin, or one that is not finite.
    """

    sides: float = 0.0
    below: float = 0.5
    above: float = 0.5

    def __post_init__(self) -> None:
        if not all(0 <= margin < np.inf for margin in (self.sides, self.below, self.above)):
            raise ConfigurationError(f"margins are 0 m or more, got {self}")


def cropped(
    scan: VehicleScan, regions: Regions, margins: CropMargins = CropMargins()
) -> list[Floats]:
    """The points of a scan in each region.

    Args:
        scan: The scan of the vehicle.
        regions: The complete set of regions, world frame.
        margins: How much more than a region is taken.

    Returns:
        For each region an array (M, 3) in the region's own frame, see `Regions.local`.
    """
    if not len(regions):
        return []
    half = regions.size[:, :2] / 2 + margins.sides
    low = np.full(len(regions), -margins.below)
    high = regions.size[:, 2] + margins.above
    points = np.ascontiguousarray(scan.in_world())
    which, local = _points_in(points, regions.centre, regions.heading, half, low, high)
    order = np.argsort(which, kind="stable")
    return np.split(local[order], np.searchsorted(which[order], np.arange(1, len(regions))))


def mirrored(points: Floats) -> Floats:
    """A crop joined with its mirror image about the vertical plane of symmetry of its region.

    A vehicle's left side is like its right one, and only one of them is lit by the sensor. The
    plane goes through the region's middle, along its heading.

    Args:
        points: Points in the region's frame, shape (M, 3).

    Returns:
        The points, then their images, shape (2 M, 3).

    Example:
        >>> mirrored(np.array([[2.0, 0.8, 1.0]])).tolist()
        [[2.0, 0.8, 1.0], [2.0, -0.8, 1.0]]
    """
    return np.concatenate([points, points * [1.0, -1.0, 1.0]])


@kernel(nogil=True)
def _points_in(
    points: Floats,
    centre: Floats,
    heading: Floats,
    half: Floats,
    low: Floats,
    high: Floats,
) -> tuple[NDArray[np.int64], Floats]:
    """Every point of every region: the number of the region, and the point in its frame.

    Invariant: the first `found` rows are filled, by point and then by region; the memory doubles
    when it is full.
    """
    cos, sin = np.cos(heading), np.sin(heading)
    reach = half[:, 0] ** 2 + half[:, 1] ** 2
    which = np.empty(len(points), np.int64)
    local = np.empty((len(points), 3))
    found = 0
    for p in range(len(points)):
        for r in range(len(centre)):
            x, y = points[p, 0] - centre[r, 0], points[p, 1] - centre[r, 1]
            z = points[p, 2] - centre[r, 2]
            if x * x + y * y > reach[r] or z < low[r] or z > high[r]:
                continue
            along, across = cos[r] * x + sin[r] * y, cos[r] * y - sin[r] * x
            if abs(along) > half[r, 0] or abs(across) > half[r, 1]:
                continue
            # Regions may overlap: a point counts in each that it lies in.
            if found == len(which):
                more, more_local = np.empty(2 * found, np.int64), np.empty((2 * found, 3))
                for i in range(found):
                    more[i] = which[i]
                    for k in range(3):
                        more_local[i, k] = local[i, k]
                which, local = more, more_local
            which[found] = r
            local[found, 0], local[found, 1], local[found, 2] = along, across, z
            found += 1
    return which[:found], local[:found]
