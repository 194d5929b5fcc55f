"""Who is attacked, from the distances of all pairs of vehicles in a region (section 4.4.4)."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.identification import identify_attacked_sensors


def attacked_vehicles(distances: Floats, threshold: float) -> frozenset[int]:
    """The vehicles that are named as attacked in a region.

    Of three, the one whose two distances exceed theta while the third does not. Of more, those
    that algorithms 1 and 2 of chapter 3 name. Fewer can only raise an alarm: none is named.

    Args:
        distances: dist_{i,j1,j2} of all pairs, shape (n, n), symmetric; NaN of pairs that
            compared nothing.
        threshold: Theta, metres.

    Example:
        >>> far = np.array([[np.nan, 0.1, 1.2], [0.1, np.nan, 1.4], [1.2, 1.4, np.nan]])
        >>> sorted(attacked_vehicles(far, 0.8))
        [2]
    """
    who = comparable_vehicles(distances)
    exceeds = distances[np.ix_(who, who)] > threshold
    if len(who) < 3:
        return frozenset()
    if len(who) == 3:
        return frozenset({int(who[i]) for i in range(3) if _stands_alone(exceeds, i)})

    def state(triple: Triple) -> bool:
        """e_{i,j,k}: one of the three surfaces is another than the other two."""
        return any(exceeds[i, j] for i, j in combinations(triple, 2))

    named = identify_attacked_sensors(state, len(who)).named
    return frozenset(int(who[i]) for i in named)


def is_alarm(distances: Floats, threshold: float) -> bool:
    """Whether some two vehicles see different surfaces in a region."""
    return bool((distances > threshold).any())


def comparable_vehicles(distances: Floats) -> NDArray[np.intp]:
    """Vehicles all of whose pairs have a distance, so that each is a witness of the others.

    A vehicle that compared nothing with another neither accuses nor clears it. The one that lacks
    most distances is left out, until none lacks any.
    """
    who = np.arange(len(distances))
    while len(who) > 1:
        lacking = np.isnan(distances[np.ix_(who, who)]).sum(axis=1) - 1
        if not lacking.any():
            return who
        who = np.delete(who, int(np.argmax(lacking)))
    return who[:0]


def _stands_alone(exceeds: NDArray[np.bool_], i: int) -> bool:
    j, k = (other for other in range(3) if other != i)
    return bool(exceeds[i, j] and exceeds[i, k] and not exceeds[j, k])
