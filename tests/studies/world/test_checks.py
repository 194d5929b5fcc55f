"""Faults that are put into a small world must be found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.world.actors import Actors
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box
from studies.world.checks import (
    FailingFrames,
    SceneChecks,
    feet_gaps,
    ground_gap,
    is_pierced,
    overlapping,
    summary,
)
from studies.world.tiling import _along_road, _highest_repeat


def actors(*poses: tuple[float, float, float], z: float = 0.0) -> Actors:
    count = len(poses)
    return Actors(
        id=np.arange(count),
        category=np.full(count, "Car"),
        dimensions=np.tile([1.5, 1.8, 4.4], (count, 1)),
        pose=np.array(poses),
        z=np.full(count, z),
        speed=np.zeros(count),
        moving=np.zeros(count, bool),
        appearance=np.arange(count),
        phase=np.zeros(count),
    )


def world(*poles: tuple[float, float]) -> RayScene:
    """Flat ground at height 0, and poles."""
    things = [Thing(box(60.0, 60.0, 1.0).placed(0.0, 0.0, -1.0), Surface.ROAD)]
    things += [Thing(box(0.3, 0.3, 4.0).placed(x, y), Surface.FURNITURE) for x, y in poles]
    return RayScene(things)


def test_gaps_below_actors() -> None:
    standing = actors((0.0, 0.0, 0.4))
    assert ground_gap(world(), standing, 0) == pytest.approx(0.0, abs=1e-4)
    floating = replace(standing, z=np.array([0.12]))
    assert ground_gap(world(), floating, 0) == pytest.approx(0.12, abs=1e-4)
    assert feet_gaps(world(), floating, 0)[0] == pytest.approx(0.12, abs=0.011)
    nowhere = actors((90.0, 0.0, 0.0))
    assert ground_gap(world(), nowhere, 0) == 99.0


def test_actors_in_one_another() -> None:
    assert overlapping(actors((0, 0, 0), (4.6, 0, 0), (0, 3, 0))) == []
    assert overlapping(actors((0, 0, 0), (4.0, 0.5, 0.3), (0, 3, 0))) == [[0, 1]]


def test_scenery_in_an_actor() -> None:
    car = actors((2.0, 1.0, 0.8))
    assert not is_pierced(world((8.0, 1.0)), car, 0)
    assert is_pierced(world((2.0, 1.0)), car, 0)
    bumper = 2.0 + 2.0 * np.cos(0.8), 1.0 + 2.0 * np.sin(0.8)
    assert is_pierced(world(bumper), car, 0)


def test_a_texture_that_repeats_is_told_from_one_that_does_not() -> None:
    rng = np.random.default_rng(0)
    tile = rng.standard_normal((200, 200)).astype(np.float32)
    whole = np.ones((700, 700), np.float32)
    assert _highest_repeat(np.tile(tile, (4, 4))[:700, :700], whole) > 0.9
    assert _highest_repeat(rng.standard_normal((700, 700)).astype(np.float32), whole) < 0.1


def test_what_runs_along_the_road_is_no_repeat() -> None:
    rng = np.random.default_rng(0)
    whole = np.ones((700, 700), np.float32)
    left = np.broadcast_to(np.linspace(7.0, -7.0, 700), (700, 700))
    tracks = np.cos(3.0 * left) + 0.5 * rng.standard_normal((700, 700))
    bands = np.asarray(tracks, np.float32)
    assert _highest_repeat(bands, whole) > 0.6
    assert _highest_repeat(bands - _along_road(bands, whole, left), whole) < 0.1
    tile = rng.standard_normal((200, 200)).astype(np.float32)
    tiled = np.tile(tile, (4, 4))[:700, :700]
    assert _highest_repeat(tiled - _along_road(tiled, whole, left), whole) > 0.9


def test_summary_counts_what_fails() -> None:
    good = SceneChecks(
        gaps=[0.0, 0.01],
        feet=[[0.0, 0.01], [-0.02, 0.02]],
        overlaps=[],
        pierced=[],
        contact=[1.0],
        repeat=0.2,
        horizon=0.1,
    )
    bad = SceneChecks(
        gaps=[0.2, -0.1],
        feet=[[-0.2, 0.0], [0.0, 0.3]],
        overlaps=[[1, 2]],
        pierced=[2],
        contact=[0.2],
        repeat=0.9,
        horizon=0.1,
    )
    result = summary([good, bad, replace(good, repeat=None, horizon=None, contact=[])])
    assert (result.floating, result.sunk) == (1, 1)
    assert (result.feet_in_the_air, result.feet_in_the_ground) == (1, 1)
    assert (result.overlapping_pairs, result.pierced, result.repeating) == (1, 1, 1)
    assert result.contact_shadows == 0.5
    assert result.by_frame == FailingFrames(gaps=[1], feet=[1], overlaps=[1], pierced=[1])
