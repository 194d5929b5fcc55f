"""What the rays of a witness meet at each voxel that another vehicle claims, as kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.rays.claims import CLEARANCE
from avsec_gym.validation.connected.rays.range_image import (
    RangeImage,
    Singles,
    angles_between,
    cells_around,
    run_of_rays,
)
from avsec_gym.validation.connected.sweep import TIP, from_scan_time, through, when_faced

SUPPORT, THROUGH, MISSING, OCCLUDED, NEAR, OUTSIDE = range(6)
"""What a claimed voxel meets in the range image of a witness: a return in the region's box; one
well behind; no return at all though the sensor looks there; one well in front; one that decides
nothing; a direction in which the sensor does not look."""
_WIDEST = 0.1
"""Radians up to which rays aside of a voxel are looked at, however near it is."""
_LOWEST_SUPPORT = 0.7 * CLEARANCE
"""Metres above a region's bottom from which rays support a claim: things are claimed from
`CLEARANCE` on, and the ground may lie a little lower where the witness sees it."""
_ROUNDING = 0.01
"""Metres by which distances may differ that are computed in single precision."""


class WitnessView(NamedTuple):
    """A witness and C claims of V voxels, as kernels take them."""

    image: RangeImage
    pose: Floats
    """The pose from the witness' velodyne frame to the world, shape (4, 4)."""
    to_sensor: Floats
    """Its inverse."""
    motion: tuple[float, float, float]
    """The witness' speed, turn rate, and the period of its head."""
    places: Floats
    """The voxels in the world, shape (V, 3)..."""
    voxels: NDArray[np.int64]
    """... and how many belong to each claim, shape (C,)."""
    age: Floats
    """Seconds from each claim to the witness' scan, shape (C,)."""
    centre: Floats
    """Bottom centre of the box that rays must end in, in the world, shape (C, 3)."""
    ahead: Floats
    """Cosine and sine of its heading, shape (C, 2)."""
    half: Floats
    """Half of its length, width and height, shape (C, 3)."""
    around: Floats
    """How far from a voxel rays are looked at, to the sides, metres, shape (C,)."""
    reach: float
    least_around: float
    beyond: float
    below: float
    farthest: float
    resolved: float
    """The value of `WitnessMargins.resolved`."""


@kernel(nogil=True)
def fill_outcomes(look: WitnessView, velocity: Floats, result: NDArray[np.int8]) -> None:
    """Fills in what the witness' rays find at each voxel, claim by claim."""
    last = 0
    for c in range(len(look.voxels)):
        first, last = last, last + look.voxels[c]
        for v in range(first, last):
            result[v] = _outcome(look, v, c, velocity[c], False)


@kernel(nogil=True)
def fill_counts(
    look: WitnessView, velocities: Floats, needed: NDArray[np.int64], counts: NDArray[np.int64]
) -> None:
    """Fills in how many voxels of each claim rays support, pass through, and miss.

    Args:
        look: The witness and the claims.
        velocities: The velocities of what is claimed, had it moved at several, shape (S, C, 2).
        needed: Claims with fewer supported voxels are left at 0, shape (C,).
        counts: The array that takes the numbers, 0 before, shape (S, C, 3).
    """
    for s in range(len(velocities)):
        last = 0
        for c in range(len(look.voxels)):
            first, last = last, last + look.voxels[c]
            if _supports(look, first, last, c, velocities[s, c], needed[c]):
                for v in range(first, last):
                    outcome = _outcome(look, v, c, velocities[s, c], False)
                    # The first three of the outcomes are those that are counted.
                    if outcome <= MISSING:
                        counts[s, c, outcome] += 1


@kernel(nogil=True)
def _supports(
    look: WitnessView, first: int, last: int, c: int, velocity: Floats, needed: int
) -> bool:
    """Whether rays support so many voxels of claim `c`; ends where it must, or cannot any more."""
    v = first
    while 0 < needed <= last - v:
        needed -= _outcome(look, v, c, velocity, True) == SUPPORT
        v += 1
    return needed <= 0


@kernel(nogil=True)
def _outcome(look: WitnessView, v: int, c: int, velocity: Floats, only_support: bool) -> int:
    """The best outcome of the rays around voxel `v` of claim `c`.

    `SUPPORT` of one ray decides; else `OCCLUDED` by one, then `NEAR`, then `THROUGH` by all, unless
    rays a little lower end in the box: then it is `NEAR`, too.  With `only_support` nothing else is
    looked for.
    """
    image, motion, half = look.image, look.motion, look.half[c]
    # Bound outside of the loops: to take an array out of a tuple costs more than to look at a ray.
    azimuths, elevations, distances = image.azimuth, image.elevation, image.distance
    ends, pose = image.end, look.pose
    # The ray in its direction.
    x, y, z, azimuth, later, time, doubt = when_faced(
        look.to_sensor, motion, look.age[c], look.places[v], velocity
    )
    flat = np.sqrt(x * x + y * y)
    elevation = np.arctan2(z - TIP, flat)
    seen = image.lowest + look.reach < elevation < image.highest - look.reach
    if not seen or flat > look.resolved:
        return OUTSIDE
    claimed = np.sqrt(flat * flat + (z - TIP) ** 2)
    across = min(max(look.reach, look.around[c] / claimed), _WIDEST)
    rise = min(max(look.reach, look.least_around / claimed), _WIDEST)
    # The box as it stands then, and how far rays may come that end in it.  Azimuths lie up to twice
    # as far apart as directions; where the head's turn ends, neighbours are a whole turn apart.
    box = (
        later * velocity[0] + look.centre[c, 0],
        later * velocity[1] + look.centre[c, 1],
        look.centre[c, 2],
        look.ahead[c, 0],
        look.ahead[c, 1],
    )
    aside = 2.0 * across
    doubt += motion[2] * (aside / (2.0 * np.pi) if abs(azimuth) + aside < np.pi else 1.0)
    nearest, deepest = _distances_of_box(look.to_sensor, motion, time, doubt, box, half)
    # The rays around it: one that ends in the box supports it, and one that ends before it
    # leaves the decision to the others.
    # Invariant: of the rays looked at so far none supports it, and `found` is the last of their
    # outcomes in the order MISSING, THROUGH, NEAR, OCCLUDED.
    found = MISSING
    from_row, to_row, from_column, to_column = cells_around(azimuth, elevation, across, rise)
    for row in range(from_row, to_row):
        for run in range(2):
            begin, end = run_of_rays(image, row, from_column, to_column, run)
            for i in range(begin, end):
                distance = distances[i]
                in_box = nearest < distance < deepest
                if only_support and not in_box:
                    continue
                left, above = angles_between((azimuths[i], elevations[i]), azimuth, elevation)
                if (left / across) ** 2 + (above / rise) ** 2 > 1.0:
                    continue
                if in_box and _ends_in_box(ends[i], pose, box, half):
                    return SUPPORT
                if distance < claimed - look.beyond:
                    found = OCCLUDED
                elif found in (MISSING, THROUGH):
                    found = THROUGH if distance > claimed + look.beyond else NEAR
    if found == MISSING and claimed > look.farthest:
        return OUTSIDE
    if only_support or found != THROUGH or look.below <= 0.0:
        return found
    # Rays over the top of a thing that the witness sees, too, pass through nothing.
    # Invariant: none of the lower rays looked at so far ends in the box.
    lower = 0.5 * min(look.below / claimed, 0.5)
    middle = elevation - lower
    from_row, to_row, from_column, to_column = cells_around(azimuth, middle, across, lower)
    for row in range(from_row, to_row):
        for run in range(2):
            begin, end = run_of_rays(image, row, from_column, to_column, run)
            for i in range(begin, end):
                if not nearest < distances[i] < deepest:
                    continue
                left, above = angles_between((azimuths[i], elevations[i]), azimuth, middle)
                if abs(left) > across or abs(above) > lower:
                    continue
                if _ends_in_box(ends[i], pose, box, half):
                    return NEAR
    return THROUGH


@kernel(nogil=True)
def _distances_of_box(
    to_sensor: Floats,
    motion: tuple[float, float, float],
    time: float,
    doubt: float,
    box: tuple[float, float, float, float, float],
    half: Floats,
) -> tuple[float, float]:
    """Between which distances from where rays leave they can end in a box: a sphere around it.

    Args:
        to_sensor: The transform from the world to the witness' velodyne frame, shape (4, 4).
        motion: The witness' speed, turn rate, and the period of its head.
        time: When the head faces the box, seconds after the scan's time.
        doubt: The seconds by which the times of the rays may differ from it.
        box: The place of the box, as of `_ends_in_box`.
        half: Half of the box's length, width, height, shape (3,).
    """
    speed, turn_rate, _ = motion
    x, y, z = through(to_sensor, box[0], box[1], box[2] + half[2])
    x, y = from_scan_time(x, y, time, speed, turn_rate)
    away = np.sqrt(x * x + y * y + (z - TIP) ** 2)
    radius = np.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    radius += doubt * (abs(speed) + abs(turn_rate) * (away + radius)) + _ROUNDING
    return away - radius, away + radius


@kernel(nogil=True)
def _ends_in_box(
    end: Singles,
    pose: Floats,
    box: tuple[float, float, float, float, float],
    half: Floats,
) -> bool:
    """Whether a ray ends in an upright box, above what may be the ground.

    Args:
        end: Where the ray ends in the witness' velodyne frame, shape (3,).
        pose: The transform from the witness' velodyne frame to the world, shape (4, 4).
        box: The world's x, y and z of the bottom's middle when the ray was sent, cosine and sine of
            the heading.
        half: Half of the box's length, width, height, shape (3,).
    """
    east, north, up, cos, sin = box
    x, y, z = through(pose, end[0], end[1], end[2])
    x, y, z = x - east, y - north, z - up
    along, across = abs(cos * x + sin * y), abs(cos * y - sin * x)
    return along < half[0] and across < half[1] and _LOWEST_SUPPORT < z < 2.0 * half[2]
