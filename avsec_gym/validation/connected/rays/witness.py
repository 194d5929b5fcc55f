"""Witnesses: the rays of one vehicle, held against what another vehicle claims."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.rays.claims import CLEARANCE, Claims
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.rays.range_image import (
    RangeImage,
    angles_between,
    cells_around,
    first_and_last,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import (
    TIP,
    from_scan_time,
    ray_time,
    to_scan_time,
)

SUPPORT, THROUGH, MISSING, OCCLUDED, NEAR, OUTSIDE = range(6)
"""What a claimed voxel meets in the range image of a witness: a return in the region's box; one
well behind; no return at all though the sensor looks there; one well in front; one that decides
nothing; a direction in which the sensor does not look."""

_MOST = {
    "reach": 0.1,
    "around": 10.0,
    "around_sigmas": 10.0,
    "side": 10.0,
    "beyond": 10.0,
    "below": 10.0,
    "resolved": 1000.0,
    "fastest": 100.0,
    "farthest": 1000.0,
    "position_noise": 10.0,
    "heading_noise": 1.0,
}
"""The largest number of each margin, in its unit."""


@dataclass(frozen=True)
class WitnessMargins:
    """How far things may lie apart and still be the same.

    Args:
        reach: Smallest angle up to which rays around a voxel are looked at, radians; at least two
            rays of the sensor must lie within.
        around: How far from a voxel rays are looked at, metres...
        around_sigmas: ... and by so many standard deviations of the poses, to the sides.
        side: What a region's box is grown by at its sides, metres.  Little: with errors of poses,
            rays around a voxel are looked at, and what ends beside a box but near the voxel
            decides nothing; a wider box would let a ghost's neighbours speak for it.
        beyond: How far behind a voxel a ray must end to have passed through it, metres.
        below: How far below a voxel rays that end in the region's box show that something stands
            there, only lower: what rays pass over its top then decides nothing, metres.
        resolved: Farthest distance at which a witness' rays count, metres: beyond, low or narrow
            things fit between them.
        fastest: Greatest speed of things that no vehicle tracks, m/s; see `count_rays`.
        farthest: Distance up to which a ray that returns nothing is one that met nothing, metres;
            dark things far away send nothing back.
        position_noise: Standard deviation of measured positions along x and along y, metres.
        heading_noise: Standard deviation of measured headings, radians.

    Raises:
        ConfigurationError: A number that is below 0, or above what any sensor or road has.
    """

    reach: float = float(np.radians(0.4))
    around: float = 0.15
    around_sigmas: float = 1.5
    side: float = 0.1
    beyond: float = 0.5
    below: float = 0.5
    resolved: float = 50.0
    fastest: float = 35.0
    farthest: float = 40.0
    position_noise: float = 0.2
    heading_noise: float = float(np.radians(0.2))

    def __post_init__(self) -> None:
        for name, most in _MOST.items():
            number(name, getattr(self, name), 0.0, most)

    def apart(self, distance: Floats) -> Floats:
        """Standard deviation of a place that a vehicle sees so far away, metres."""
        return np.asarray(np.hypot(self.position_noise, self.heading_noise * distance))


def outcomes(
    witness: Observer,
    claims: Claims,
    regions: Regions,
    margins: WitnessMargins,
    velocity: Floats | None = None,
) -> NDArray[np.int8]:
    """What each claimed voxel meets in a witness' range image.

    Args:
        witness: The vehicle that looks.
        claims: What another vehicle claims.
        regions: The regions that all vehicles share.
        margins: What may lie apart.
        velocity: How fast what is claimed moves along the world's x and y, since the time of the
            claim, m/s, shape (C, 2); None: as the claims have it, since the instant.

    Returns:
        `SUPPORT`, `THROUGH`, ... for each voxel, shape (V,).
    """
    result = np.empty(len(claims.voxel), np.int8)
    chosen = regions[claims.region]
    away = np.hypot(*(chosen.centre[:, :2] - witness.pose[:2, 3]).T)
    apart = np.sqrt(2.0) * margins.apart(away)
    around = margins.around + margins.around_sigmas * apart
    since = claims.time
    if velocity is None:
        velocity, since = claims.velocity, np.zeros(len(claims))
    _outcomes(
        witness.image,
        witness.pose,
        np.linalg.inv(witness.pose),
        witness.motion,
        witness.scan.time,
        claims.places(regions),
        claims.of_voxels(),
        velocity,
        since,
        (chosen.centre, chosen.heading, chosen.size / 2 + margins.side),
        around,
        (
            margins.reach,
            margins.around,
            margins.beyond,
            margins.below,
            margins.farthest,
            margins.resolved,
        ),
        result,
    )
    return result


def count_outcomes(claims: Claims, outcome: NDArray[np.int8]) -> NDArray[np.int64]:
    """How many voxels of each claim have each outcome, shape (C, 6)."""
    counts = np.zeros((len(claims), 6), np.int64)
    np.add.at(counts, (claims.of_voxels(), outcome), 1)
    return counts


@kernel(nogil=True)
def _outcomes(
    image: RangeImage,
    pose: Floats,
    to_sensor: Floats,
    motion: tuple[float, float, float],
    scan_time: float,
    places: Floats,
    of_voxel: NDArray[np.int64],
    velocity: Floats,
    since: Floats,
    boxes: tuple[Floats, Floats, Floats],
    around: Floats,
    margins: tuple[float, float, float, float, float, float],
    result: NDArray[np.int8],
) -> None:
    """Fills in what the witness' rays find at each voxel: the best outcome of the rays around it.

    `SUPPORT` of one ray decides; else `OCCLUDED` by one, then `NEAR`, then `THROUGH` by all, unless
    rays a little lower end in the box: then it is `NEAR`, too.
    """
    centre, heading, half = boxes
    reach, least_around, beyond, below, farthest, resolved = margins
    for v in range(len(places)):
        c = of_voxel[v]
        x, y, z, drift_x, drift_y = _when_faced(
            to_sensor, motion, scan_time - since[c], places[v], velocity[c]
        )
        # The ray in its direction.
        flat = np.sqrt(x * x + y * y)
        azimuth, elevation = np.arctan2(y, x), np.arctan2(z - TIP, flat)
        seen = image.lowest + reach < elevation < image.highest - reach
        if not seen or flat > resolved:
            result[v] = OUTSIDE
            continue
        claimed = np.sqrt(flat * flat + (z - TIP) ** 2)
        across = min(max(reach, around[c] / claimed), 0.1)
        rise = min(max(reach, least_around / claimed), 0.1)
        rows_from, rows_to, from_column, to_column = cells_around(azimuth, elevation, across, rise)
        # The rays around it: one that ends in the box supports it, and one that ends before it
        # leaves the decision to the others.
        found = MISSING
        cos, sin = np.cos(heading[c]), np.sin(heading[c])
        east, north, up = drift_x + centre[c, 0], drift_y + centre[c, 1], centre[c, 2]
        for row in range(rows_from, rows_to):
            for column in range(from_column, to_column):
                first, last = first_and_last(image, row, column)
                for i in range(first, last):
                    left, above = angles_between(image, i, azimuth, elevation)
                    if (left / across) ** 2 + (above / rise) ** 2 > 1.0:
                        continue
                    if _ends_in_box(image, i, pose, motion, east, north, up, cos, sin, half[c]):
                        found = SUPPORT
                        break
                    if image.distance[i] < claimed - beyond:
                        found = OCCLUDED
                    elif found in (MISSING, THROUGH):
                        found = THROUGH if image.distance[i] > claimed + beyond else NEAR
                if found == SUPPORT:
                    break
            if found == SUPPORT:
                break
        # Rays over the top of a thing that the witness sees, too, pass through nothing.
        lower = min(below / claimed, 0.5) if found == THROUGH else 0.0
        middle = elevation - 0.5 * lower
        rows_from, rows_to, from_column, to_column = cells_around(
            azimuth, middle, across, 0.5 * lower
        )
        for row in range(rows_from, rows_to if lower > 0.0 else rows_from):
            for column in range(from_column, to_column):
                first, last = first_and_last(image, row, column)
                for i in range(first, last):
                    left, above = angles_between(image, i, azimuth, middle)
                    if (
                        abs(left) <= across
                        and abs(above) <= 0.5 * lower
                        and _ends_in_box(image, i, pose, motion, east, north, up, cos, sin, half[c])
                    ):
                        found = NEAR
                        break
                if found == NEAR:
                    break
            if found == NEAR:
                break
        result[v] = OUTSIDE if found == MISSING and claimed > farthest else found


@kernel(nogil=True)
def _ends_in_box(
    image: RangeImage,
    ray: int,
    pose: Floats,
    motion: tuple[float, float, float],
    east: float,
    north: float,
    up: float,
    cos: float,
    sin: float,
    half: Floats,
) -> bool:
    """Whether a ray ends in an upright box, above what may be the ground.

    Args:
        image: The witness' rays.
        ray: Index of the ray.
        pose: The transform from the witness' velodyne frame to the world, shape (4, 4).
        motion: The witness' speed, turn rate, and the period of its head.
        east: The world's x of the bottom's middle when the ray was sent.
        north: Likewise y.
        up: Likewise z.
        cos: Cosine of the box's heading.
        sin: Sine of the box's heading.
        half: Half of the box's length, width, height, shape (3,).
    """
    speed, turn_rate, period = motion
    when = image.azimuth[ray] * period / (2.0 * np.pi)
    a, b = to_scan_time(image.end[ray, 0], image.end[ray, 1], when, speed, turn_rate)
    x, y, z = to_world(pose, a, b, image.end[ray, 2])
    x, y, z = x - east, y - north, z - up
    along, across = abs(cos * x + sin * y), abs(cos * y - sin * x)
    return along < half[0] and across < half[1] and 0.7 * CLEARANCE < z < 2.0 * half[2]


@kernel(nogil=True)
def _when_faced(
    to_sensor: Floats,
    motion: tuple[float, float, float],
    age: float,
    place: Floats,
    velocity: Floats,
) -> tuple[float, float, float, float, float]:
    """Where a moving voxel is when the witness' head faces it, and how far it has moved until then.

    Args:
        to_sensor: The transform from the world to the witness' velodyne frame, shape (4, 4).
        motion: The witness' speed, turn rate, and the period of its head.
        age: Time from the claim to the witness' scan, seconds.
        place: The voxel in the world at the time of the claim, shape (3,).
        velocity: The velocity of what is claimed along the world's x and y, shape (2,).

    Returns:
        x, y and z in the sensor's frame of the time when the head faces it; the drift along the
        world's x and y since the claim.
    """
    speed, turn_rate, period = motion
    time, drift_x, drift_y = 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    # When it is faced depends on where it is then: once by its place at the scan's time, once
    # more by what follows.
    for _ in range(2):
        later = age + time
        drift_x, drift_y = later * velocity[0], later * velocity[1]
        x, y, z = to_world(to_sensor, place[0] + drift_x, place[1] + drift_y, place[2])
        time = ray_time(x, y, period)
        x, y = from_scan_time(x, y, time, speed, turn_rate)
        time = ray_time(x, y, period)
    return x, y, z, drift_x, drift_y


@kernel(nogil=True)
def to_world(pose: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A place through a rigid transform of shape (4, 4)."""
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3],
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3],
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3],
    )
