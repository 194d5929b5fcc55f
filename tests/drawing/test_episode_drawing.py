"""What is drawn from above stands where it is."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.episode_drawing import draw_episode_from_above
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene


def cars(*places: tuple[float, float]) -> Boxes3D:
    """Ahead and to the left, metres; facing forward."""
    count = len(places)
    x, y = np.array(places).reshape(count, 2).T
    return Boxes3D(
        np.column_stack([-y, np.full(count, 1.65), x]), np.tile([1.5, 1.6, 4.0], (count, 1)),
        np.full(count, -np.pi / 2), np.ones(count), np.full(count, "Car"),
    )  # fmt: skip


def middles(drawing: str, kind: str) -> list[tuple[float, float]]:
    """Metres ahead and to the left of polygons."""
    found = re.findall(rf'<polygon points="([^"]+)" class="{kind}"', drawing)
    corners = [np.array([place.split(",") for place in text.split()], float) for text in found]
    extents = [(each.min(axis=0) + each.max(axis=0)) / 2 / 12 for each in corners]
    return [(x - 7, 11 - y) for x, y in extents]


def test_objects_goal_and_car_are_where_they_are() -> None:
    scene = Scene("000000", cars((20.0, 5.0), (28.0, -3.0)))
    drawing = draw_episode_from_above(run_episode(scene, Intention.LEFT, cars((9.0, -4.0))))
    assert middles(drawing, "real") == [pytest.approx(p, abs=0.1) for p in ((20, 5), (28, -3))]
    assert middles(drawing, "believed") == [pytest.approx((9, -4), abs=0.1)]
    assert middles(drawing, "ego") == [pytest.approx((0, 0), abs=0.1)]
    assert middles(drawing, "goal") == [pytest.approx((15, 3.5), abs=0.1)]
    assert 'class="trajectory"' in drawing
    assert 'class="contact"' not in drawing


def test_a_contact_is_marked_and_no_plan_has_no_trajectory() -> None:
    scene = Scene("000000", cars((10.0, 0.0)))
    hit = run_episode(scene, Intention.STRAIGHT, cars((30.0, 9.0)))
    assert hit.record.collision
    assert 'class="contact"' in draw_episode_from_above(hit)
    blocked = run_episode(scene, Intention.STRAIGHT, cars((0.0, 0.0)))
    assert 'class="trajectory"' not in draw_episode_from_above(blocked)


def film(drawing: str, kind: str) -> list[np.ndarray]:
    """Middles over time of the one shape of a kind that moves, metres; and its key times."""
    pattern = rf'class="{kind}"><animate attributeName="points" values="([^"]+)" keyTimes="([^"]+)"'
    ((values, times),) = re.findall(pattern, drawing)
    outlines = [
        np.array([place.split(",") for place in each.split()], float) for each in values.split(";")
    ]
    middles = np.array([(each.min(axis=0) + each.max(axis=0)) / 2 for each in outlines]) / 12
    return [middles * (1, -1) + (-7, 11), np.array(times.split(";"), float)]


def test_the_car_goes_its_way_at_its_pace() -> None:
    elsewhere = cars((30.0, 9.0))
    episodes = [
        run_episode(Scene("000000", real), Intention.STRAIGHT, elsewhere)
        for real in (elsewhere, cars((10.0, 0.0)))
    ]
    assert [episode.record.outcome for episode in episodes] == ["safe", "collision"]
    for episode in episodes:
        way, times = film(draw_episode_from_above(episode), "ego")
        assert episode.plan.trajectory is not None
        driven = episode.plan.trajectory[:, :2]
        if episode.record.collision:
            driven = driven[: round(episode.record.collision_time / 0.1) + 1]
        # It rests at the end for a while.
        np.testing.assert_allclose(way, [*driven, driven[-1]], atol=0.1)
        assert times[-2] / times[1] == pytest.approx(len(driven) - 1, rel=0.01)
        assert times[0] == 0 < times[-2] < times[-1] == 1


def test_what_moves_is_where_it_is_at_each_time() -> None:
    boxes = replace(cars((14.0, 4.0), (20.0, -5.0)), moving=np.array([True, False]))
    episode = run_episode(Scene("000000", boxes), Intention.STRAIGHT, None, motion=Motion.TRUTH)
    way, _ = film(draw_episode_from_above(episode), "real")
    for step, middle in enumerate(way[:-1]):
        place = episode.truth.polygons(step)[0].centroid
        assert middle == pytest.approx((place.x, place.y), abs=0.1)
    assert np.ptp(way[:, 0]) > 1
