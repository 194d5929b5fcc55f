"""Recordings for the Rerun viewer show what is there, where it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.film_strip import ShownDrive
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.pipeline import run_episode
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import procedural_scenes
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.traffic import SentMessages
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.validation.repair.damage import Damage
from avsec_gym.validation.repair.damaged_scan import DamagedScan

rr = pytest.importorskip("rerun")

from avsec_gym.drawing import (  # noqa: E402
    rerun_alarm,
    rerun_drives,
    rerun_frame,
    rerun_instant,
    rerun_scene,
    rerun_stream,
)
from tests.drawing.test_film_picture import film  # noqa: E402
from tests.drawing.test_validation_picture import alarm, wall  # noqa: E402

CALIBRATION = kitti_rig().calibration


class Heard:
    """Keeps what is logged, and hands it on."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self.instants = 0
        self.of: dict[tuple[str, str], Any] = {}

    def set_time(self, *names: Any, **times: Any) -> None:
        self._stream.set_time(*names, **times)
        self.instants += 1

    def log(self, entity: str, what: Any, **how: Any) -> None:
        self.of[entity, type(what).__name__] = what
        self._stream.log(entity, what, **how)


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> list[Heard]:
    """What the writers log, beside the file that they write all the same."""
    every: list[Heard] = []

    @contextmanager
    def recording(path: Path, name: str) -> Iterator[Heard]:
        with rerun_stream.recording(path, name) as stream:
            every.append(Heard(stream))
            yield every[-1]

    for module in (rerun_alarm, rerun_drives, rerun_frame, rerun_instant, rerun_scene):
        monkeypatch.setattr(module, "recording", recording)
    return every


def values(component: Any) -> np.ndarray:
    """The numbers of a component, flat."""
    array = component.as_arrow_array()
    while hasattr(array, "flatten") and array.type.num_fields:
        array = array.flatten()
    return array.to_numpy(zero_copy_only=False)


def frame() -> SensorFrame:
    generator = np.random.default_rng(0)
    images = {camera: generator.integers(0, 255, (37, 124, 3), np.uint8) for camera in (2, 3)}
    scan = generator.uniform((5, -5, -2, 0), (40, 5, 1, 1), (50, 4)).astype(np.float32)
    return SensorFrame("000007", CALIBRATION, images, scan)


def boxes() -> Boxes3D:
    return Boxes3D(
        np.array([[2.0, 1.6, 15.0]]),
        np.array([[1.5, 1.7, 4.2]]),
        np.array([0.3]),
        np.array([0.8]),
        np.array(["Car"]),
    )


def test_a_frame_stands_in_space_as_its_calibration_says(
    heard: list[Heard], tmp_path: Path
) -> None:
    path = tmp_path / "deep" / "frame.rrd"
    rerun_frame.write_frame_recording(frame(), path, boxes(), boxes())
    assert path.read_bytes()[:3] == b"RRF"
    logged = heard[0].of
    np.testing.assert_array_equal(
        values(logged["lidar", "Points3D"].positions).reshape(-1, 3), frame().points[:, :3]
    )
    for camera in (2, 3):
        pose = logged[f"camera_{camera}", "Transform3D"]
        rotation = values(pose.mat3x3).reshape(3, 3).T  # Rerun keeps columns.
        place = values(pose.translation)
        pinhole = logged[f"camera_{camera}", "Pinhole"]
        matrix = values(pinhole.image_from_camera).reshape(3, 3).T
        # A point of the scan, by the recording's camera and by the calibration.
        points = frame().points[:, :3].astype(float)
        seen = (points - place) @ rotation @ matrix.T
        in_camera = transform_points(CALIBRATION.velodyne_to_camera, points)
        pixels, _ = project(CALIBRATION.projection(camera), in_camera)
        np.testing.assert_allclose(seen[:, :2] / seen[:, 2:], pixels, atol=0.05)
    strips = values(logged["believed", "LineStrips3D"].strips).reshape(-1, 3)
    centre = transform_points(CALIBRATION.camera_to_velodyne, boxes().location[0] - [0, 0.75, 0])
    np.testing.assert_allclose((strips.min(axis=0) + strips.max(axis=0)) / 2, centre, atol=0.05)
    labels = values(logged["believed", "LineStrips3D"].labels).tolist()
    assert [text for text in labels if text] == ["Car 0.80"]


def test_an_instant_shows_who_is_accused_of_what(heard: list[Heard], tmp_path: Path) -> None:
    pose = np.eye(4)
    pose[:3, 3] = 100.0, 20.0, 1.7
    scan = VehicleScan(np.ones((4, 4), np.float32), pose)
    regions = Regions(
        np.array([[0.0, 0, 0], [10, 0, 0], [20, 5, 0]]),
        np.tile([4.0, 2.0, 1.5], (3, 1)),
        np.zeros(3),
    )
    result = ConnectedResult(
        "1", "rays", regions, np.array([0.0, 5, 9]), np.array([0.0, 0.7, 0.9]), np.ones(3, bool),
        np.array([[0.0, 0], [0.4, 0.3], [0.1, 0.8]]), np.zeros((3, 2)),
        np.array([NO_ATTACK, CANNOT_TELL, 1]), SentMessages(2),
    )  # fmt: skip
    path = tmp_path / "instant.rrd"
    rerun_instant.write_instant_recording([scan, scan], path, result)
    assert path.stat().st_size > 1000
    logged = heard[0].of
    positions = values(logged["vehicle_1/scan", "Points3D"].positions).reshape(-1, 3)
    np.testing.assert_allclose(positions, np.tile([101.0, 21.0, 2.7], (4, 1)), atol=1e-4)
    alarms = logged["regions/alarm", "LineStrips3D"]
    words = [text for text in values(alarms.labels).tolist() if text]
    assert words == ["ghost, vehicle 1, P = 0.90", "ghost, cannot tell whose, P = 0.70"]
    quiet = values(logged["regions/quiet", "LineStrips3D"].strips).reshape(-1, 3)
    np.testing.assert_allclose(quiet.min(axis=0), [-2, -1, 0])
    np.testing.assert_allclose(quiet.max(axis=0), [2, 1, 1.5])


def test_an_alarm_shows_the_damage_and_says_what_is_attacked(
    heard: list[Heard], tmp_path: Path
) -> None:
    seen = wall()
    pixels = np.zeros(seen.image(1).shape[:2], bool)
    pixels[10:20, 30:50] = True
    points = np.arange(len(seen.points)) < 25
    damage: dict[Any, Damage] = {
        1: Damage(pixels=pixels),
        LIDAR: Damage(scan=DamagedScan(points, np.zeros(len(points), bool))),
    }
    path = tmp_path / "alarm.rrd"
    rerun_alarm.write_alarm_recording(alarm(seen), path, damage, "drives")
    assert path.read_bytes()[:3] == b"RRF"
    logged = heard[0].of
    bogus = values(logged["lidar/damage", "Points3D"].positions).reshape(-1, 3)
    np.testing.assert_array_equal(bogus, seen.points[:25, :3])
    assert ("camera_1/damage", "SegmentationImage") in logged
    assert ("camera_2/damage", "SegmentationImage") not in logged
    (text,) = values(logged["status", "TextDocument"].text).tolist()
    assert text.startswith("alarm\n- LiDAR: attacked, 25 points\n")
    assert "- camera 2: sound" in text
    assert text.endswith("what decides here was drives")


def test_a_scene_moves_as_it_was_planned(heard: list[Heard], tmp_path: Path) -> None:
    scene = procedural_scenes(10).scenes[3]
    planned = run_episode(scene, Intention.LEFT)
    assert planned.plan.trajectory is not None
    path = tmp_path / "scene.rrd"
    rerun_scene.write_scene_recording(planned, path)
    assert path.read_bytes()[:3] == b"RRF"
    assert heard[0].instants == len(planned.plan.trajectory)
    logged = heard[0].of
    way = values(logged["trajectory", "LineStrips3D"].strips).reshape(-1, 3)
    np.testing.assert_allclose(way[:, :2], planned.plan.trajectory[:, :2], atol=1e-5)
    # The car was logged last where it ended.
    car = values(logged["car", "LineStrips3D"].strips).reshape(-1, 3)[:4, :2]
    np.testing.assert_allclose(car.mean(axis=0), planned.plan.trajectory[-1, :2], atol=1e-4)
    (text,) = values(logged["outcome", "TextDocument"].text).tolist()
    assert text.startswith(f"{planned.record.outcome}: ")


def test_drives_are_on_one_timeline(heard: list[Heard], tmp_path: Path) -> None:
    path = tmp_path / "drive.rrd"
    rerun_drives.write_drives_recording([ShownDrive("truth", film(), "goal", False)], path)
    assert path.read_bytes()[:3] == b"RRF"
    assert heard[0].instants == 21
    goal = values(heard[0].of["truth/goal", "LineStrips2D"].strips).reshape(-1, 2)
    np.testing.assert_allclose(goal, [[40, -3], [40, 3]])
