"""How one witness' rays support another vehicle's claims, as counts and as a message."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_overlap
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.merging import seen_from_above, stands_in
from avsec_gym.validation.connected.rays.claims import (
    MARGIN,
    MOST_CLAIMS,
    MOST_VOXELS_OF_ONE,
    SEARCHED,
    Claims,
    grid_shapes,
)
from avsec_gym.validation.connected.rays.observer import Observer
from avsec_gym.validation.connected.rays.witness import WitnessMargins, count_outcomes
from avsec_gym.validation.connected.regions import Regions

ACCUSING_RAYS = 8
"""Rays that pass through what a vehicle claims, at least, where another accuses."""
_SAME_PLACE = 2
"""Voxels by which two claims of what stands may reach less or more far to each side."""
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
    witness: Observer,
    claims: Claims,
    regions: Regions,
    margins: WitnessMargins,
    further: Sequence[Claims] | None = None,
) -> WitnessCounts:
    """How many of a witness' rays support and contradict another vehicle's claims.

    Vehicles look at different times, and what neither tracks may have moved meanwhile.  Where a
    witness' rays contradict a claim without a velocity, it asks whether they would support it, had
    the thing moved along its region's heading at some speed up to `WitnessMargins.fastest`, and
    reports the counts that support it most.  Of a vehicle of which one face was seen, nothing shows
    which of its sides is the longer one: of what may have moved across its region, to where nothing
    else is claimed, fewer rays that pass through are reported than an accusation needs.  Of regions
    in which the witness itself stands it reports nothing.

    Of scans at intervals, more than `SEARCHED` seconds apart a thing may have gone anywhere, out of
    sight, too.  Then rays that pass where it was count for nothing, unless a further vehicle saw it
    there, too, and the witness looked between the two: what is at the same place before and after
    stood meanwhile.  Of scans of one instant this is left out: whoever lies about a claim's time
    would silence all witnesses.

    Args:
        witness: The vehicle that looks.
        claims: What another vehicle claims.
        regions: The regions that all vehicles share.
        margins: What may lie apart.
        further: What further vehicles claim, as far as the witness has heard of it, where scans are
            taken at intervals; None: all scans are of one instant.
    """
    counts = np.zeros((len(claims), 3), np.int64)
    blind = np.zeros(len(regions), bool)
    if not witness.scan.roadside:
        blind = stands_in(regions, witness.pose)
    seen = np.flatnonzero(~blind[claims.region])
    counts[seen] = count_outcomes(witness, claims[seen], regions, margins)[0]
    untracked = ~claims.velocity.any(axis=1)
    long_after = np.zeros(len(claims), bool)
    if further is not None and margins.fastest > 0:
        between = _time_between(witness, claims, regions)
        long_after = untracked & (np.abs(between) > SEARCHED)
        stood = _stood_meanwhile(claims, claims.time + between, further, regions)
        counts[long_after & ~stood, 1:] = 0
    doubted = np.flatnonzero(untracked & ~long_after & (counts[:, 1] > counts[:, 0]))
    if margins.fastest > 0 and len(doubted):
        some, before = claims[doubted], counts[doubted]
        _, moved = _moved_along(0.0, witness, some, before, regions, margins)
        # Of each claim the first of those moves that most rays support, if more than before.
        every = np.concatenate([before[None], moved])
        lead = every[..., 0] - every[..., 1]
        lead[1:][~_is_supported(moved, before)] = np.iinfo(np.int64).min
        best = every[lead.argmax(axis=0), np.arange(len(doubted))]
        counts[doubted] = best
        # Of what may have moved across, too few rays are reported for an accusation.
        left = doubted[(best[:, 1] >= ACCUSING_RAYS) & (best[:, 1] >= best[:, 0])]
        if len(left):
            some, before, own = claims[left], counts[left], claims.region[left]
            by, moved = _moved_along(np.pi / 2, witness, some, before, regions, margins)
            move, thing = np.nonzero(_is_supported(moved, before))
            place = _moved(regions[own[thing]], by[move, thing])
            excused = ~_is_claimed(place, own[thing], claims, regions)
            counts[left[thing[excused]], 1] = ACCUSING_RAYS - 1
    return WitnessCounts(claims.region, counts)


def _stood_meanwhile(
    claims: Claims, looked: Floats, further: Sequence[Claims], regions: Regions
) -> NDArray[np.bool_]:
    """Whether what is claimed stood when a witness looked, as further claims show, shape (C,).

    Args:
        claims: C claims of one vehicle.
        looked: When the witness looked at each, seconds after the instant, shape (C,).
        further: Claims of others.
        regions: The regions that all vehicles share.
    """
    stood, extents = np.zeros(len(claims), bool), _extents(claims, regions)
    for other in further:
        _, mine, theirs = np.intersect1d(claims.region, other.region, return_indices=True)
        before_and_after = (claims.time - looked)[mine] * (other.time[theirs] - looked[mine]) < 0
        apart = np.abs(extents[mine] - _extents(other, regions)[theirs])
        stood[mine] |= before_and_after & (apart <= _SAME_PLACE).all(axis=1)
    return stood


def _extents(claims: Claims, regions: Regions) -> NDArray[np.int64]:
    """The least and greatest voxel along, across and up each claim's region, shape (C, 6)."""
    if not len(claims):
        return np.zeros((0, 6), np.int64)
    shape = grid_shapes(regions.grown(MARGIN, MARGIN).size)[claims.region]
    _, across, up = np.repeat(shape, claims.count, axis=0).T
    column, voxel = np.divmod(claims.voxel, up)
    place = np.stack([*np.divmod(column, across), voxel], axis=1)
    first = np.cumsum(claims.count) - claims.count
    return np.hstack([np.minimum.reduceat(place, first), np.maximum.reduceat(place, first)])


def _moved_along(
    turned: float,
    witness: Observer,
    claims: Claims,
    before: NDArray[np.int64],
    regions: Regions,
    margins: WitnessMargins,
) -> tuple[Floats, NDArray[np.int64]]:
    """What a witness counts, had what is claimed moved at speeds up to `WitnessMargins.fastest`.

    Args:
        turned: Angle from the regions' headings to the way that things moved, radians.
        witness: The vehicle that looks.
        claims: C claims.
        before: What it counts where they are claimed, shape (C, 3).
        regions: The regions that all vehicles share.
        margins: What may lie apart.

    Returns:
        How far each thing moved along the world's x and y, metres, shape (S, C, 2), and supporting,
        passing and missing rays, shape (S, C, 3), all 0 where not half as many support as met the
        claim before.
    """
    between = _time_between(witness, claims, regions)
    steps = int(np.ceil(margins.fastest * np.abs(between).max() / _SHIFT))
    axis = regions.heading[claims.region] + turned
    ahead = np.stack([np.cos(axis), np.sin(axis)], axis=1)
    shares = np.delete(np.linspace(-1.0, 1.0, 2 * steps + 1), steps)
    velocities = margins.fastest * shares[:, None, None] * ahead
    enough = np.maximum(before[:, :2].sum(axis=1), 1)
    moved = count_outcomes(witness, claims, regions, margins, velocities, (enough + 1) // 2)
    return velocities * between[:, None], moved


def _is_supported(moved: NDArray[np.int64], before: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether claims are supported at other places, by half of the rays of before, shape (S, C).

    Fewer rays are no excuse.
    """
    return (moved[..., 0] > moved[..., 1]) & (2 * moved[..., 0] >= before[:, :2].sum(axis=1))


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
    return np.asarray((common > 0.0).any(axis=1))


_SHIFT = 0.4
"""Metres between the places at which a thing that may have moved is looked for."""


def _time_between(witness: Observer, claims: Claims, regions: Regions) -> Floats:
    """How long after each claim the witness' head faces its region, seconds, shape (C,)."""
    centre = regions.centre[claims.region]
    to_sensor = np.linalg.inv(witness.pose)
    x, y = (centre @ to_sensor[:2, :3].T + to_sensor[:2, 3]).T
    return witness.scan.time + witness.scan.sweep.facing_time(x, y) - claims.time


def encode_counts(counts: WitnessCounts) -> bytes:
    """Counts as a message; claims that no ray met are left out."""
    with_rays = counts.counts.any(axis=1)
    region, of_rays = counts.region[with_rays], counts.counts[with_rays]
    rows = np.column_stack([region, of_rays]).tolist()
    return _HEADER.pack(_FORMAT, len(rows)) + b"".join(_ROW.pack(*row) for row in rows)


def most_rows(nbytes: int) -> int:
    """Number of claims whose counts a message of so many bytes holds."""
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
