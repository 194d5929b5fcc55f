"""Which obstacles may be in the way: none is forgotten, and few are named for nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.closed_loop.fail_safe import MARGIN, OTHERS_BRAKE, others_brake, widened
from avsec_gym.closed_loop.in_the_way import in_the_way
from avsec_gym.geometry import Floats
from avsec_gym.metrics.swept_contact import first_swept_contact
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles

DT = 0.1


def bend(draw: np.random.Generator) -> Floats:
    """A way at constant speed and turn rate."""
    speed, rate, heading = draw.uniform(0, 20), draw.uniform(-0.6, 0.6), draw.uniform(-3, 3)
    headings = heading + rate * DT * np.arange(20)
    way = np.zeros((20, 5))
    way[1:, 0] = np.cumsum(speed * DT * np.cos(headings[:-1]))
    way[1:, 1] = np.cumsum(speed * DT * np.sin(headings[:-1]))
    way[:, 2], way[:, 3] = speed, headings
    return way


def others(draw: np.random.Generator, count: int) -> Obstacles:
    """Some that stand and some that drive, on and in bends, all over the place."""
    poses = np.column_stack([draw.uniform(-25, 25, (count, 2)), draw.uniform(-3, 3, count)])
    speeds = np.where(draw.random(count) < 0.4, 0.0, draw.uniform(-3, 15, count))
    length, width = draw.uniform(0.5, 12, count), draw.uniform(0.5, 3, count)
    found = Obstacles.rectangles(poses, length, width, speeds, dt=DT, last_step=12)
    steps = np.arange(12)
    turns = draw.uniform(-0.3, 0.3, count)[:, None]  # Each time step, if it drives.
    headings = poses[:, 2:] + turns * steps
    ahead = DT * speeds[:, None, None] * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    tracks = found.poses.copy()
    tracks[:, 1:, :2] = poses[:, None, :2] + np.cumsum(ahead, axis=1)
    tracks[:, 1:, 2] = np.where(found.static[:, None], poses[:, 2:], headings + turns)
    return replace(found, poses=tracks)


def touched(way: Floats, obstacles: Obstacles) -> bool:
    """Whether one alone is touched, as it drives on or as it brakes, by the exact test."""
    whole = widened(obstacles, ~obstacles.static)
    heading = float(obstacles.poses[0, 0, 2])  # So that it counts as driving the same way.
    slower = others_brake(whole, heading, DT)
    return any(
        first_swept_contact(way, each, BMW_320I) is not None
        for each in (whole, slower)
        if each is not None
    )


def test_whatever_is_touched_is_in_the_way_and_most_that_is_not_is_not() -> None:
    draw = np.random.default_rng(5)
    counts = {(named, hit): 0 for named in (True, False) for hit in (True, False)}
    for _ in range(60):
        way, count = bend(draw), 8
        obstacles = others(draw, count)
        asked = draw.random(count) < 0.9
        named = in_the_way(way, obstacles, asked, margin=MARGIN, brake=OTHERS_BRAKE, dt=DT)
        assert not (named & ~asked).any()
        for i in np.flatnonzero(asked):
            rows = {name: value[[i]] for name, value in vars(obstacles).items() if name != "shapes"}
            alone = Obstacles(shapes=(obstacles.shapes[i],), **rows)
            counts[bool(named[i]), touched(way, alone)] += 1
    assert counts[False, True] == 0
    assert counts[True, True] > 30
    assert counts[True, False] < 0.3 * counts[True, True]


def test_what_is_no_rectangle_or_appears_later_is_left_to_the_exact_test() -> None:
    way = np.zeros((3, 5))
    far = Obstacles.rectangles(np.array([[500.0, 0, 0]]), np.ones(1), np.ones(1))
    asked = np.ones(1, bool)
    assert not in_the_way(way, far, asked, margin=0.1, brake=4.0, dt=DT).any()
    late = Obstacles(**{**vars(far), "first_step": np.ones(1, np.int64)})
    assert in_the_way(way, late, asked, margin=0.1, brake=4.0, dt=DT).all()
