"""Draws of scenes can be made again, and hang on nothing but the seed and the ids."""

from __future__ import annotations

import hashlib
from itertools import pairwise

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.scene_draw import drawn_scenes

IDS = tuple(f"{number:06d}" for number in range(600))


def test_a_draw_is_the_head_of_the_documented_queue() -> None:
    places = {id: hashlib.sha256(f"7 {id}".encode()).hexdigest() for id in IDS}
    drawn = drawn_scenes(IDS, 150, seed=7)
    assert len(drawn) == 150
    assert list(drawn) == sorted(drawn)
    assert max(places[id] for id in drawn) < min(places[id] for id in set(IDS) - set(drawn))


def test_larger_draws_hold_smaller_ones_and_the_order_of_ids_does_not_matter() -> None:
    draws = [set(drawn_scenes(IDS, count, seed=0)) for count in (1, 10, 150, 599)]
    assert all(small < large for small, large in pairwise(draws))
    assert drawn_scenes(IDS, 1000, seed=0) == IDS
    backwards = drawn_scenes(IDS[::-1], 150, seed=0)
    assert backwards == drawn_scenes(IDS, 150, seed=0)[::-1]


def test_fewer_scenes_are_drawn_in_the_same_order() -> None:
    first = IDS[:200]
    whole = drawn_scenes(IDS, 150, seed=0)
    assert set(whole) & set(first) <= set(drawn_scenes(first, 150, seed=0))


def test_every_scene_is_as_likely_as_any_other() -> None:
    counts = dict.fromkeys(IDS, 0)
    for seed in range(200):
        for id in drawn_scenes(IDS, 150, seed):
            counts[id] += 1
    shares = np.array([*counts.values()]) / 200
    assert shares.mean() == pytest.approx(0.25)
    # Binomial: 200 draws at 1 / 4 spread by 0.031; five of these on either side.
    assert abs(shares - 0.25).max() < 5 * np.sqrt(0.25 * 0.75 / 200)
    assert shares.std() == pytest.approx(np.sqrt(0.25 * 0.75 / 200), rel=0.15)


@pytest.mark.parametrize("count", [0, 2.5, True])
def test_a_draw_of_no_such_number_is_refused(count: object) -> None:
    with pytest.raises(ConfigurationError, match="drawn_scenes"):
        drawn_scenes(IDS, count, seed=0)  # type: ignore[arg-type]
