"""Oracles are blind where light is, believe bogus points, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.defence.oracles import LidarOracle, StereoOracle
from avsec_gym.experiments.chapter3.recordings import RIG
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import ego_to_camera, project

EGO_CARS = np.array([[15.0, 4.0, 0.0], [15.0, -4.0, 0.0]])


@pytest.fixture(scope="module")
def clean() -> SensorFrame:
    rng = np.random.default_rng(0)
    images = {camera: rng.integers(60, 120, (375, 1242, 3), np.uint8) for camera in range(4)}
    points = rng.uniform(10, 40, (500, 4)).astype(np.float32)
    return SensorFrame("1", RIG.calibration, images, points)


@pytest.fixture(scope="module")
def truth() -> Boxes3D:
    location, rotation_y = ego_to_camera(EGO_CARS, 1.65)
    size = np.tile([1.5, 1.6, 4.0], (2, 1))
    return Boxes3D(location, size, rotation_y, np.ones(2), np.array(["Car", "Car"]))


def spot(clean: SensorFrame, truth: Boxes3D, camera: int, row: int) -> tuple[float, float]:
    middle = truth.location[row] - [0, 0.75, 0]
    return tuple(project(clean.calibration.projection(camera), middle)[0].tolist())


@pytest.mark.parametrize("camera", [2, 3])
def test_what_light_hides_in_one_image_is_not_seen(
    clean: SensorFrame, truth: Boxes3D, camera: int
) -> None:
    oracle = StereoOracle(clean, truth)
    assert len(oracle.detect(clean)) == 2
    light = Facula(camera, 187.0, spot(clean, truth, camera, 0))
    seen = oracle.detect(light.attack(clean).frame)
    assert seen.poses[:, 1].round() == [-4.0]
    # A tenth of the light hides nothing.
    assert len(oracle.detect(replace(light, strength=25.0).attack(clean).frame)) == 2
    elsewhere = Facula(1, 375.0, spot(clean, truth, 1, 0)).attack(clean).frame
    assert len(oracle.detect(elsewhere)) == 2


def test_through_another_pair_it_sees_again(clean: SensorFrame, truth: Boxes3D) -> None:
    lit = Facula(3, 187.0, spot(clean, truth, 3, 0)).attack(clean).frame
    projections = np.zeros_like(clean.calibration.projections)
    projections[2], projections[3] = clean.calibration.projections[[2, 1]]
    calibration = replace(clean.calibration, projections=projections)
    other = SensorFrame("1", calibration, {2: lit.image(2), 3: lit.image(1)})
    assert len(StereoOracle(clean, truth).detect(other)) == 2


def test_bogus_points_are_an_obstacle_until_they_are_taken_out(
    clean: SensorFrame, truth: Boxes3D
) -> None:
    tampered = LidarSpoofing(distance=8.0, bearing=0.0).attack(clean)
    bogus = tampered.frame.points[tampered.points]
    oracle = LidarOracle(bogus, truth)
    seen = oracle.detect(tampered.frame)
    assert seen.category.tolist() == ["Car", "Car", "Misc"]
    x, y, heading = seen.poses[2]
    # The LiDAR stands 0.27 m behind the cameras.
    assert (x, y, heading) == pytest.approx((7.73, 0.0, 0.0), abs=0.1)
    assert seen.dimensions[2] == pytest.approx([1.5, 2.5, 0.1], abs=0.1)
    assert len(oracle.detect(clean)) == 2
    repaired = tampered.frame.with_points(np.concatenate([clean.points, bogus[:40]]))
    assert len(oracle.detect(repaired)) == 2


def test_a_strip_on_the_road_is_driven_over(clean: SensorFrame, truth: Boxes3D) -> None:
    tampered = LidarSpoofing(distance=8.0, bearing=0.0).attack(clean)
    bogus = tampered.frame.points[tampered.points]
    height = bogus[:, 2] - bogus[:, 2].min()
    oracle = LidarOracle(bogus, truth)
    for kept, seen in ((height < 0.28, 2), (height < 0.6, 3), (height > 0.4, 3)):
        assert kept.sum() > 150
        repaired = tampered.frame.with_points(np.concatenate([clean.points, bogus[kept]]))
        assert len(oracle.detect(repaired)) == seen
