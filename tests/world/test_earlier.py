"""The moments before a shot: constant velocity backwards."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.road_type import RoadType
from avsec_gym.world.earlier import earlier, plausible_ego_speed
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.shots import Shot, shot_of_layout


@pytest.fixture(scope="module")
def shot() -> Shot:
    """A highway with traffic."""
    return shot_of_layout(generate_layout(1, RoadType.HIGHWAY))


def test_everybody_was_behind(shot: Shot) -> None:
    before = earlier(shot, 0.2, 10.0)
    now, then = shot.moment.actors, before.moment.actors
    way = np.hypot(*(now.pose - then.pose)[1:, :2].T)
    np.testing.assert_allclose(way, 0.2 * now.speed[1:], atol=1e-9)
    assert (way > 1.0).any()
    forward = np.stack([np.cos(now.pose[:, 2]), np.sin(now.pose[:, 2])], axis=1)
    assert (((now.pose - then.pose)[:, :2] * forward).sum(axis=1) > -1e-9).all()
    still = now.speed == 0
    still[0] = False
    np.testing.assert_array_equal(now.z[still], then.z[still])
    np.testing.assert_array_equal(now.appearance, then.appearance)
    assert before.moment.time == pytest.approx(-0.2)


def test_the_ego_vehicle_kept_to_the_road(shot: Shot) -> None:
    before = earlier(shot, 0.2, 10.0)
    now, then = shot.vehicle_to_world[0], before.vehicle_to_world[0]
    assert np.linalg.norm(now[:2, 3] - then[:2, 3]) == pytest.approx(2.0, abs=0.02)
    course, ground = shot.site.course, shot.site.ground
    along, left = course.coordinates(*np.array([now[:2, 3], then[:2, 3]]).T)
    assert along[0] - along[1] == pytest.approx(2.0, abs=0.02)
    assert left[0] == pytest.approx(left[1], abs=1e-3)
    above = [pose[2, 3] - ground.height(pose[0, 3], pose[1, 3]) for pose in (now, then)]
    assert above[0] == pytest.approx(above[1])
    np.testing.assert_allclose(before.moment.actors.pose[0, :2], then[:2, 3])


def test_noise_differs_and_cameras_stay(shot: Shot) -> None:
    seeds = {earlier(shot, 0.1 * step, 5.0).seed for step in range(1, 4)} | {shot.seed}
    assert len(seeds) == 4
    assert len({seed[:2] for seed in seeds}) == 1
    assert earlier(shot, 0.1, 5.0).stage is shot.stage


def test_nobody_is_run_into(shot: Shot) -> None:
    assert 0.0 <= plausible_ego_speed(shot) <= 14.0
    assert plausible_ego_speed(shot) == plausible_ego_speed(shot)
