"""Rates of the thesis' method from the distances that `viewpoints` measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.distance_thresholds import distance_threshold
from studies.chapter4.viewpoints import (
    APART,
    CLEAN,
    GHOST,
    MESHERS,
    OPTIMISED,
    REMOVAL,
    SIDES,
    VIEWPOINTS,
    PlaceResult,
    RegionDistances,
)

RATES = (0.1, 0.3)
"""The designated false positive rates of which the thesis has detection rates."""
BOUND = 0.8
"""Metres: the thesis' bound of the majorities."""


@dataclass(frozen=True)
class DetectionRow:
    """Detection at a designated false positive rate, thresholds of other places.

    Args:
        rate: The designated rate r.
        theta: The threshold, metres.
        false_alarms: Judged attack-free pairs beyond theta.
        detected: Attacked regions of which a distance with the victim lies beyond theta.
    """

    rate: float
    theta: float
    false_alarms: Share
    detected: Share


@dataclass(frozen=True)
class WayRow:
    """A way to compare, under one attack.

    Args:
        viewpoints: Where scans are taken from.
        mesher: How surfaces are made.
        sides: Metres cropped beside a region.
        attack: The attack.
        compared: Attacks of which a proposal's surface was compared with the victim's.
        clean_below: Judged attack-free distances below `BOUND`.
        attacked_above: Distances with the victim above it.
        median: The median of these, metres; None without any.
        detection: A row for each of `RATES`.
    """

    viewpoints: str
    mesher: str
    sides: float
    attack: str
    compared: Share
    clean_below: Share
    attacked_above: Share
    median: float | None
    detection: tuple[DetectionRow, ...]


@dataclass(frozen=True)
class CoverRow:
    """Attacks that a proposal is about.

    Args:
        viewpoints: Where scans are taken from.
        attack: The attack.
        covered: How many of all that were made.
    """

    viewpoints: str
    attack: str
    covered: Share


@dataclass(frozen=True)
class MeshTime:
    """What a mesher takes for all surfaces of a region.

    Args:
        mesher: One of `MESHERS`.
        regions: Number of regions.
        seconds: Mean time of a region.
    """

    mesher: str
    regions: int
    seconds: float


@dataclass(frozen=True)
class ViewpointRates:
    """The result.

    Args:
        places: Places of each part.
        seed: Seed of the places.
        ways: A row for each way to compare and attack.
        covers: A row for each viewpoint and attack.
        times: A row for each mesher.
    """

    places: int
    seed: int
    ways: tuple[WayRow, ...]
    covers: tuple[CoverRow, ...]
    times: tuple[MeshTime, ...]


def viewpoint_rates(places: Sequence[PlaceResult], seed: int) -> ViewpointRates:
    """Rates of all that was measured.

    Args:
        places: What was measured at each place, of both parts.
        seed: Seed of the places.
    """
    regions = [each for place in places for each in place.regions]
    return ViewpointRates(
        len(places) // 2,
        seed,
        tuple(_ways(regions)),
        tuple(_covers(places)),
        tuple(_times(places)),
    )


def _ways(regions: Sequence[RegionDistances]) -> Iterator[WayRow]:
    for viewpoints in VIEWPOINTS:
        for mesher in MESHERS:
            for sides in SIDES[:1] if mesher == OPTIMISED else SIDES:
                own = [
                    each
                    for each in regions
                    if (each.viewpoints, each.mesher, each.sides) == (viewpoints, mesher, sides)
                ]
                for attack in (GHOST, REMOVAL) if viewpoints == APART else (GHOST,):
                    row = _way(own, attack)
                    if row is not None:
                        yield row


def _way(regions: Sequence[RegionDistances], attack: str) -> WayRow | None:
    """The rates of one way; None where nothing was compared that thresholds could come from."""
    fitted = [d for each in regions if each.part == FITTED for d in each.distances]
    clean = [each for each in regions if (each.part, each.state) == (JUDGED, CLEAN)]
    about = [each for each in regions if each.state == attack]
    attacked = [each for each in about if each.distances]
    if not fitted:
        return None
    first = regions[0]
    own = [d for each in attacked for d in each.distances]
    return WayRow(
        first.viewpoints,
        first.mesher,
        first.sides,
        attack,
        _compared(about),
        _pairs(clean, lambda distances: distances < BOUND),
        _pairs(attacked, lambda distances: distances > BOUND),
        float(np.median(own)) if own else None,
        tuple(_detection(fitted, clean, attacked, rate) for rate in RATES),
    )


def _compared(about: Sequence[RegionDistances]) -> Share:
    """Attacks that were compared; several regions can be about one."""
    places = sorted({each.place for each in about})
    compared = {each.place for each in about if each.distances}
    return share_of([place in compared for place in places], places)


def _detection(
    fitted: Sequence[float],
    clean: Sequence[RegionDistances],
    attacked: Sequence[RegionDistances],
    rate: float,
) -> DetectionRow:
    theta = distance_threshold(fitted, rate)
    # An attack that several regions are about is one.
    highest: dict[str, float] = {}
    for each in attacked:
        highest[each.place] = max(highest.get(each.place, 0.0), *each.distances)
    detected = share_of([value > theta for value in highest.values()], list(highest))
    return DetectionRow(rate, theta, _pairs(clean, lambda found: found > theta), detected)


def _pairs(
    regions: Sequence[RegionDistances], is_hit: Callable[[Floats], NDArray[np.bool_]]
) -> Share:
    """Pairs that are hits, places as clusters."""
    distances = np.array([d for each in regions for d in each.distances])
    places = [each.place for each in regions for _ in each.distances]
    return share_of(is_hit(distances), places)


def _covers(places: Sequence[PlaceResult]) -> Iterator[CoverRow]:
    for viewpoints in VIEWPOINTS:
        for attack in (GHOST, REMOVAL) if viewpoints == APART else (GHOST,):
            key = (viewpoints, attack)
            made = [key in place.covered for place in places if key in place.attacks]
            yield CoverRow(viewpoints, attack, share_of(made, [str(i) for i in range(len(made))]))


def _times(places: Sequence[PlaceResult]) -> Iterator[MeshTime]:
    for mesher in MESHERS:
        spent = [place.seconds[mesher] for place in places if mesher in place.seconds]
        regions = sum(count for _, count in spent)
        if regions:
            yield MeshTime(mesher, regions, sum(seconds for seconds, _ in spent) / regions)
