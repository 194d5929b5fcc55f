"""Bogus objects stand where planes stand; their density and depth are what was asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.bogus_object import BogusObject, resampled_scan
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.rig import SensorRig, kitti_rig


@pytest.fixture
def frame() -> SensorFrame:
    image = np.zeros((375, 1242, 3), np.uint8)
    return SensorFrame("0", kitti_rig().calibration, {2: image}, np.ones((5, 4), np.float32))


def surface(attack: BogusObject | LidarSpoofing, frame: SensorFrame, seed: int = 0) -> Floats:
    """Of the bogus points how far towards the patch, across and up from the road, (N, 3)."""
    tampered = attack.attack(frame, seed)
    assert tampered.points is not None
    pose = SensorRig(frame.calibration).velodyne_pose
    ahead, left, up = (tampered.frame.points[tampered.points, :3] @ pose[:3, :3].T).T
    bearing = tampered.settings["bearing"]
    cos, sin = np.cos(bearing), np.sin(bearing)
    return np.stack([ahead * cos + left * sin, left * cos - ahead * sin, up + pose[2, 3]], axis=1)


@pytest.mark.parametrize("points", [0, 3000])
def test_a_plane_has_no_depth_and_a_shell_has_its_own(frame: SensorFrame, points: int) -> None:
    exact = BogusObject(points=points, noise=0.0)
    at = exact.attack(frame).settings["distance"]
    plane, shell = (surface(replace(exact, form=form), frame) for form in ("plane", "shell"))
    assert np.ptp(plane[:, 0]) < 1e-3
    assert plane[:, 0].mean() == pytest.approx(at, abs=1e-3)
    assert np.ptp(shell[:, 0]) == pytest.approx(2.5, abs=0.02)
    for places in (plane, shell):
        assert np.ptp(places[:, 1]) == pytest.approx(2.5, abs=0.15)
        assert places[:, 2].min() > -1e-3
        assert places[:, 2].max() == pytest.approx(1.5, abs=0.1)
    # Every point of a shell lies on one of its faces.
    low, high = np.array([at, -1.25, 0.0]), np.array([at + 2.5, 1.25, 1.5])
    nearest = np.minimum(abs(shell - low), abs(shell - high)).min(axis=1)
    assert nearest.max() < 1e-3


def test_a_plane_of_the_lidars_own_beams_is_that_of_lidar_spoofing(frame: SensorFrame) -> None:
    own, usual = BogusObject(), LidarSpoofing()
    for seed in range(3):
        assert own.attack(frame, seed).settings == usual.attack(frame, seed).settings
        counts = [len(surface(attack, frame, seed)) for attack in (own, usual)]
        # One more or less column at an edge.
        assert counts[0] == pytest.approx(counts[1], abs=70)
    ranges = surface(own, frame)[:, 0] - own.attack(frame).settings["distance"]
    assert ranges.std() == pytest.approx(0.01, rel=0.2)


@pytest.mark.parametrize("form", ["plane", "shell"])
def test_density_is_what_was_asked_for_and_even(frame: SensorFrame, form: str) -> None:
    places = surface(BogusObject(form, 10_000), frame)
    assert len(places) == 10_000
    front = places[places[:, 0] < places[:, 0].min() + 0.1]
    areas = {"plane": 1.0, "shell": 3.75 / (2 * 3.75 + 2 * 3.75 + 6.25)}
    # A little of the sides and of the top is as near.
    assert len(front) == pytest.approx(10_000 * areas[form], rel=0.2)
    counts, _, _ = np.histogram2d(front[:, 1], front[:, 2], bins=5)
    assert counts.std() < 0.3 * counts.mean() + 50 * (form == "shell")


def test_the_same_seed_gives_the_same_and_own_points_stay(frame: SensorFrame) -> None:
    attack = BogusObject("shell", 500)
    first, again = attack.attack(frame, (1, 2)), attack.attack(frame, (1, 2))
    np.testing.assert_array_equal(first.frame.points, again.frame.points)
    np.testing.assert_array_equal(first.frame.points[:5], frame.points)
    assert (attack.attack(frame, (1, 3)).frame.points != first.frame.points).any()


def test_a_scan_gets_denser_and_sparser() -> None:
    points = np.random.default_rng(0).random((300, 4)).astype(np.float32)
    scan = ObjectScan(points, (1.5, 1.6, 4.0), (-10.0, 0.0))
    assert resampled_scan(scan, 0) is scan
    fewer, more = resampled_scan(scan, 100), resampled_scan(scan, 10_000)
    assert (len(fewer.points), len(more.points)) == (100, 10_000)
    assert {tuple(point) for point in fewer.points} <= {tuple(point) for point in points}
    assert len({tuple(point) for point in fewer.points}) == 100
    apart = np.linalg.norm(more.points[:, None, :3] - points[None, :, :3], axis=2).min(axis=1)
    assert apart.max() < 0.12
    assert ((more.points[:, 3] >= 0) & (more.points[:, 3] <= 1)).all()
    assert (scan.dimensions, scan.seen_from) == (more.dimensions, more.seen_from)


def test_what_cannot_be_is_refused() -> None:
    for wrong in ({"form": "ball"}, {"points": -1}, {"depth": 0.0}, {"noise": float("nan")}):
        with pytest.raises(ConfigurationError):
            BogusObject(**wrong)  # type: ignore[arg-type]
