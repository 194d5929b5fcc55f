from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.oxts import FIELDS, Oxts, read_oxts, write_oxts
from avsec_gym.kitti.oxts_poses import (
    GRAVITY,
    oxts_from_poses,
    poses_from_oxts,
)

from .conftest import curve, rotation

REAL = "kitti/raw/2011_09_26/2011_09_26_drive_0001_sync/oxts/data/0000000000.txt"


def test_files_come_back(tmp_path: Path) -> None:
    oxts = oxts_from_poses(curve(3))
    write_oxts(tmp_path, oxts, first=5)
    paths = sorted(tmp_path.iterdir())
    assert [path.name for path in paths] == [f"000000000{i}.txt" for i in (5, 6, 7)]
    np.testing.assert_array_equal(read_oxts(paths).rows, oxts.rows)
    np.testing.assert_array_equal(read_oxts(paths[1]).rows, oxts[1:2].rows)
    assert len(read_oxts([])) == 0
    assert paths[0].read_text().split()[-5:] == ["4", "10", "6", "6", "6"]
    with pytest.raises(DataError, match="exists"):
        write_oxts(tmp_path, oxts, first=5)


def test_a_real_file_comes_out_as_it_was(shared: Path, tmp_path: Path) -> None:
    oxts = read_oxts(shared / REAL)
    assert 48 < oxts.lat[0] < 50
    write_oxts(tmp_path, oxts)
    assert (tmp_path / "0000000000.txt").read_bytes() == (shared / REAL).read_bytes()


LINE = " ".join(str(i) for i in range(30))
BROKEN = {
    "empty": ("", ":1: The file has no line"),
    "cut off": (LINE[:20], ":1: A measurement has 30 numbers, this one 10"),
    "too many": (LINE + " 1", "this one 31"),
    "two lines": (LINE + "\n" + LINE + "\n", ":2: .*more than one"),
    "a word": (LINE.replace(" 5 ", " north "), "yaw is 'north'"),
    "NaN": (LINE.replace(" 8 ", " nan "), "vf is 'nan'"),
    "huge": (LINE.replace(" 2 ", " 1e30 "), "alt is '1e30'"),
    "beyond the pole": ("91" + LINE[1:], "lat is '91'"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_file_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "0000000003.txt"
    path.write_text(text)
    with pytest.raises(DataError, match=message) as caught:
        read_oxts(path)
    assert caught.value.path == str(path)
    assert caught.value.remedy


def test_arrays_are_checked() -> None:
    for rows in (np.zeros((2, 29)), np.zeros(30), np.full((1, 30), np.nan)):
        with pytest.raises(ConfigurationError):
            Oxts.from_rows(rows)
    pose = np.eye(4)[None]
    for poses in (np.eye(4), pose[:0], 2 * pose, pose * np.nan, -pose):
        with pytest.raises(ConfigurationError):
            oxts_from_poses(poses)
    for wrong in ({"origin": (90.0, 0.0, 0.0)}, {"period": 0.0}):
        with pytest.raises(ConfigurationError):
            oxts_from_poses(pose, **wrong)  # type: ignore[arg-type]


finite = st.floats(-1e3, 1e3)
angle = st.floats(-1.5, 1.5)


@given(
    st.lists(
        st.tuples(finite, finite, finite, st.floats(-3.1, 3.1), angle, st.floats(-3.1, 3.1)),
        min_size=1,
        max_size=6,
    ),
    st.floats(-70, 70),
)
def test_any_poses_come_back(states: list[tuple[float, ...]], latitude: float) -> None:
    poses = np.tile(np.eye(4), (len(states), 1, 1))
    for pose, (x, y, z, roll, pitch, yaw) in zip(poses, states, strict=True):
        pose[:3, :3], pose[:3, 3] = rotation(roll, pitch, yaw), (x, y, z)
    oxts = oxts_from_poses(poses, origin=(latitude, 8.4, 100.0))
    poses[:, :3, 3] -= poses[0, :3, 3].copy()
    np.testing.assert_allclose(poses_from_oxts(oxts), poses, rtol=0, atol=1e-5)


def test_a_car_on_a_circle() -> None:
    """Ten metres a second on a radius of 50 m to the left: 2 m/s^2, 0.2 rad/s."""
    time = 0.1 * np.arange(50)
    poses = np.tile(np.eye(4), (50, 1, 1))
    for pose, yaw in zip(poses, 0.2 * time, strict=True):
        pose[:3, :3] = rotation(0, 0, yaw)
        pose[:3, 3] = 50 * np.sin(yaw), -50 * np.cos(yaw), 0
    oxts = oxts_from_poses(poses)
    for name, value in (("vf", 10), ("vl", 0), ("vu", 0), ("wu", 0.2), ("wz", 0.2), ("wf", 0)):
        np.testing.assert_allclose(getattr(oxts, name), value, atol=2e-3)
    for name, value in (("af", 0), ("al", 2), ("ay", 2), ("au", GRAVITY), ("az", GRAVITY)):
        np.testing.assert_allclose(getattr(oxts, name)[3:-3], value, atol=2e-3)
    np.testing.assert_allclose(np.hypot(oxts.vn, oxts.ve), 10, atol=2e-3)
    assert oxts.ve[0] == pytest.approx(10, abs=0.01)
    assert oxts.vn[0] == pytest.approx(0, abs=0.01)


def test_integrating_the_speeds_leads_along_the_poses() -> None:
    """Trapezoid rule over 20 s of a winding, hilly road: within 5 cm, and 0.1 degrees."""
    poses = curve(200)
    oxts = oxts_from_poses(poses)

    def integrate(rate: np.ndarray) -> np.ndarray:
        return np.concatenate([[0], np.cumsum(0.05 * (rate[:-1] + rate[1:]))])

    # Rates of the Euler angles from the level ones (the yaw rate of a tilted unit is not wu alone).
    pitch = oxts.pitch
    yaw_rate = oxts.wu + np.tan(pitch) * oxts.wf
    yaw = oxts.yaw[0] + integrate(yaw_rate)
    np.testing.assert_allclose(np.unwrap(oxts.yaw), yaw, rtol=0, atol=2e-3)
    east = integrate(oxts.vf * np.cos(yaw) - oxts.vl * np.sin(yaw))
    north = integrate(oxts.vf * np.sin(yaw) + oxts.vl * np.cos(yaw))
    way = np.stack([east, north, integrate(oxts.vu)], axis=1)
    expected = poses[:, :3, 3] - poses[0, :3, 3]
    np.testing.assert_allclose(way, expected, rtol=0, atol=0.05)


def test_the_unit_and_the_level_axes_agree_as_in_a_real_measurement(shared: Path) -> None:
    """What KITTI calls forward, left, up is Ry(pitch) Rx(roll) of what it calls x, y, z."""
    oxts = read_oxts(shared / REAL)
    to_level = rotation(oxts.roll[0], oxts.pitch[0], 0.0)

    def of(*names: str) -> np.ndarray:
        return np.array([getattr(oxts, name)[0] for name in names])

    np.testing.assert_allclose(to_level @ of("wx", "wy", "wz"), of("wf", "wl", "wu"), atol=1e-3)
    np.testing.assert_allclose(to_level @ of("ax", "ay", "az"), of("af", "al", "au"), atol=0.02)
    forward = np.cos(oxts.yaw) * oxts.ve + np.sin(oxts.yaw) * oxts.vn
    np.testing.assert_allclose(forward, oxts.vf, atol=0.01)

    ours = oxts_from_poses(curve(30))
    for i in (0, 7, 29):
        to_level = rotation(ours.roll[i], ours.pitch[i], 0.0)
        for names in (("wx", "wf"), ("ax", "af")):
            first, second = (FIELDS.index(name) for name in names)
            row = ours.rows[i]
            np.testing.assert_allclose(to_level @ row[first:][:3], row[second:][:3], atol=1e-9)
