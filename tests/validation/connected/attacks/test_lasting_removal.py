"""A removal that lasts: the same object is gone at each instant, and nothing else is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import transform_points
from avsec_gym.validation.connected.attacks.attacked_instant import LastingAttack
from avsec_gym.validation.connected.attacks.lasting_removal import LastingRemoval
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.export import ConnectedInstant, SensorVehicle, WorldObject
from tests.validation.connected.conftest import pose_at, scan_of

_SPEED, _STEP = 8.0, 0.1


def _instant(frame: int) -> RecordedInstant:
    """A car that drives on, and one that stands behind the vehicle that looks."""
    places = ((14.0 + _SPEED * _STEP * frame, 3.0), (-12.0, 0.0))
    scans = (scan_of(pose_at(0, 0, 0), (*places[0], 0.0), (*places[1], 0.0)),)
    objects = tuple(
        WorldObject(actor, "Car", (x, y, 0.0), 0.0, (1.6, 2.0, 4.6), speed, 0.0, speed > 0, (99,))
        for actor, (x, y), speed in zip((7, 8), places, (_SPEED, 0.0), strict=True)
    )
    truth = ConnectedInstant(0, frame, (SensorVehicle(1, 0.0, 0.0, 0.0),), objects)
    return RecordedInstant(f"{frame:06d}", scans, truth)


def _points_on(instant: RecordedInstant, car: int) -> int:
    assert instant.truth is not None
    x, y, _ = instant.truth.objects[car].location
    points = transform_points(instant.scans[0].pose, instant.scans[0].points[:, :3].astype(float))
    near = np.abs(points - (x, y, 0.0)) < (2.2, 1.0, 2.0)
    return int((near.all(axis=1) & (points[:, 2] > 0.3)).sum())


@pytest.mark.parametrize("seed", range(6))
def test_the_same_object_is_gone_at_each_instant(seed: int) -> None:
    begun = LastingRemoval(RemovedObject(rays="lost")).begin(_instant(0), seed)
    assert begun is not None
    assert begun.begun.seen.actor is not None
    gone = (7, 8).index(begun.begun.seen.actor)
    for frame in range(5):
        clean = _instant(frame)
        attacked = begun.attack(clean, _STEP * frame)
        assert attacked is not None
        assert clean.truth is not None
        assert (attacked.kind, attacked.victim) == ("removal", 0)
        np.testing.assert_allclose(
            attacked.box.centre[0, :2], clean.truth.objects[gone].location[:2], atol=0.5
        )
        assert _points_on(clean, gone) > 50
        assert _points_on(attacked.instant, gone) == 0
        assert _points_on(attacked.instant, 1 - gone) == _points_on(clean, 1 - gone)


def test_it_ends_where_the_object_is_no_more() -> None:
    begun = LastingRemoval().begin(_instant(0), 1)
    assert begun is not None
    later = _instant(1)
    assert later.truth is not None
    assert begun.attack(replace(later, truth=replace(later.truth, objects=())), _STEP) is None


def test_without_labels_nothing_is_removed() -> None:
    unlabelled = replace(_instant(0), truth=None)
    assert isinstance(LastingRemoval(), LastingAttack)
    assert LastingRemoval().begin(unlabelled, 0) is None
    assert LastingRemoval().attack(unlabelled, 0) is None


def test_its_first_instant_is_that_of_a_single_removal() -> None:
    lasting, single = (
        LastingRemoval().attack(_instant(0), 3),
        RemovedObject().attack(_instant(0), 3),
    )
    assert lasting is not None
    assert single is not None
    np.testing.assert_array_equal(lasting.instant.scans[0].points, single.instant.scans[0].points)


def test_a_step_that_cannot_be_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="step"):
        LastingRemoval(step=0.0)
