"""The frames before a posed scene: constant velocity backwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.geometry import rectangle_corners
from avsec_gym.road_type import RoadType
from avsec_gym.world.earlier import earlier, plausible_ego_speed
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.posed_scenes import PosedScene, posed_scene_of_layout


@pytest.fixture(scope="module")
def posed() -> PosedScene:
    """A highway with traffic."""
    return posed_scene_of_layout(generate_layout(1, RoadType.HIGHWAY))


def test_moving_actors_were_behind(posed: PosedScene) -> None:
    before = earlier(posed, 0.2, 10.0)
    now, then = posed.instant.actors, before.instant.actors
    way = np.hypot(*(now.pose - then.pose)[1:, :2].T)
    np.testing.assert_allclose(way, 0.2 * now.speed[1:], atol=1e-9)
    assert (way > 1.0).any()
    forward = np.stack([np.cos(now.pose[:, 2]), np.sin(now.pose[:, 2])], axis=1)
    assert (((now.pose - then.pose)[:, :2] * forward).sum(axis=1) > -1e-9).all()
    still = now.speed == 0
    still[0] = False
    np.testing.assert_array_equal(now.z[still], then.z[still])
    np.testing.assert_array_equal(now.appearance, then.appearance)
    assert before.instant.time == pytest.approx(-0.2)


def test_the_ego_vehicle_kept_to_the_road(posed: PosedScene) -> None:
    before = earlier(posed, 0.2, 10.0)
    now, then = posed.vehicle_to_world[0], before.vehicle_to_world[0]
    assert np.linalg.norm(now[:2, 3] - then[:2, 3]) == pytest.approx(2.0, abs=0.02)
    course, ground = posed.site.course, posed.site.ground
    along, left = course.coordinates(*np.array([now[:2, 3], then[:2, 3]]).T)
    assert along[0] - along[1] == pytest.approx(2.0, abs=0.02)
    assert left[0] == pytest.approx(left[1], abs=1e-3)
    above = [pose[2, 3] - ground.height(pose[0, 3], pose[1, 3]) for pose in (now, then)]
    assert above[0] == pytest.approx(above[1])
    np.testing.assert_allclose(before.instant.actors.pose[0, :2], then[:2, 3])


def test_noise_differs_and_cameras_stay(posed: PosedScene) -> None:
    seeds = {earlier(posed, 0.1 * step, 5.0).seed for step in range(1, 4)} | {posed.seed}
    assert len(seeds) == 4
    assert len({seed[:2] for seed in seeds}) == 1
    assert earlier(posed, 0.1, 5.0).built is posed.built


def with_leader(posed: PosedScene, gap: float) -> PosedScene:
    """The scene with one other road user: this far ahead, bumper to bumper, in the same lane."""
    actors, own = posed.instant.actors, posed.instant.egos[0]
    other = (own + 1) % len(actors.pose)
    half = 0.5 * (actors.dimensions[other, 2] + actors.dimensions[own, 2])
    course = posed.site.course
    along, left = course.coordinates(*actors.pose[own, :2])
    pose = actors.pose.copy()
    pose[:, :2] += 500.0 * (np.arange(len(pose)) != own)[:, None]
    pose[other] = course.poses([float(along) + half + gap], float(left))[0]
    return replace(posed, instant=replace(posed.instant, actors=replace(actors, pose=pose)))


def test_the_ego_vehicle_keeps_its_distance(posed: PosedScene) -> None:
    """1.5 s behind, beyond the 3 m of a queue; faster than the road allows, never."""
    alone = plausible_ego_speed(with_leader(posed, 200.0))
    assert 10.0 <= alone <= 14.0
    for gap in (3.0, 6.0, 12.0):
        assert plausible_ego_speed(with_leader(posed, gap)) == pytest.approx(
            (gap - 3.0) / 1.5, abs=0.05
        )
    assert plausible_ego_speed(with_leader(posed, 1.0)) == 0.0
    assert plausible_ego_speed(with_leader(posed, 60.0)) == alone


def test_no_road_user_is_run_into(posed: PosedScene) -> None:
    """In the 0.3 s before, no rectangle reaches into that of the ego vehicle."""
    from shapely.geometry import Polygon

    speed = plausible_ego_speed(posed)
    for seconds in (0.1, 0.2, 0.3):
        before = earlier(posed, seconds, speed).instant
        sizes = before.actors.dimensions
        corners = rectangle_corners(before.actors.pose[:, :3], sizes[:, 2], sizes[:, 1])
        own = Polygon(corners[before.egos[0]])
        others = np.delete(corners, before.egos[0], axis=0)
        assert not any(own.intersects(Polygon(each)) for each in others)
