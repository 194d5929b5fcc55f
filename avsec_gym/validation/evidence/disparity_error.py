"""Disparity error E_{i,j,k} between two disparity maps of one view (thesis, section 3.3.2).

E counts contradictions of disparity in the whole view.  Three more shares count what it overlooks:
light that leaves a matcher nothing to match, light that it copes with, and points of a scan that
are few, but all in one place, and disproved by the images.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.evidence.behind_surfaces import lidar_eye
from avsec_gym.validation.evidence.brightness import FEWEST
from avsec_gym.validation.evidence.comparison import Comparison, comparison_map
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.disproved import disproved_points
from avsec_gym.validation.evidence.reprojection import Mask

WINDOW = 96
"""Pixels to a side of where disproved points are counted together; a car's rear 12 m ahead."""
MEASURES = ("error", "hole_share", "densest", "brightness")
"""Shares of a `DisparityError`: E of the thesis, and what goes beyond it."""


@dataclass(frozen=True)
class DisparityError:
    """How far two maps of one view contradict each other, and how much of it they know.

    Args:
        inconsistent: Pixels whose disparities differ (equation 3.2).
        valid: Pixels known in both maps.
        pixels: The number of pixels that could be known in both: those of the scan, of two dense
            maps all.
        densest: The share of a scan, that of `disproved_points` in that window of `WINDOW` which
            has most; 0 of two dense maps, whose contradictions nothing decides.
        brightness: `Brightness.patches` of that pair of the triple's cameras which has most: the
            reference does not see all that two others do.
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
    """Compare two maps in the scale of the second (equation 3.2), without their images.

    Args:
        first: DM_{i,k}, in any scale.
        second: The second map, DM_{j,k}.
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
    return DisparityError(inconsistent, valid, pixels)


def densest_share(pixels: Mask) -> float:
    """The share of some pixels in that window of `WINDOW` which has most of them.

    Args:
        pixels: The pixels, shape (H, W).
    """
    window = cv2.blur(
        np.asarray(pixels, np.float32), (WINDOW, WINDOW), borderType=cv2.BORDER_CONSTANT
    )
    return float(np.clip(window.max(), 0, 1))


class DisparityErrors(Mapping[Triple, DisparityError]):
    """E_{i,j,k} of all triples of a frame; each is worked out when first asked for, and kept.

    Args:
        maps: The maps of the frame.
        known: The errors that are known already.
    """

    def __init__(
        self, maps: DisparityMaps, known: Mapping[Triple, DisparityError] | None = None
    ) -> None:
        self.maps = maps
        self._known = dict(known or {})

    def __getitem__(self, triple: Triple) -> DisparityError:
        """E_{i,j,k}; see `DisparityMaps` for what can go wrong."""
        if triple not in self._known:
            self._known[triple] = self._of(triple)
        return self._known[triple]

    @property
    def known(self) -> tuple[Triple, ...]:
        """Triples that were asked for, in the system's order."""
        return tuple(triple for triple in self if triple in self._known)

    def __iter__(self) -> Iterator[Triple]:
        return iter(self.maps.system.triples)

    def __len__(self) -> int:
        return len(self.maps.system.triples)

    def _of(self, triple: Triple) -> DisparityError:
        i, j, k = triple
        maps, sensors = self.maps, self.maps.system.sensors
        sparse = maps.system.has_scan(triple)
        error = disparity_error(maps[i, k], maps[j, k], sparse=sparse)
        seen = [pair for pair in maps.system.pairs_of(triple) if not maps.system.has_scan(pair)]
        error = replace(error, brightness=max(maps.brightness(pair).patches for pair in seen))
        if not sparse:
            return error
        reference, other = (maps.frame.image(int(sensors[position])) for position in (k, j))
        eye = lidar_eye(maps.frame.calibration, int(sensors[k]), maps[j, k].focal_times_baseline)
        disproved = disproved_points(maps[i, k], maps[j, k], reference, other, eye)
        return replace(error, densest=densest_share(disproved))
