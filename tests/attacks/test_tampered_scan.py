"""Objects pasted into scans and taken out of them, against rays by hand."""

import numpy as np
import pytest

from avsec_gym.attacks.object_scan import ObjectScan, cut_out_points, object_pose
from avsec_gym.attacks.tampered_scan import inject_object, remove_object
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import transform_points

_HEIGHT = 1.7
_CAR = (1.5, 1.8, 4.0)


def _ground(step: float = 0.5) -> np.ndarray:
    side = np.arange(-30, 30, step)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    return np.c_[x, y, np.full(len(x), -_HEIGHT), np.full(len(x), 0.2)].astype(np.float32)


def _scan() -> ObjectScan:
    """The rear of a car, seen from behind."""
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(-8, 9) / 10, np.arange(2, 15) / 10))
    points = np.c_[np.full(len(y), -2.0), y, z, np.full(len(y), 0.5)].astype(np.float32)
    return ObjectScan(points, _CAR, (-10.0, 0.0))


def _ahead(distance: float) -> np.ndarray:
    return object_pose(np.array([distance, 0.0, 0.0]), -_HEIGHT)


def test_what_was_cut_out_is_put_back_in_its_place() -> None:
    tampered = inject_object(_ground(), _scan(), _ahead(10.0))
    assert tampered.bogus.sum() == len(_scan().points)
    assert not tampered.lost.any()
    assert tampered.points[tampered.bogus, 0] == pytest.approx(8.0)
    back = cut_out_points(tampered.points, np.linalg.inv(_ahead(10.0)), _CAR, feet=0.1)
    assert back is not None
    assert back.points == pytest.approx(_scan().points, abs=1e-5)
    assert back.seen_from == pytest.approx((-10.0, 0.0))
    assert cut_out_points(_ground(), np.linalg.inv(_ahead(10.0)), _CAR, feet=0.1) is None


def test_rays_behind_a_ghost_are_lost() -> None:
    ground = _ground()
    tampered = inject_object(ground, _scan(), _ahead(10.0), rays_lost=True)
    # Straight ahead, a ray just above the roof's far edge, 12 m away, meets the ground beyond.
    shadow_ends = 12.0 * _HEIGHT / (_HEIGHT - _CAR[0])
    straight = (np.abs(ground[:, 1]) < 1e-6) & (ground[:, 0] != 8.0)
    expected = (ground[:, 0] >= 8.0) & (ground[:, 0] < shadow_ends)
    assert (tampered.lost == expected)[straight].all()
    assert not tampered.lost[ground[:, 0] < 7.9].any()


def test_a_removed_object_is_gone_and_the_ground_at_its_feet_stays() -> None:
    ground, pose = _ground(), _ahead(10.0)
    clean = inject_object(ground, _scan(), pose).points
    lost = remove_object(clean, pose, _CAR)
    assert lost.points == pytest.approx(ground)
    assert lost.lost.sum() == len(_scan().points)


def test_pushed_rays_end_on_the_ground_behind_in_the_same_direction() -> None:
    pose = _ahead(10.0)
    pushed = remove_object(inject_object(_ground(), _scan(), pose).points, pose, _CAR, "pushed")
    places = pushed.points[pushed.bogus]
    assert len(places)
    assert places[:, 2] == pytest.approx(-_HEIGHT, abs=1e-5)
    assert (places[:, 0] > 8.0).all()
    assert (np.linalg.norm(places[:, :3], axis=1) <= 80.0).all()
    # The rear is at x = 8: each ray passed it at one of the scanned heights.
    at_rear = places[:, :3] * (8.0 / places[:, :1])
    own = transform_points(np.linalg.inv(pose), at_rear)
    scanned = _scan().points[:, :3]
    away = np.linalg.norm(own[:, None] - scanned[None], axis=2).min(axis=1)
    assert away.max() < 1e-4


def test_attacks_that_cannot_be_are_refused() -> None:
    with pytest.raises(ConfigurationError):
        inject_object(_ground(), _scan(), object_pose(np.array([0.0, 0.0, 0.0]), -1.0))
    with pytest.raises(ConfigurationError):
        remove_object(_ground(), _ahead(10.0), _CAR, "bent")  # type: ignore[arg-type]
