"""Disparity error E_{i,j,k} between two disparity maps of one view (thesis, section 3.3.2).

E counts contradictions of disparity in the whole view.  Three more shares say what it overlooks:
light that leaves a matcher nothing to match, light that it copes with, and a contradiction that is
small, but all in one place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.brightness import FEWEST
from avsec_gym.validation.disparity_maps import DisparityMaps

MIN_DIFFERENCE = 3.0
"""Pixels (equation 3.2)."""
MIN_RELATIVE_DIFFERENCE = 0.05
"""Share of the smaller disparity."""
WINDOW = 96
"""Pixels to a side of where contradictions are counted together; a car's rear 12 m ahead."""
MEASURES = ("error", "hole_share", "densest", "brightness")
"""Shares of a `DisparityError`: E of the thesis, and what goes beyond it."""


class Comparison(IntEnum):
    """What two maps say of a pixel."""

    UNKNOWN = 0
    """Neither map knows it."""
    FIRST_ONLY = 1
    """A hole of the second map."""
    SECOND_ONLY = 2
    """A hole of the first map, or a gap between a scan's points."""
    CONSISTENT = 3
    INCONSISTENT = 4


@dataclass(frozen=True)
class DisparityError:
    """How far two maps of one view contradict each other, and how much they say at all.

    Args:
        inconsistent: Pixels whose disparities differ (equation 3.2).
        valid: Pixels known in both maps.
        pixels: That could be known in both: those of the scan, of two dense maps all.
        densest: The share of inconsistent pixels in that window of `WINDOW` which has most.
        brightness: `brightness_inconsistency` of that pair of the triple's cameras, the reference
            among them, which has more.
    """

    inconsistent: int
    valid: int
    pixels: int
    densest: float = 0.0
    brightness: float = 0.0

    @property
    def error(self) -> float:
        """E, the share of the valid pixels that are inconsistent; 1 with fewer than `FEWEST`."""
        return self.inconsistent / self.valid if self.valid >= FEWEST else 1.0

    @property
    def holes(self) -> int:
        """Pixels that could not be compared: of the dense map under a scan, of either of two."""
        return self.pixels - self.valid

    @property
    def hole_share(self) -> float:
        """Holes among all pixels that could be known; matchers fail where light hides the scene."""
        return self.holes / self.pixels if self.pixels >= FEWEST else 1.0

    @property
    def shares(self) -> Floats:
        """All `MEASURES`, shape (4,)."""
        return np.array([getattr(self, name) for name in MEASURES])


def disparity_error(
    first: DisparityMap, second: DisparityMap, *, sparse: bool = False
) -> DisparityError:
    """Compare two maps in the scale of the second (equation 3.2); brightness is left out.

    Args:
        first: DM_{i,k}, in any scale.
        second: DM_{j,k}.
        sparse: Whether the first is a scan, whose gaps are no holes.

    Raises:
        ConfigurationError: The maps differ in shape.

    Example:
        >>> near = DisparityMap(np.full((20, 20), 10, np.float32), 100.0)
        >>> far = near.values.copy()
        >>> far[:5] -= 4
        >>> disparity_error(near, DisparityMap(far, 100.0)).error
        0.25
    """
    compared = comparison_map(first, second)
    counts = np.bincount(compared.ravel(), minlength=len(Comparison))
    inconsistent = int(counts[Comparison.INCONSISTENT])
    valid = inconsistent + int(counts[Comparison.CONSISTENT])
    pixels = valid + int(counts[Comparison.FIRST_ONLY]) if sparse else first.values.size
    here = np.asarray(compared == Comparison.INCONSISTENT, np.float32)
    densest = cv2.blur(here, (WINDOW, WINDOW), borderType=cv2.BORDER_CONSTANT).max()
    return DisparityError(inconsistent, valid, pixels, float(np.clip(densest, 0, 1)))


def comparison_map(first: DisparityMap, second: DisparityMap) -> NDArray[np.uint8]:
    """Which `Comparison` holds at each pixel; see `disparity_error`.

    Returns:
        Shape (H, W).
    """
    if first.values.shape != second.values.shape:
        raise ConfigurationError(
            f"two maps of one view have one shape, got {first.values.shape} and "
            f"{second.values.shape}"
        )
    return _compare(first.rescaled(second.focal_times_baseline).values, second.values)


class DisparityErrors(Mapping[Triple, DisparityError]):
    """E_{i,j,k} of all triples of a moment; each is worked out when first asked for, and kept.

    Args:
        maps: Of the moment.
    """

    def __init__(self, maps: DisparityMaps) -> None:
        self.maps = maps
        self._known: dict[Triple, DisparityError] = {}

    def __getitem__(self, triple: Triple) -> DisparityError:
        """E_{i,j,k}; see `DisparityMaps` for what can go wrong."""
        if triple not in self._known:
            i, j, k = triple
            sparse = i == 0 and self.maps.system.has_lidar
            error = disparity_error(self.maps[i, k], self.maps[j, k], sparse=sparse)
            pairs = ((j, k),) if sparse else ((i, k), (j, k))
            brightness = max(self.maps.brightness(pair) for pair in pairs)
            self._known[triple] = replace(error, brightness=brightness)
        return self._known[triple]

    @property
    def known(self) -> tuple[Triple, ...]:
        """Triples that somebody has asked for, in the system's order."""
        return tuple(triple for triple in self if triple in self._known)

    def __iter__(self) -> Iterator[Triple]:
        return iter(self.maps.system.triples)

    def __len__(self) -> int:
        return len(self.maps.system.triples)


@numba.njit(nogil=True, cache=True)
def _compare(first: Disparity, second: Disparity) -> NDArray[np.uint8]:
    height, width = first.shape
    result = np.empty((height, width), np.uint8)
    for v in range(height):
        for u in range(width):
            a, b = first[v, u], second[v, u]
            if np.isnan(a):
                result[v, u] = Comparison.UNKNOWN if np.isnan(b) else Comparison.SECOND_ONLY
            elif np.isnan(b):
                result[v, u] = Comparison.FIRST_ONLY
            else:
                difference = abs(a - b)
                # Not divided by the smaller one, which may be 0.
                if difference > MIN_DIFFERENCE and difference > MIN_RELATIVE_DIFFERENCE * min(a, b):
                    result[v, u] = Comparison.INCONSISTENT
                else:
                    result[v, u] = Comparison.CONSISTENT
    return result
