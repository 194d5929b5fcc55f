"""Ghosts that come, stay and go."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.error_model.drawn_ghosts import DrawnGhosts
from avsec_gym.closed_loop.error_model.model import Ghosts
from avsec_gym.closed_loop.relative_poses import in_world

SEEN = ((12.0, 1.5, 0.1, 1.5, 1.6, 4.0), (20.0, -3.0, 3.0, 1.4, 1.7, 3.8))


def test_without_any_there_are_none() -> None:
    ghosts = DrawnGhosts(Ghosts())
    assert ghosts.at((0.0, 0.0, 0.0), 0.1, np.random.default_rng(0)).shape == (0, 6)


def test_as_many_on_average_as_the_rate_and_as_long_as_the_model_has_them() -> None:
    ghosts, random = DrawnGhosts(Ghosts(2.0, SEEN, 0.5)), np.random.default_rng(3)
    counts, survived, could = [], 0, 0
    before: set[bytes] = set()
    for step in range(4000):
        pose = (0.37 * step, 0.0, 0.0)  # Each step's newcomers stand elsewhere in the world.
        rows = ghosts.at(pose, 0.1, random)
        now = {row.tobytes() for row in rows}
        survived, could = survived + len(before & now), could + len(before)
        before = now
        counts.append(len(rows))
    assert np.mean(counts) == pytest.approx(2.0, rel=0.1)
    assert survived / could == pytest.approx(np.exp(-0.1 / 0.5), rel=0.03)


def test_who_stays_keeps_its_place_in_the_world_while_the_car_drives_on() -> None:
    ghosts, random = DrawnGhosts(Ghosts(5.0, SEEN, 1e9)), np.random.default_rng(1)
    first = ghosts.at((10.0, 2.0, 0.5), 0.0, random).copy()
    later = ghosts.at((14.0, 2.0, 0.5), 0.1, random)
    assert len(first) > 0
    np.testing.assert_array_equal(later[: len(first)], first)
    expected = in_world((10.0, 2.0, 0.5), np.array(SEEN)[:, :3])
    assert all(np.isclose(expected, row[:3]).all(axis=1).any() for row in first)


def test_another_drive_begins_without_those_of_the_last() -> None:
    ghosts = DrawnGhosts(Ghosts(5.0, SEEN, 1e9))
    first = ghosts.at((0.0, 0.0, 0.0), 0.0, np.random.default_rng(7)).copy()
    ghosts.begin()
    again = ghosts.at((0.0, 0.0, 0.0), 0.0, np.random.default_rng(7))
    np.testing.assert_array_equal(first, again)
