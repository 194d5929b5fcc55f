"""Connected vehicles: one instant, several views, poses that bring them together."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.geometry import Floats, transform_points
from avsec_gym.kitti import KittiObject, read_labels
from avsec_gym.rig import SensorRig
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import Sensors, make_data_set, suite_recipe


def pose(folder: Path) -> Floats:
    return np.loadtxt(folder / "pose/000000.txt").reshape(3, 4)


@pytest.fixture(scope="module")
def connected(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    root = tmp_path_factory.mktemp("connected")
    sensors = Sensors((2,), rig=rig)
    make_data_set(suite_recipe("connected", 1, 1, sensors=sensors, vehicles=2), root, workers=1)
    return root


def test_labels_of_both_lie_where_the_actors_are(connected: Path, rig: SensorRig) -> None:
    actors = drive_scenes(1, 0, 1, 2)[0].instant.actors
    checked = 0
    for vehicle in range(2):
        training = connected / f"vehicle_{vehicle}/training"
        data = KittiObject(connected / f"vehicle_{vehicle}")
        boxes = read_labels(training / "label_2/000000.txt")
        scene = json.loads((training / "scene/000000.json").read_text())
        velodyne = transform_points(data.calibration("000000").camera_to_velodyne, boxes.location)
        places = transform_points(pose(training), velodyne)
        for place, each in zip(places, scene["objects"], strict=True):
            index = int(np.flatnonzero(actors.id == each["actor"])[0])
            assert place == pytest.approx([*actors.pose[index, :2], actors.z[index]], abs=0.01)
            checked += 1
    assert checked > 0


def test_scans_meet_on_the_ground(connected: Path) -> None:
    ground = drive_scenes(1, 0, 1, 2).world.site.ground
    for vehicle in range(2):
        root = connected / f"vehicle_{vehicle}"
        points = KittiObject(root).frame("000000").points[:, :3]
        world = transform_points(pose(root / "training"), points)
        above = world[:, 2] - ground.height(world[:, 0], world[:, 1])
        assert (np.abs(above) < 0.25).mean() > 0.2
        assert (above < -0.5).mean() < 0.02
