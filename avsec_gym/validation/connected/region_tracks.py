"""Regions of successive instants that are about the same thing: tracks.

Evidence adds up along a track, so that an alarm after several instants has a place.  The regions
are proposals, which flicker: a track outlives instants without a region.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.regions import Regions

NO_REGION = -1
"""The index of a track's region at an instant at which it has none."""
_SAME_THING = 0.1
"""Intersection over union, from above, from which a region continues a track."""
_REMEMBERED = 3
"""Instants without a region after which a track ends."""
_FARTHEST = 4.5
"""Metres that a thing may move from its first instant to the next: what is fast overlaps with
itself only once its velocity is known."""
_ALIKE = 0.5
"""Metres by which its length and its width may then differ."""


def region_tracks(instants: Sequence[Regions]) -> NDArray[np.int64]:
    """Which regions of successive instants are about the same thing.

    At each instant, the regions are assigned to the tracks one to one such that they overlap most
    with where the tracks should be: at the place of their last regions, moved on as they moved
    from the last but one.  What overlaps with no track continues the nearest one that has just
    begun and is as large, or begins one.

    Args:
        instants: The regions of each instant, world frame, T of them, at equal intervals.

    Returns:
        The index of each track's region among those of each instant, or `NO_REGION`, shape (K, T)
        for K tracks.

    Example:
        >>> def at(x):
        ...     return Regions(np.array([[x, 0, 0]]), np.array([[4.0, 2, 1.5]]), np.zeros(1))
        >>> region_tracks([at(0.0), at(2.0), at(4.0), at(40.0)]).tolist()
        [[0, 0, 0, -1], [-1, -1, -1, 0]]
    """
    tracks: list[_Track] = []
    for time, regions in enumerate(instants):
        places = seen_from_above(regions)
        alive = [track for track in tracks if time - track.times[-1] <= _REMEMBERED]
        expected = np.array([track.expected(time) for track in alive]).reshape(-1, 5)
        follows = _assigned(rectangle_iou(expected, places), _SAME_THING)
        # Of one region the velocity is not known: how near is left is what counts.
        fresh = np.array([track.times == [time - 1] for track in alive], bool)
        free = ~np.isin(np.arange(len(places)), list(follows.values()))
        fresh[list(follows)] = False
        follows |= _assigned(_nearness(expected, places) * fresh[:, None] * free, 0.0)
        for index, region in follows.items():
            alive[index].append(time, region, places[region])
        begun = set(range(len(places))) - set(follows.values())
        tracks += [_Track([time], [region], [places[region]]) for region in sorted(begun)]
    result = np.full((len(tracks), len(instants)), NO_REGION, np.int64)
    for row, track in zip(result, tracks, strict=True):
        row[track.times] = track.regions
    return result


@dataclass(eq=False)
class _Track:
    """A track as it grows.

    Args:
        times: The instants at which it has a region.
        regions: The index of the region then.
        places: Rectangles of these from above, x, y, length, width, heading.
    """

    times: list[int]
    regions: list[int]
    places: list[Floats]

    def append(self, time: int, region: int, place: Floats) -> None:
        """Continue with a region."""
        self.times.append(time)
        self.regions.append(region)
        self.places.append(place)

    def expected(self, time: int) -> Floats:
        """Where it should be, as a rectangle, shape (5,)."""
        place = self.places[-1].copy()
        if len(self.places) > 1:
            velocity = (self.places[-1] - self.places[-2])[:2] / (self.times[-1] - self.times[-2])
            place[:2] += velocity * (time - self.times[-1])
        return place


def _assigned(worth: Floats, least: float) -> dict[int, int]:
    """The column of each row, one to one, such that most is gained; above `least` alone."""
    if not worth.size:
        return {}
    rows, columns = linear_sum_assignment(-worth)
    return {
        int(row): int(column)
        for row, column in zip(rows, columns, strict=True)
        if worth[row, column] > least
    }


def _nearness(rectangles: Floats, others: Floats) -> Floats:
    """From 1 at the same place to 0 where two are too far apart, or not of one size, (N, M)."""
    away = rectangles[:, None] - others[None]
    alike = (np.abs(away[..., 2:4]) <= _ALIKE).all(axis=-1)
    return np.maximum(1.0 - np.hypot(away[..., 0], away[..., 1]) / _FARTHEST, 0.0) * alike
