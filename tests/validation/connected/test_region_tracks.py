"""Tracks of regions: what moves keeps its own, what flickers too, and neighbours do not swap."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.region_tracks import NO_REGION, region_tracks
from avsec_gym.validation.connected.regions import Regions


def _cars(places: list[tuple[float, float]], length: float = 4.5) -> Regions:
    centre: Floats = np.array([(x, y, 0.0) for x, y in places]).reshape(-1, 3)
    return Regions(centre, np.tile([length, 1.8, 1.5], (len(centre), 1)), np.zeros(len(centre)))


@pytest.mark.parametrize("speed", [0.0, 14.0, 40.0])
def test_what_moves_is_one_track(speed: float) -> None:
    tracks = region_tracks([_cars([(0.1 * speed * t, 0.0), (0.0, 20.0)]) for t in range(10)])
    assert tracks.tolist() == [[0] * 10, [1] * 10]


def test_a_track_outlives_three_instants_without_a_region() -> None:
    seen = {0, 1, 5}
    tracks = region_tracks([_cars([(1.5 * t, 0.0)] if t in seen else []) for t in range(6)])
    assert tracks.tolist() == [[0, 0, *3 * [NO_REGION], NO_REGION], [*5 * [NO_REGION], 0]]
    seen = {0, 1, 4, 5}
    tracks = region_tracks([_cars([(1.5 * t, 0.0)] if t in seen else []) for t in range(6)])
    assert tracks.tolist() == [[0, 0, NO_REGION, NO_REGION, 0, 0]]


def test_those_that_pass_each_other_do_not_swap() -> None:
    """Two cars in neighbouring lanes, whose order among the regions changes."""
    instants = []
    for t in range(10):
        places = [(1.4 * t, 0.0), (14.0 - 1.4 * t, 3.5)]
        instants.append(_cars(places if t % 2 else places[::-1]))
    tracks = region_tracks(instants)
    assert len(tracks) == 2
    assert tracks[0].tolist() == [t % 2 for t in range(10)]


def test_what_is_of_another_size_or_too_far_begins_a_track() -> None:
    assert len(region_tracks([_cars([(0.0, 0.0)], 2.0), _cars([(4.0, 0.0)], 4.5)])) == 2
    assert len(region_tracks([_cars([(0.0, 0.0)]), _cars([(5.0, 0.0)])])) == 2


def test_without_regions_there_is_no_track() -> None:
    assert region_tracks([]).shape == (0, 0)
    assert region_tracks([_cars([]), _cars([])]).shape == (0, 2)
