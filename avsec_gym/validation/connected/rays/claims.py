"""Claims: where a vehicle's rays ended in each region, as small cells of the region's box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.box_voxels import VOXEL, fill_places, voxels_in_boxes
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.regions import Regions

CLEARANCE = 0.35
"""Height above a region's bottom up to which returns may be the ground's, metres."""
MARGIN = 0.2
"""What a region is grown by at its sides and top before points are looked for, metres."""
MOST_CLAIMS = 100
"""Claims of a vehicle at an instant."""
MOST_VOXELS = 2000
"""Voxels of all claims of a vehicle at an instant."""
MOST_VOXELS_OF_ONE = 120
"""Voxels of one claim; rays beyond add little."""
SEARCHED = 0.25
"""Seconds between two looks at one instant, at most, over which a thing that may have moved is
looked for: clocks and sweeps are at most 0.1 s apart each."""


@dataclass(frozen=True, eq=False)
class Claims:
    """What a vehicle states to be there at an instant.

    Args:
        region: Index of the region of each claim, rising, shape (C,).
        velocity: How fast it moves along the world's x and y by the vehicle's own tracking, 0
            where it has none, m/s, shape (C, 2).  By it, the vehicle carried what it claims from
            the time of its rays to the instant.
        count: Number of voxels of each claim, 1 or more, shape (C,).
        voxel: Voxels of the first claim, of the second, and so on: flat indices in the region's
            `grid_shape`, rising within a claim, shape (sum of count,).
        time: When its rays ended there, after the instant, seconds, shape (C,): what moves unknown
            to the vehicle was there then.  0 where none is given.

    Raises:
        DataError: Shapes that do not belong together.
    """

    region: NDArray[np.int64]
    velocity: Floats
    count: NDArray[np.int64]
    voxel: NDArray[np.int64]
    time: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        number = len(self.region)
        if not len(self.time):
            object.__setattr__(self, "time", np.zeros(number))
        if not (
            self.time.shape == (number,)
            and self.count.shape == (number,)
            and self.velocity.shape == (number, 2)
            and self.voxel.shape == (int(self.count.sum()),)
        ):
            raise DataError("claims have a region, a velocity and a count each, and so many voxels")

    def __len__(self) -> int:
        return len(self.region)

    def __getitem__(self, chosen: NDArray[Any]) -> Claims:
        """Some of them, by a mask or an array of rising indices."""
        rows = np.arange(len(self))[chosen]
        kept = np.isin(self.of_voxels(), rows)
        return Claims(
            self.region[rows],
            self.velocity[rows],
            self.count[rows],
            self.voxel[kept],
            self.time[rows],
        )

    def of_voxels(self) -> NDArray[np.int64]:
        """Which claim each voxel belongs to, shape (V,)."""
        return np.repeat(np.arange(len(self)), self.count)

    def layers(self, regions: Regions) -> NDArray[np.int64]:
        """The number of layers, one above the other, in which each claim has voxels, shape (C,)."""
        claim = self.of_voxels()
        height = grid_shapes(regions.grown(MARGIN, MARGIN).size)[self.region, 2][claim]
        most = height.max(initial=1)
        some = np.unique(claim * most + self.voxel % height)
        return np.bincount(some // most, minlength=len(self))

    def places(self, regions: Regions) -> Floats:
        """Centres of the voxels in the world, shape (V, 3)."""
        grown = regions.grown(MARGIN, MARGIN)[self.region]
        shapes, places = grid_shapes(grown.size), np.empty((len(self.voxel), 3))
        fill_places(
            self.count,
            self.voxel,
            grown.centre,
            heading_vectors(grown),
            grown.size / 2,
            shapes,
            places,
        )
        return places


def claimed_layers(
    claimed: Mapping[int, Claims], regions: Regions, vehicles: int
) -> NDArray[np.int64]:
    """In how many layers of voxels each vehicle's claim lies, 0 without one, shape (R, V).

    Args:
        claimed: Claims by the numbers of vehicles.
        regions: R regions that are claimed.
        vehicles: V, the number of vehicles.
    """
    layers = np.zeros((len(regions), vehicles), np.int64)
    for number, claims in claimed.items():
        layers[claims.region, number] = claims.layers(regions)
    return layers


def grid_shapes(size: Floats) -> NDArray[np.int64]:
    """Number of voxels along, across and up each box of these sizes, shape (N, 3)."""
    return np.ceil(size / VOXEL - 1e-9).astype(np.int64)


def heading_vectors(regions: Regions) -> Floats:
    """Cosine and sine of each region's heading, shape (N, 2)."""
    return np.stack([np.cos(regions.heading), np.sin(regions.heading)], axis=1)


def claim(observer: Observer, regions: Regions, velocity: Floats | None = None) -> Claims:
    """What a vehicle states about each region in which its rays ended.

    Of an object with more voxels than fit into a message, every second, third, ... is claimed.

    Args:
        observer: The vehicle.
        regions: The regions that all vehicles share.
        velocity: How fast what is in each region moves along the world's x and y, m/s, shape
            (N, 2); it stands if None.
    """
    grown, to_sensor = regions.grown(MARGIN, MARGIN), np.linalg.inv(observer.pose)
    velocity = np.zeros((len(regions), 2)) if velocity is None else velocity.astype(np.float64)
    middle = grown.centre @ to_sensor[:2, :3].T + to_sensor[:2, 3]
    seen = np.flatnonzero(np.hypot(*middle.T) - np.hypot(*grown.size[:, :2].T) / 2 < _FARTHEST)
    ends = voxels_in_boxes(
        observer.image,
        observer.pose,
        to_sensor,
        observer.motion,
        observer.scan.time,
        velocity[seen],
        grown.centre[seen],
        heading_vectors(grown)[seen],
        grown.size[seen] / 2,
        grid_shapes(grown.size[seen]),
        CLEARANCE,
    )
    # Each voxel once, rising within its region.
    ends = np.sort(seen[ends[0]] << _VOXEL_BITS | ends[1])
    ends = ends[np.diff(ends, prepend=-1) > 0]
    of_region, voxel = ends >> _VOXEL_BITS, ends & (1 << _VOXEL_BITS) - 1
    first = np.flatnonzero(np.diff(of_region, prepend=-1))
    region, count = of_region[first], np.diff(first, append=len(ends))
    # Those with most voxels, if there are too many.
    chosen = np.sort(np.argsort(-count, kind="stable")[:MOST_CLAIMS])
    region, first, count = region[chosen], first[chosen], count[chosen]
    most = min(MOST_VOXELS_OF_ONE, MOST_VOXELS // max(len(region), 1))
    step = -(-count // most)
    kept = -(-count // step)
    number = np.arange(kept.sum()) - np.repeat(np.cumsum(kept) - kept, kept)
    return Claims(
        region,
        velocity[region],
        kept,
        voxel[np.repeat(first, kept) + np.repeat(step, kept) * number],
        observer.scan.time + observer.scan.sweep.facing_time(*middle[region, :2].T),
    )


_FARTHEST = 80.0
"""Metres beyond which a vehicle claims nothing."""
_VOXEL_BITS = 40
"""Bits of the number of a voxel in its region, where both are one number."""
