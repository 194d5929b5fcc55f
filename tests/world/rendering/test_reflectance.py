"""Reflectances, the lasers' own gains, and the ground's unevenness."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.world.rendering.lasers import draw_lasers
from avsec_gym.world.rendering.lidar import Lidar
from avsec_gym.world.rendering.reflectance import graded_reflectance
from avsec_gym.world.rendering.relief import draw_relief, raise_ground
from avsec_gym.world.section import Surface

STEP = np.radians(0.09)


def graded(reflectance: float, distance: float, *, mirror=0.0, painted=False, gain=1.0, floor=0.1):
    count = 4000
    return graded_reflectance(
        np.full(count, reflectance, np.float32),
        np.ones(count, np.float32),
        np.full(count, mirror, np.float32),
        np.full(count, painted),
        np.full(count, distance, np.float32),
        np.full(count, gain),
        floor,
        np.random.default_rng(0),
    )


def dark(values: np.ndarray) -> float:
    return float((values == 0).mean())


def test_reflectances_are_lost_far_away_on_paint_and_by_weak_lasers() -> None:
    assert dark(graded(0.3, 10.0)) < 0.05
    assert 0.3 < dark(graded(0.3, 45.0)) < 0.7
    assert dark(graded(0.3, 75.0)) > 0.9
    assert 0.5 < dark(graded(0.4, 10.0, mirror=0.05, painted=True)) < 0.8
    assert dark(graded(0.9, 10.0, mirror=0.05, painted=True)) < 0.05  # a number plate
    assert dark(graded(0.15, 10.0, gain=0.55, floor=0.2)) > 0.15
    assert dark(graded(0.15, 10.0, gain=1.0, floor=0.2)) < 0.05


def test_devices_differ_around_a_common_nominal() -> None:
    devices = [draw_lasers(seed, STEP) for seed in range(40)]
    elevation = np.degrees([each.elevation for each in devices])
    nominal = elevation.mean(axis=0)
    assert (np.diff(nominal) < 0).all()
    assert (nominal[0], nominal[-1]) == pytest.approx((1.94, -25.0), abs=0.03)
    spread = elevation.std(axis=0)
    assert spread[:32].mean() == pytest.approx(0.03, rel=0.15)
    assert spread[32:].mean() == pytest.approx(0.045, rel=0.15)
    # The same lasers are weak in most devices, as in all scans of KITTI's car.
    weak = np.array([each.gain < 0.8 for each in devices])
    common = weak.mean(axis=0)
    assert ((common > 0.7) | (common < 0.3)).all()
    assert 6 <= (common > 0.7).sum() <= 20
    assert len({each.floor for each in devices}) == 40
    np.testing.assert_array_equal(draw_lasers(7, STEP).gain, draw_lasers(7, STEP).gain)
    assert Lidar().lasers.floor == Lidar(seed=64).lasers.floor


def test_a_centimetre_of_height_shortens_grazing_pulses_most() -> None:
    relief = np.full((256, 256), 0.01, np.float32)
    cosine = np.array([1.0, 0.1, 0.1, 0.1], np.float32)
    distance = np.full(4, 10.0, np.float32)
    kind = np.array([Surface.ROAD, Surface.ROAD, Surface.BUILDING, Surface.TERRAIN], np.uint8)
    rays = np.zeros((2, 4, 3), np.float32)
    chance = np.zeros(4, np.float32)
    raise_ground(distance, rays[0], rays[1], cosine, kind, relief, chance)
    np.testing.assert_allclose(distance, [9.99, 9.9, 10.0, 9.7], atol=1e-4)


def test_the_relief_of_a_place_is_its_own_and_low() -> None:
    one = draw_relief(1)
    assert one.std() == pytest.approx(0.011, rel=0.01)
    assert np.abs(one).max() < 0.06
    assert not np.array_equal(one, draw_relief(2))
    # Neighbours are half a metre apart: no steps.
    assert np.abs(np.diff(one, axis=0)).max() < 0.015
