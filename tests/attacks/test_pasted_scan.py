"""Pasted scans: the same object elsewhere, its scanned side to the LiDAR, its shadow behind it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.object_scan import (
    ObjectScan,
    cut_out,
    read_object_scan,
    write_object_scan,
)
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.attacks.pasted_scan import PastedScan, paste_scan
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import transform_points
from avsec_gym.kitti.sensor_files import write_points
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.registry import make
from avsec_gym.rig import kitti_rig

RIG = kitti_rig()
SENSOR = RIG.velodyne_pose[:3, 3]
CAR = Boxes3D([[-3.0, 1.6, 12.0]], [[1.5, 1.7, 4.0]], [-1.2], [1.0], ["Car"])


def frame_of(points: int = 3000) -> SensorFrame:
    random = np.random.default_rng(1)
    scan = random.uniform((-5, -12, -1.9, 0), (30, 12, 1.5, 1), (points, 4)).astype(np.float32)
    return SensorFrame("0", RIG.calibration, {}, scan)


def in_box(points: np.ndarray, pose: np.ndarray, bottom: float, grown: float = 0.0) -> np.ndarray:
    """Of points in the vehicle frame, by the sides of the car's box."""
    x, y, heading = pose
    along = (points[..., 0] - x) * np.cos(heading) + (points[..., 1] - y) * np.sin(heading)
    across = (points[..., 1] - y) * np.cos(heading) - (points[..., 0] - x) * np.sin(heading)
    up = points[..., 2] - bottom
    return (
        (np.abs(along) <= 2.0 + grown)
        & (np.abs(across) <= 0.85 + grown)
        & (up >= -grown)
        & (up <= 1.5 + grown)
    )


@pytest.mark.parametrize("down", [0.6, 1.6, 2.0])
def test_cut_out_is_what_the_box_holds(down: float) -> None:
    """Also of a car that stands lower than we do, or higher by more than half of the camera's."""
    frame = frame_of(9000)
    car = replace(CAR, location=[[-3.0, down, 12.0]])
    scan = cut_out(frame, car)
    places = transform_points(RIG.velodyne_pose, frame.points[:, :3])
    inside = in_box(places, car.poses[0], RIG.camera_height - down)
    assert len(scan.points) == inside.sum() > 10
    np.testing.assert_array_equal(scan.points[:, 3], frame.points[inside, 3])
    assert (np.abs(scan.points[:, :3]) <= [2.0, 0.85, 1.5]).all()
    assert np.hypot(*scan.seen_from) == pytest.approx(
        np.hypot(*(CAR.poses[0, :2] - SENSOR[:2])), rel=1e-6
    )


def test_pasted_where_it_was_it_is_what_it_was() -> None:
    frame = frame_of()
    scan = cut_out(frame, CAR)
    tampered = paste_scan(frame, scan, tuple(CAR.poses[0]), bottom=0.05)
    pasted = tampered.frame.points[tampered.points]
    inside = in_box(transform_points(RIG.velodyne_pose, frame.points[:, :3]), CAR.poses[0], 0.05)
    np.testing.assert_allclose(pasted, frame.points[inside], atol=1e-5)
    np.testing.assert_array_equal(tampered.frame.points[: len(frame.points)], frame.points)
    assert tampered.lost is None


def test_its_scanned_side_faces_the_lidar_at_every_bearing() -> None:
    frame = frame_of()
    scan = cut_out(frame, CAR)
    distance = float(np.hypot(*scan.seen_from))
    before = in_box(transform_points(RIG.velodyne_pose, frame.points[:, :3]), CAR.poses[0], 0.05)
    level = transform_points(RIG.velodyne_pose, frame.points[before, :3]) - SENSOR
    for bearing in (-2.5, 0.0, 1.3, None):
        tampered = PastedScan(scan, distance, bearing).attack(frame, 9)
        pasted = tampered.frame.points[tampered.points, :3]
        turned = transform_points(RIG.velodyne_pose, pasted) - SENSOR
        np.testing.assert_allclose(np.hypot(*turned.T[:2]), np.hypot(*level.T[:2]), atol=1e-4)
        turn = np.arctan2(turned[:, 1], turned[:, 0]) - np.arctan2(level[:, 1], level[:, 0])
        np.testing.assert_allclose(np.exp(1j * turn), np.exp(1j * turn[0]), atol=1e-4)


@pytest.mark.parametrize("pose", [(12.0, 3.0, 0.4), (9.0, -4.0, -2.0), (7.0, 0.0, 0.0)])
def test_its_shadow_is_what_it_hides(pose: tuple[float, float, float]) -> None:
    frame = frame_of()
    tampered = paste_scan(frame, cut_out(frame, CAR), pose, rays_lost=True)
    places = transform_points(RIG.velodyne_pose, frame.points[:, :3])
    along = np.linspace(0, 1, 1001)[:, None]
    entered = np.zeros(len(places), bool)
    maybe = np.zeros(len(places), bool)
    for number, place in enumerate(places):
        ray = SENSOR + along * (place - SENSOR)
        entered[number] = in_box(ray, np.array(pose), 0.0).any()
        maybe[number] = in_box(ray, np.array(pose), 0.0, grown=0.04).any()
    assert entered.sum() > 100
    assert tampered.lost is not None
    assert tampered.lost[entered].all(), "a beam that meets the box goes no farther"
    assert maybe[tampered.lost].all(), "and the others are left alone"
    kept = tampered.frame.points[~tampered.points]
    np.testing.assert_array_equal(kept, frame.points[~tampered.lost])


def test_places_are_everywhere_and_seeded() -> None:
    frame = frame_of(500)
    attack = PastedScan(ObjectScan(np.zeros((3, 4), np.float32), (1.5, 1.7, 4.0), (-9.0, 0.0)))
    assert isinstance(attack, OpticalAttack)
    settings = [attack.attack(frame, seed).settings for seed in range(60)]
    x, y = (np.array([each[key] for each in settings]) for key in "xy")
    distance = np.hypot(x - SENSOR[0], y - SENSOR[1])
    assert distance.min() >= 6
    assert distance.max() <= 40
    assert len(set(zip(x > 0, y > 0, strict=True))) == 4
    one, two = attack.attack(frame, 5), attack.attack(frame, 5)
    assert one.frame.points.tobytes() == two.frame.points.tobytes()
    assert one.attacked == attack.sensors == {"lidar"}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A car's scan."""
    write_object_scan(tmp_path / "car.npz", cut_out(frame_of(), CAR))
    return tmp_path / "car.npz"


def test_a_file_is_what_was_written_and_pasted_as_that(file: Path) -> None:
    frame, scan = frame_of(), cut_out(frame_of(), CAR)
    again = read_object_scan(file)
    np.testing.assert_array_equal(again.points, scan.points)
    assert again.points.dtype == np.float32
    assert (again.dimensions, again.seen_from) == (scan.dimensions, scan.seen_from)
    given = {"distance": [8.0, 9.0], "rays_lost": True}
    named = make("optical_attack", {"name": "pasted_scan", "scan": str(file), **given})
    tampered = named.attack(frame, 3)
    expected = PastedScan(scan, (8.0, 9.0), rays_lost=True).attack(frame, 3)
    np.testing.assert_array_equal(tampered.frame.points, expected.frame.points)
    assert tampered.settings == expected.settings
    with pytest.raises(DataError, match="exists"):
        write_object_scan(file, scan)


def test_other_files_are_refused_by_name_with_a_remedy(file: Path, tmp_path: Path) -> None:
    whole = file.read_bytes()
    write_points(tmp_path / "kitti.bin", frame_of().points)
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "damaged.npz").write_bytes(whole[:200] + bytes(50) + whole[250:])
    (tmp_path / "empty.npz").write_bytes(b"")
    np.save(tmp_path / "array.npy", np.zeros((3, 4)))
    np.savez(tmp_path / "points.npz", points=np.zeros((3, 4)))
    nothing = {"points": np.zeros((0, 4)), "dimensions": np.ones(3), "seen_from": np.ones(2)}
    np.savez(tmp_path / "nothing.npz", **nothing)
    np.savez(tmp_path / "flat.npz", **nothing | {"dimensions": 2.0})
    for path in [*sorted(tmp_path.iterdir()), tmp_path, tmp_path / "missing.npz"]:
        if path == file:
            continue
        remedy = "Name a regular file" if path.is_dir() else r"write_object_scan\(FILE, cut_out"
        with pytest.raises(DataError, match=remedy) as raised:
            PastedScan(path)
        assert str(raised.value).startswith(f"{path}: ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, r"'scan' \(its arguments: help\(avsec_gym.attacks.pasted_scan.PastedScan\)\)"),
        ({"scan": 3}, "scan of an object, or a file .* got 3"),
        ({"distance": "far"}, "distance takes a number"),
        ({"distance": [1, 2, 3]}, "distance takes two numbers"),
        ({"bearing": float("nan")}, "bearing takes a number"),
        ({"heading": "left"}, "heading takes a number"),
    ],
)
def test_wrong_arguments_by_name_are_refused(
    file: Path, arguments: dict[str, Any], message: str
) -> None:
    scan = {"scan": str(file)} if arguments else {}
    with pytest.raises(ConfigurationError, match=message):
        make("optical_attack", {"name": "pasted_scan", **scan, **arguments})


def test_validate_pastes_the_file(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same dots before both cameras and the LiDAR, but for the car ahead."""
    for number in range(4):
        dots = np.random.default_rng(number).integers(0, 256, (375, 1242, 3), np.uint8)
        images = {camera: np.roll(dots, -30 * (camera - 2), axis=1) for camera in (2, 3)}
        frame = SensorFrame(f"{number:06d}", RIG.calibration, images, frame_of().points)
        write_object_frame(tmp_path / "training", frame, CAR)
    attack = {"name": "pasted_scan", "scan": str(file), "distance": 10, "bearing": 0}
    command = ["validate", "--kitti", str(tmp_path), "--attack", json.dumps(attack), "--json"]
    assert run([*command, "--clean", "0.5", "--out", str(tmp_path / "out")]) == 0
    *rows, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert [row["truly_attacked"] for row in rows] == [["lidar"]] * 2
    assert last["summary"]["attacks_detected"]["of"] == 2


def test_what_cannot_be_is_refused() -> None:
    frame = frame_of()
    with pytest.raises(ConfigurationError, match="one object"):
        cut_out(frame, Boxes3D.empty())
    far = Boxes3D([[0.0, 1.6, 90.0]], [[1.5, 1.7, 4.0]], [0.0], [1.0], ["Car"])
    with pytest.raises(DataError, match="no point"):
        cut_out(frame, far)
    scan = cut_out(frame, CAR)
    with pytest.raises(ConfigurationError, match="LiDAR in it"):
        paste_scan(frame, scan, (0.0, 0.0, 0.0), bottom=1.0)
    with pytest.raises(ConfigurationError, match="finite"):
        paste_scan(frame, scan, (np.nan, 0.0, 0.0))
    with pytest.raises(ConfigurationError, match="distance"):
        PastedScan(scan, distance=(9.0, 3.0))
    for points, size in (((0, 4), 1.5), ((3, 3), 1.5), ((3, 4), 0.0)):
        with pytest.raises(ConfigurationError):
            ObjectScan(np.zeros(points, np.float32), (size, 1.7, 4.0), (-9.0, 0.0))
    with pytest.raises(ConfigurationError, match="finite"):
        ObjectScan(np.full((1, 4), np.nan, np.float32), (1.5, 1.7, 4.0), (-9.0, 0.0))
