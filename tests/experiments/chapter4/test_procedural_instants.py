"""Instants in memory are those that `avsec world make` writes; conditions scale one draw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED, ConnectedCondition
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.recordings import recorded_instants
from avsec_gym.world.assets import Assets
from avsec_gym.world.export.connected import Connection
from avsec_gym.world.export.connected_world import ConnectedWorld
from avsec_gym.world.export.data_set import make_data_set
from avsec_gym.world.export.recipe import Sensors
from avsec_gym.world.export.suites import suite_recipe

pytestmark = pytest.mark.slow
NOISY = ConnectedCondition(0.2, 0.1, 2)


@pytest.fixture(scope="module")
def place() -> ScannedPlace:
    return ScannedPlace(0, JUDGED, 0, vehicles=2)


def test_an_instant_is_that_of_the_data_set(place: ScannedPlace, tmp_path: Path) -> None:
    recipe = suite_recipe(
        "connected",
        1,
        6000,
        sensors=Sensors((2,), rig=resized_rig(kitti_rig(), 64)),
        vehicles=2,
        connection=Connection(clocks_apart=0.1),
        assets=Assets.JUDGE,
    )
    make_data_set(recipe, tmp_path / "world", workers=1)
    [written] = recorded_instants(ConnectedWorld(tmp_path / "world"))
    instant = place.instant(NOISY)
    assert (instant.id, instant.truth) == (written.id, written.truth)
    for mine, theirs in zip(instant.scans, written.scans, strict=True):
        np.testing.assert_array_equal(mine.points, theirs.points)
        np.testing.assert_allclose(mine.pose, theirs.pose, atol=1e-8)
        assert mine.time == theirs.time
        assert mine.sweep.speed == pytest.approx(theirs.sweep.speed, abs=1e-3)


def test_errors_of_poses_are_one_draw_scaled(place: ScannedPlace) -> None:
    exact, small, large = (
        place.instant(ConnectedCondition(noise, 0.0, 2)) for noise in (0.0, 0.2, 0.5)
    )
    for vehicle in range(2):
        true = exact.true_pose(vehicle)
        np.testing.assert_array_equal(exact.scans[vehicle].pose, true)
        off, farther = (each.scans[vehicle].pose[:2, 3] - true[:2, 3] for each in (small, large))
        assert np.hypot(*off) > 0
        np.testing.assert_allclose(farther, 2.5 * off, atol=1e-9)
        # What they scanned does not change with what they know of where they are.
        np.testing.assert_array_equal(small.scans[vehicle].points, exact.scans[vehicle].points)


def test_fewer_vehicles_are_the_first_ones(place: ScannedPlace) -> None:
    both, first = place.instant(NOISY), place.instant(ConnectedCondition(0.2, 0.1, 1))
    assert len(both.scans) == 2
    [only] = first.scans
    np.testing.assert_array_equal(only.points, both.scans[0].points)


def test_fitted_places_are_others(place: ScannedPlace) -> None:
    other = ScannedPlace(0, FITTED, 0, vehicles=2).instant(NOISY)
    assert other.truth != place.instant(NOISY).truth


def test_ghosts_stand_on_nothing_that_is_there(place: ScannedPlace) -> None:
    instant = place.instant(NOISY)
    assert instant.truth is not None
    boxes = [
        (*each.location[:2], *each.dimensions[2:0:-1], each.heading)
        for each in instant.truth.objects
    ]
    found = [PastedObject().attack(instant, seed) for seed in range(6)]
    ghosts = [seen_from_above(each.box) for each in found if each is not None]
    assert len(ghosts) > 3
    assert not rectangle_iou(np.concatenate(ghosts), np.array(boxes)).any()
