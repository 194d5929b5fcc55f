"""Claims: where a vehicle's rays ended in each region, as small cells of the region's box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.rays.range_image import RangeImage, cells_between
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import TIP, to_scan_time

VOXEL = 0.2
"""Edge of the voxels, metres."""
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
        """In how many layers of voxels, one above the other, each claim has some, shape (C,)."""
        claim = self.of_voxels()
        height = grid_shapes(regions.grown(MARGIN, MARGIN).size)[self.region, 2][claim]
        some = np.unique(np.stack([claim, self.voxel % height]), axis=1)
        return np.bincount(some[0], minlength=len(self))

    def places(self, regions: Regions) -> Floats:
        """Centres of the voxels in the world, shape (V, 3)."""
        grown = regions.grown(MARGIN, MARGIN)[self.region][self.of_voxels()]
        shape = grid_shapes(grown.size)
        index = np.stack(
            [
                self.voxel // (shape[:, 1] * shape[:, 2]),
                self.voxel // shape[:, 2] % shape[:, 1],
                self.voxel % shape[:, 2],
            ],
            axis=1,
        )
        local = VOXEL * (index + 0.5) - grown.size / 2
        local[:, 2] += grown.size[:, 2] / 2
        cos, sin = np.cos(grown.heading), np.sin(grown.heading)
        x, y, z = local.T
        return grown.centre + np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=1)


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


def claim(observer: Observer, regions: Regions, velocity: Floats | None = None) -> Claims:
    """What a vehicle states about each region in which its rays ended.

    Of an object with more voxels than fit into a message, every second, third, ... is claimed.

    Args:
        observer: The vehicle.
        regions: The regions that all vehicles share.
        velocity: How fast what is in each region moves along the world's x and y, m/s, shape
            (N, 2); it stands if None.
    """
    grown = regions.grown(MARGIN, MARGIN)
    shapes = grid_shapes(grown.size)
    to_sensor = np.linalg.inv(observer.pose)
    velocity = np.zeros((len(regions), 2)) if velocity is None else velocity
    found: list[tuple[int, NDArray[np.int64], float]] = []
    for index in range(len(regions)):
        # The wedge of directions that the region's box can fill, with the sweep's motion.
        middle = to_sensor[:3, :3] @ grown.centre[index] + to_sensor[:3, 3]
        away = float(np.hypot(middle[0], middle[1]))
        lasts = observer.sweep.period / 2
        moved = abs(observer.sweep.speed) * lasts
        moved += float(np.hypot(*velocity[index])) * (abs(observer.scan.time) + lasts)
        radius = float(np.hypot(*grown.size[index, :2])) / 2 + moved
        # Seen from a sensor that leans, the top stands beside the bottom.
        radius += grown.size[index, 2] * float(np.hypot(*to_sensor[:2, 2]))
        if away - radius > _FARTHEST:
            continue
        half = np.pi if away <= radius + 0.5 else float(np.arcsin(radius / away))
        azimuth = float(np.arctan2(middle[1], middle[0]))
        # And how far rays come that end in it.
        height = grown.size[index, 2] / 2
        centre = middle + height * to_sensor[:3, 2] - [0.0, 0.0, TIP]
        deep = float(np.hypot(radius, height)) + _ROUNDING
        distance = float(np.linalg.norm(centre))
        voxel = _returns_in_box(
            observer.image,
            cells_between(observer.image, azimuth - half, azimuth + half),
            (distance - deep, distance + deep),
            observer.pose,
            observer.motion,
            observer.scan.time,
            velocity[index],
            grown.centre[index],
            grown.heading[index],
            grown.size[index],
            shapes[index],
        )
        if len(voxel):
            looked = observer.scan.time + azimuth * observer.sweep.period / (2 * np.pi)
            found.append((index, np.unique(voxel), looked))
    # Those with most voxels, if there are too many.
    found = sorted(found, key=lambda each: -len(each[1]))[:MOST_CLAIMS]
    found.sort(key=lambda each: each[0])
    most = min(MOST_VOXELS_OF_ONE, MOST_VOXELS // max(len(found), 1))
    voxels = [each[1][:: -(-len(each[1]) // most)] for each in found]
    region = np.array([each[0] for each in found], np.int64)
    return Claims(
        region,
        velocity[region].astype(np.float64),
        np.array([len(each) for each in voxels], np.int64),
        np.concatenate([np.zeros(0, np.int64), *voxels]),
        np.array([each[2] for each in found]),
    )


_FARTHEST = 80.0
"""Metres beyond which a vehicle claims nothing."""
_ROUNDING = 0.01
"""Metres by which distances may differ that are computed in single precision."""


@kernel(nogil=True)
def _returns_in_box(
    image: RangeImage,
    cells: NDArray[np.int64],
    distances: tuple[float, float],
    pose: Floats,
    motion: tuple[float, float, float],
    scan_time: float,
    velocity: Floats,
    centre: Floats,
    heading: float,
    size: Floats,
    shape: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Flat voxels of a box in which the rays of some cells end.

    Args:
        image: The vehicle's rays.
        cells: First and last cell of runs of cells, shape (R, 2).
        distances: Rays that come less far, or farther, do not end in the box, metres.
        pose: The transform from the velodyne frame to the world, shape (4, 4).
        motion: Speed, turn rate, period.
        scan_time: Time of the scan after the instant.
        velocity: The velocity of what is in the box, along the world's x and y.
        centre: Bottom centre of the box in the world.
        heading: Heading of the box.
        size: Size of the box.
        shape: Number of voxels along each side.
    """
    speed, turn_rate, period = motion
    cos, sin = np.cos(heading), np.sin(heading)
    nearest, farthest = distances
    most = 0
    for run in range(len(cells)):
        most += image.start[cells[run, 1]] - image.start[cells[run, 0]]
    voxel = np.empty(most, np.int64)
    count = 0
    for run in range(len(cells)):
        for i in range(image.start[cells[run, 0]], image.start[cells[run, 1]]):
            if not nearest < image.distance[i] < farthest:
                continue
            # The end of the ray, when it was sent; at the scan's time; in the
            # world at the instant; in the box.
            time = image.azimuth[i] * period / (2.0 * np.pi)
            z = image.end[i, 2]
            x, y = to_scan_time(image.end[i, 0], image.end[i, 1], time, speed, turn_rate)
            east = pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3] - centre[0]
            north = pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3] - centre[1]
            east -= (scan_time + time) * velocity[0]
            north -= (scan_time + time) * velocity[1]
            up = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3] - centre[2]
            along, across = cos * east + sin * north, cos * north - sin * east
            if (
                abs(along) < 0.5 * size[0]
                and abs(across) < 0.5 * size[1]
                and CLEARANCE < up < size[2]
            ):
                a = min(int((along + 0.5 * size[0]) / VOXEL), shape[0] - 1)
                b = min(int((across + 0.5 * size[1]) / VOXEL), shape[1] - 1)
                c = min(int(up / VOXEL), shape[2] - 1)
                voxel[count] = (a * shape[1] + b) * shape[2] + c
                count += 1
    return voxel[:count]
