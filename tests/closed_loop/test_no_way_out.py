"""The complete search, held against the way that full braking takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.closed_loop.no_way_out import has_no_plan, no_way_out, obstacles_to_come
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene, thesis_road
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.planning_scenario import EgoState

SPEED = 10.0


def wall(gap: float, width: float = 60.0, velocity: float = 0.0) -> TrafficScene:
    """A street and something across it, so far from the front bumper of a car at the origin."""
    x = gap + 0.5 * BMW_320I.length + 0.5
    tracks = Tracks.at_constant_velocity(
        np.array(["Car"]),
        np.array([[1.5, width, 1.0]]),
        np.array([[x, 0.0, 0.0]]),
        np.array([velocity]),
        np.array([1.65]),
        200,
    )
    start = EgoState(velocity=SPEED)
    return TrafficScene("wall", thesis_road(), RoadType.STREET, start, tracks, (6.0, 8.0))


@pytest.mark.parametrize(
    ("scene", "lost"),
    [
        (wall(6.0), True),  # 10 m/s at 8 m/s2 need 6.25 m.
        (wall(7.5), False),
        (wall(2.0, velocity=12.0), False),  # It drives away.
        (wall(8.0, width=1.0), False),  # There is room beside it, and to brake.
    ],
)
def test_there_is_no_plan_where_full_braking_is_too_late(scene: TrafficScene, lost: bool) -> None:
    assert has_no_plan(scene, scene.start, 0.0, 2.0) == lost


def test_a_way_is_lost_at_the_last_replanning_from_which_there_was_one() -> None:
    """A car drives at 10 m/s towards a wall 20 m ahead; it is lost within 6.25 m of it."""
    scene = wall(20.0)
    plans = [(t, EgoState(SPEED * t, 0.0, SPEED, 0.0, 0.0)) for t in (0.0, 0.5, 1.0, 1.5)]
    found = no_way_out(scene, plans, 2.0)
    assert found is not None
    assert (found.since, found.replannings) == (1.5, 1)
    assert no_way_out(scene, plans[:3], 2.0) is None
    # What is planned after the collision proves nothing.
    assert no_way_out(scene, plans, 1.4) is None


def test_actors_are_where_their_tracks_will_be_and_those_that_leave_are_left_out() -> None:
    tracks = replace(
        wall(10.0, velocity=3.0).tracks,
        first=np.array([12]),
    )
    coming = obstacles_to_come(tracks, 0.5, 10)
    assert (coming.first_step.tolist(), coming.steps.tolist()) == ([7], [4])
    for step in (7, 10):
        index = coming.pose_index(step)[0]
        x, y, heading, speed = tracks.state(0, 0.5 + 0.1 * step)
        assert coming.poses[0, index].tolist() == pytest.approx([x, y, heading])
        assert coming.speeds[0, index] == speed
    assert coming.pose_index(6).tolist() == [-1]
    assert not len(obstacles_to_come(replace(tracks, last=np.array([14])), 0.5, 10))
    assert not len(obstacles_to_come(tracks, 0.0, 10)), "it comes later"
