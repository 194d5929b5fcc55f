"""What a base station takes of decoded messages: only what an honest vehicle could send.

A message that is sound by its bytes may still be made to harm: a pose on the other side of the
earth, regions that crowd out those of the others or are as large as a town, a crop with points
outside of its region, testimony of what was never claimed. Each is cut down here to what a LiDAR
vehicle can know, one sender at a time, so that no message changes what is taken from the others.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.cropping import CropMargins
from avsec_gym.validation.connected.merging import DUPLICATE_IOU, seen_from_above
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.region_message import MOST_REGIONS, RegionMessage
from avsec_gym.validation.connected.rays.claims import Claims
from avsec_gym.validation.connected.rays.witness_counts import WitnessCounts

MOST_OF_ONE = 100
"""Regions of one vehicle: as many as it may claim."""
SIGHT = 90.0
"""Metres from its sensor within which a vehicle proposes; two such vehicles `RADIO` apart have a
complete set whose places fit into its message."""
RADIO = 200.0
"""Metres from each other within which vehicles can have seen the same."""
LARGEST = (20.0, 20.0, 6.0)
"""Length, width and height of the largest region, metres: an articulated bus has 18 x 2.6 x 3.5."""
_SMALLEST = 0.1
_MOST_TILT = np.radians(30.0)


def admitted_proposals(messages: Iterable[RegionMessage]) -> list[RegionMessage]:
    """The proposals that the base station merges, by number of the sender.

    Of a sender with several messages the first counts. One that is tilted by more than 30 degrees,
    or farther than `RADIO` from the largest group of vehicles that are near each other, is left
    out; of what the others propose, those regions are left out that lie beyond `SIGHT`, have
    impossible sizes, overlap an earlier one of the same vehicle, or are too many.

    Args:
        messages: What came in, in the order in which it came.
    """
    first: dict[int, RegionMessage] = {}
    for message in messages:
        if message.pose[2, 2] >= np.cos(_MOST_TILT):
            first.setdefault(message.sender, message)
    near = [first[sender] for sender in _neighbours(first)]
    share = min(MOST_OF_ONE, MOST_REGIONS // max(len(near), 1))
    return [_believable(message, share) for message in near]


def admitted_crops(
    messages: Iterable[CropMessage],
    complete_set: RegionMessage,
    margins: CropMargins = CropMargins(),
) -> list[CropMessage]:
    """The crops that the base station compares, by number of the sender.

    Of a sender with several messages the first counts; one that does not answer for each region is
    left out, and so are points outside of what is cropped.

    Args:
        messages: What came in, in the order in which it came.
        complete_set: The regions that were distributed.
        margins: How much more than a region is cropped.
    """
    regions = complete_set.regions
    first: dict[int, CropMessage] = {}
    for message in messages:
        if len(message.crops) == len(regions):
            first.setdefault(message.sender, message)
    # Bytes are exact to 5 mm.
    half = regions.size[:, :2] / 2 + margins.sides + 0.01
    low = np.full(len(regions), -margins.below - 0.01)
    high = regions.size[:, 2] + margins.above + 0.01
    return [
        CropMessage(
            sender,
            tuple(
                crop[
                    (np.abs(crop[:, :2]) <= sides).all(axis=1)
                    & (crop[:, 2] >= bottom)
                    & (crop[:, 2] <= top)
                ]
                for crop, sides, bottom, top in zip(
                    first[sender].crops, half, low, high, strict=True
                )
            ),
        )
        for sender in sorted(first)
    ]


def admitted_counts(counts: WitnessCounts, claims: Claims) -> WitnessCounts:
    """What a witness reports of a vehicle's claims, of which no more than was claimed.

    Rows of regions that were not claimed, or with more voxels than the claim has, are left out.

    Args:
        counts: What the witness sent.
        claims: The claims that it was sent.
    """
    claimed = np.zeros(max(counts.region.max(initial=-1), claims.region.max(initial=-1)) + 1)
    claimed[claims.region] = claims.count
    kept = counts.counts.sum(axis=1) <= claimed[counts.region]
    return WitnessCounts(counts.region[kept], counts.counts[kept])


def _neighbours(messages: dict[int, RegionMessage]) -> list[int]:
    """The senders that are within `RADIO` of the one which most senders are near to."""
    senders = sorted(messages)
    if not senders:
        return []
    places: Floats = np.stack([messages[sender].pose[:3, 3] for sender in senders])
    near = np.linalg.norm(places[:, None] - places, axis=2) <= RADIO
    middle = int(near.sum(axis=1).argmax())
    return [sender for sender, is_near in zip(senders, near[middle], strict=True) if is_near]


def _believable(message: RegionMessage, share: int) -> RegionMessage:
    """A vehicle's message with the first regions that a vehicle could propose."""
    regions = message.regions
    possible = (np.linalg.norm(regions.centre, axis=1) <= SIGHT) & (
        (regions.size >= _SMALLEST) & (regions.size <= LARGEST)
    ).all(axis=1)
    kept = regions[possible]
    kept = kept[_first_of_each(seen_from_above(kept))]
    return RegionMessage(message.sender, message.pose, kept[:share])


def _first_of_each(rectangles: Floats) -> NDArray[np.intp]:
    """Rectangles that no earlier one of those chosen overlaps, shape (K,)."""
    overlaps = rectangle_iou(rectangles, rectangles) > DUPLICATE_IOU
    chosen: list[int] = []
    for index in range(len(rectangles)):
        if not overlaps[index, chosen].any():
            chosen.append(index)
    return np.array(chosen, np.intp)
