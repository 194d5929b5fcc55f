"""How one witness' rays support another vehicle's claims, as counts and as a message."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_overlap
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.rays.claims import MOST_CLAIMS, MOST_VOXELS_OF_ONE, Claims
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.rays.witness import (
    MISSING,
    SUPPORT,
    THROUGH,
    WitnessMargins,
    outcomes,
)
from avsec_gym.validation.connected.regions import Regions

_FORMAT = 1
_HEADER, _ROW = struct.Struct("<BH"), struct.Struct("<HBBB")


@dataclass(frozen=True, eq=False)
class WitnessCounts:
    """How many voxels of each claim a witness' rays support, pass through, or miss.

    Args:
        region: Index of the region of each claim, rising, shape (C,).
        counts: Numbers of voxels, shape (C, 3): those in whose direction a ray ended in the
            region's box; those that all rays near them passed through; those without a return.

    Raises:
        DataError: Shapes that do not belong together, or counts that no claim can have.
    """

    region: NDArray[np.int64]
    counts: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.counts.shape != (len(self.region), 3):
            raise DataError(f"a witness has three counts of each claim, not {self.counts.shape}")
        if (self.counts < 0).any() or (self.counts.sum(axis=1) > MOST_VOXELS_OF_ONE).any():
            raise DataError(f"a witness counts 0 to {MOST_VOXELS_OF_ONE} voxels of a claim")


def count_rays(
    witness: Observer, claims: Claims, regions: Regions, margins: WitnessMargins
) -> WitnessCounts:
    """How many of a witness' rays support and contradict another vehicle's claims.

    Vehicles look at different times, and what neither tracks may have moved meanwhile.  Where a
    witness' rays contradict a claim without a velocity, it asks whether they would support it, had
    the thing moved along one of the two axes of its region at some speed up to
    `WitnessMargins.fastest`, and reports the counts that support it most.  Along both, since of a
    vehicle of which one face was seen nothing shows which of its sides is the longer one.  What the
    other vehicle claims at the new place as something else is no support.

    Args:
        witness: The vehicle that looks.
        claims: What another vehicle claims.
        regions: The regions that all vehicles share.
        margins: What may lie apart.
    """
    counts = _three_counts(claims, outcomes(witness, claims, regions, margins))
    stands = ~claims.velocity.any(axis=1)
    doubted = np.flatnonzero(stands & (counts[:, 1] > counts[:, 0]))
    if margins.fastest > 0 and len(doubted):
        some = claims[doubted]
        between = _time_between(witness, some, regions)
        steps = int(np.ceil(margins.fastest * np.abs(between).max() / _SHIFT))
        speeds = margins.fastest * np.delete(np.linspace(-1.0, 1.0, 2 * steps + 1), steps)
        axes = regions.heading[some.region] + np.array([[0.0], [np.pi / 2]])
        decisive = counts[doubted, :2].sum(axis=1)
        for speed, axis in product(speeds, axes):
            velocity = speed * np.stack([np.cos(axis), np.sin(axis)], axis=1)
            moved = _three_counts(some, outcomes(witness, some, regions, margins, velocity))
            better = moved[:, 0] - moved[:, 1] > counts[doubted, 0] - counts[doubted, 1]
            # Fewer rays are no excuse: the claim must be supported, and by half as many.
            better &= (moved[:, 0] > moved[:, 1]) & (2 * moved[:, 0] >= decisive)
            rows = np.flatnonzero(better)
            place = _moved(regions[some.region[rows]], velocity[rows] * between[rows, None])
            rows = rows[~_is_claimed(place, some.region[rows], claims, regions)]
            counts[doubted[rows]] = moved[rows]
    return WitnessCounts(claims.region, counts)


def _moved(regions: Regions, by: Floats) -> Regions:
    """Regions so far along the world's x and y, metres, shape (R, 2)."""
    centre = regions.centre + np.c_[by, np.zeros(len(by))]
    return Regions(centre, regions.size, regions.heading)


def _is_claimed(
    places: Regions, own: NDArray[np.int64], claims: Claims, regions: Regions
) -> NDArray[np.bool_]:
    """Whether some other claim lies where a claimed thing would have moved to, shape (R,).

    Args:
        places: R places.
        own: Which region each of the things was claimed in, shape (R,).
        claims: All that the vehicle claims.
        regions: The regions that all vehicles share.
    """
    others = seen_from_above(regions[claims.region])
    common = rectangle_overlap(seen_from_above(places), others)
    common[own[:, None] == claims.region] = 0.0
    area = places.size[:, 0] * places.size[:, 1]
    return np.asarray((common > _ANOTHER * area[:, None]).any(axis=1))


_ANOTHER = 0.1
"""Share of a moved region's area from which what is claimed there is another thing."""
_SHIFT = 0.4
"""Metres between the places at which a thing that may have moved is looked for."""


def _three_counts(claims: Claims, outcome: NDArray[np.int8]) -> NDArray[np.int64]:
    """Supporting, passing and missing rays of each claim, shape (C, 3)."""
    of_voxel = claims.of_voxels()
    counts = [
        np.bincount(of_voxel[outcome == each], minlength=len(claims))
        for each in (SUPPORT, THROUGH, MISSING)
    ]
    return np.stack(counts, axis=1)


def _time_between(witness: Observer, claims: Claims, regions: Regions) -> Floats:
    """How long after each claim the witness' head faces its region, seconds, shape (C,)."""
    centre = regions.centre[claims.region]
    to_sensor = np.linalg.inv(witness.pose)
    x, y = (centre @ to_sensor[:2, :3].T + to_sensor[:2, 3]).T
    turned = np.arctan2(y, x) / (2 * np.pi)
    return np.asarray(witness.scan.time + turned * witness.sweep.period - claims.time)


def encode_counts(counts: WitnessCounts) -> bytes:
    """Counts as a message; claims that no ray met are left out."""
    with_rays = counts.counts.any(axis=1)
    region, of_rays = counts.region[with_rays], counts.counts[with_rays]
    rows = np.column_stack([region, of_rays]).tolist()
    return _HEADER.pack(_FORMAT, len(rows)) + b"".join(_ROW.pack(*row) for row in rows)


def most_rows(nbytes: int) -> int:
    """Number of claims of which a message of so many bytes can tell."""
    return max(nbytes - _HEADER.size, 0) // _ROW.size


def decode_counts(message: bytes, regions: Regions) -> WitnessCounts:
    """The counts of a message.

    Raises:
        DataError: The message is no such message, or speaks of other regions.
    """
    most = _HEADER.size + MOST_CLAIMS * _ROW.size
    if not _HEADER.size <= len(message) <= most:
        raise DataError(f"This is no message of counts: it has {len(message)} bytes.")
    version, number = _HEADER.unpack_from(message)
    if version != _FORMAT or len(message) != _HEADER.size + number * _ROW.size:
        raise DataError(
            f"This is no message of counts: it begins with format {version}, {number} rows."
        )
    rows = list(_ROW.iter_unpack(message[_HEADER.size :]))
    table = np.array(rows, np.int64).reshape(-1, 4)
    region = table[:, 0]
    if (np.diff(region) <= 0).any() or (region >= len(regions)).any():
        raise DataError(
            "This is no message of counts: its regions do not rise, or were not sent to all."
        )
    return WitnessCounts(region, table[:, 1:])
