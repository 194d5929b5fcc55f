"""Posed scenes of layouts and labels, and their rendered images, scans and labels."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import ego_to_camera
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.labels import read_labels
from avsec_gym.rig import SensorRig, camera_rig
from avsec_gym.road_type import RoadType
from avsec_gym.world.actors import Instant
from avsec_gym.world.capture import Capture, render
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.posed_scenes import PosedScene, posed_scene_of_labels, posed_scene_of_layout
from avsec_gym.world.rendering.lidar import Lidar
from avsec_gym.world.rendering.ray_scene import RayScene
from avsec_gym.world.site import Style

LIDAR = Lidar(columns=300)


def small_rig(*right: float) -> SensorRig:
    """KITTI's view in an eighth of its pixels."""
    return camera_rig(right, focal_length=92.9, centre=(78.2, 21.8), size=(160, 48))


@pytest.fixture(scope="module")
def scenes() -> list[PosedScene]:
    return [
        posed_scene_of_layout(generate_layout(index), small_rig(0.0, 0.54)) for index in (1, 2, 11)
    ]


@pytest.fixture(scope="module")
def captures(scenes: list[PosedScene]) -> list[Capture]:
    return [render(posed, cameras=(0, 1), lidar=LIDAR) for posed in scenes]


def digest(capture: Capture) -> str:
    boxes = capture.labels.boxes
    code = hashlib.sha256("".join(boxes.category).encode())
    arrays = [*capture.images.values(), *capture.geometry, capture.disparity]
    arrays += [boxes.location, boxes.rotation_y, boxes.box2d, boxes.truncation, boxes.occlusion]
    if capture.scan is not None:
        arrays += [capture.scan.points, capture.scan.object_id]
    for array in arrays:
        code.update(np.ascontiguousarray(array).tobytes())
    return code.hexdigest()


def test_one_layout_is_one_scene(scenes: list[PosedScene]) -> None:
    one, two = scenes[0], posed_scene_of_layout(generate_layout(1), small_rig(0.0))
    np.testing.assert_array_equal(one.built.light.panorama, two.built.light.panorama)
    first, second = (posed.built.scene(posed.instant.actors, 0) for posed in (one, two))
    for name in ("vertices", "normals", "uv", "faces", "material", "object_id", "surface"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)
    for name, table in first.materials._asdict().items():
        np.testing.assert_array_equal(table, getattr(second.materials, name), err_msg=name)


def test_layouts_differ_in_place_light_and_looks(scenes: list[PosedScene]) -> None:
    lights = {(posed.built.light.azimuth, posed.built.light.elevation) for posed in scenes}
    assert len(lights) == len(scenes)
    assert len({posed.site.seed for posed in scenes}) == len(scenes)


def test_a_highway_layout_is_a_highway_and_a_street_is_none() -> None:
    kinds = {
        kind: posed_scene_of_layout(generate_layout(3, kind), small_rig(0.0)).site
        for kind in RoadType
    }
    assert kinds[RoadType.HIGHWAY].style is Style.HIGHWAY
    assert all(site.road_type is kind for kind, site in kinds.items())


@pytest.fixture(scope="module")
def deserted(scenes: list[PosedScene]) -> list[RayScene]:
    """The built scenes without their actors."""
    return [posed.built.scene(posed.instant.actors.pick(np.array([0])), 0) for posed in scenes]


def test_all_actors_stand_on_the_ground(scenes: list[PosedScene], deserted: list[RayScene]) -> None:
    """A plumb line from half a metre above each foot meets road, pavement or land there."""
    for posed, scene in zip(scenes, deserted, strict=True):
        actors = posed.instant.actors
        near = np.flatnonzero(np.abs(actors.pose[:, 0]) < 80)
        foot = np.column_stack([actors.pose[near, :2], actors.z[near]])
        origins = np.ascontiguousarray(foot + np.array([0, 0, 0.5]), np.float32)
        down = np.tile(np.array([0, 0, -1], np.float32), (len(near), 1))
        gap = scene.hits(origins, down).distance - 0.5
        np.testing.assert_allclose(gap, 0.0, atol=0.03)


def test_no_scenery_reaches_into_an_actor(
    scenes: list[PosedScene], deserted: list[RayScene]
) -> None:
    """Nothing of a house, plant or lamp reaches into an actor's box."""
    for posed, scene in zip(scenes, deserted, strict=True):
        actors = posed.instant.actors
        corners = scene.vertices[scene.faces]
        spots = np.concatenate([corners.reshape(-1, 3), corners.mean(axis=1)])
        spots = spots[(np.abs(spots[:, :2]) < 100).all(axis=1) & (spots[:, 2] < 4.0)]
        for index in range(1, len(actors)):
            x, y, heading = actors.pose[index]
            height, width, length = actors.dimensions[index]
            away = spots[np.abs(spots[:, :2] - (x, y)).max(axis=1) < length] - (
                x,
                y,
                actors.z[index],
            )
            along = away[:, 0] * np.cos(heading) + away[:, 1] * np.sin(heading)
            across = away[:, 1] * np.cos(heading) - away[:, 0] * np.sin(heading)
            inside = (np.abs(along) < 0.45 * length) & (np.abs(across) < 0.45 * width)
            inside &= (away[:, 2] > 0.2) & (away[:, 2] < 0.95 * height)
            assert not inside.any(), (posed.site.style, index)


def test_a_capture_holds_what_it_should(scenes: list[PosedScene], captures: list[Capture]) -> None:
    for posed, capture in zip(scenes, captures, strict=True):
        assert set(capture.images) == {0, 1}
        for image in capture.images.values():
            assert image.shape == (48, 160, 3)
            assert image.dtype == np.uint8
            assert image.std() > 15
        assert np.abs(capture.images[0].astype(float) - capture.images[1]).mean() > 1
        assert capture.partner == 1
        depth = capture.geometry.depth
        known = np.isfinite(depth)
        np.testing.assert_allclose(capture.disparity[known], 92.9 * 0.54 / depth[known], rtol=1e-4)
        assert np.isnan(capture.disparity[~known]).all()
        assert len(capture.labels.boxes) == len(capture.labels.actor)
        assert capture.labels.actor.min(initial=1) > 0
        assert len(posed.instant.actors) > len(capture.labels.boxes)


def test_laser_points_of_an_actor_lie_in_its_box(
    scenes: list[PosedScene], captures: list[Capture]
) -> None:
    count = 0
    for posed, capture in zip(scenes, captures, strict=True):
        assert capture.scan is not None
        actors, pose = posed.instant.actors, posed.rig.velodyne_pose
        world = capture.scan.points[:, :3] @ pose[:3, :3].T + pose[:3, 3]
        for index in np.unique(capture.scan.object_id):
            if index < 0:
                continue
            x, y, heading = actors.pose[index]
            away = world[capture.scan.object_id == index] - [x, y, actors.z[index]]
            cos, sin = np.cos(heading), np.sin(heading)
            along, across = away[:, 0] * cos + away[:, 1] * sin, away[:, 1] * cos - away[:, 0] * sin
            height, width, length = actors.dimensions[index]
            assert (np.abs(along) < 0.5 * length + 0.06).all()
            assert (np.abs(across) < 0.5 * width + 0.06).all()
            assert ((away[:, 2] > -0.06) & (away[:, 2] < height + 0.06)).all()
            count += len(away)
    assert count > 200


def test_sensors_that_are_not_asked_for_are_not_used(
    scenes: list[PosedScene], captures: list[Capture]
) -> None:
    bare = render(scenes[0], cameras=(), lidar=None)
    assert bare.images == {}
    assert bare.scan is None
    np.testing.assert_array_equal(bare.geometry.depth, captures[0].geometry.depth)
    np.testing.assert_array_equal(bare.labels.boxes.box2d, captures[0].labels.boxes.box2d)
    only_right = render(scenes[0], cameras=(1,), lidar=None)
    np.testing.assert_array_equal(only_right.images[1], captures[0].images[1])


@pytest.mark.slow
def test_another_process_renders_the_same_image(captures: list[Capture]) -> None:
    """Whatever the seed of Python's hashes."""
    program = (
        "import importlib.util, sys\n"
        f"spec = importlib.util.spec_from_file_location('here', {__file__!r})\n"
        "here = importlib.util.module_from_spec(spec)\n"
        "spec.loader.exec_module(here)\n"
        "posed = here.posed_scene_of_layout(here.generate_layout(1), here.small_rig(0.0, 0.54))\n"
        "print(here.digest(here.render(posed, cameras=(0, 1), lidar=here.LIDAR)))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "77"},
    )
    assert run.stdout.strip() == digest(captures[0])


@pytest.mark.parametrize(("count", "reference", "partner"), [(1, 0, None), (2, 0, 1), (6, 2, 3)])
def test_any_number_of_cameras(
    scenes: list[PosedScene], count: int, reference: int, partner: int | None
) -> None:
    rig = small_rig(*(0.3 * np.arange(count)))
    capture = render(replace(scenes[1], rig=rig), cameras=rig.cameras, lidar=None)
    assert set(capture.images) == set(range(count))
    assert capture.partner == partner
    if partner is None:
        assert np.isnan(capture.disparity).all()
    else:
        known = np.isfinite(capture.geometry.depth)
        np.testing.assert_allclose(
            capture.disparity[known], 92.9 * 0.3 / capture.geometry.depth[known], rtol=1e-4
        )
    assert len({image.tobytes() for image in capture.images.values()}) == count
    if count == 6:
        alone = render(replace(scenes[1], rig=rig), cameras=(), lidar=None)
        np.testing.assert_array_equal(alone.geometry.depth, capture.geometry.depth)
        assert reference == 2


def labelled(*rows: tuple) -> Boxes3D:
    """Boxes from (category, x ahead, y left, heading, bottom, dimensions)."""
    poses = np.array([row[1:4] for row in rows], float)
    location, rotation_y = ego_to_camera(poses, 1.65 - np.array([row[4] for row in rows]))
    return Boxes3D(
        location, np.array([row[5] for row in rows], float), rotation_y, np.ones(len(rows)),
        np.array([row[0] for row in rows]), occlusion=np.zeros(len(rows)),
    )  # fmt: skip


def test_a_twin_keeps_every_labelled_pose_and_size() -> None:
    boxes = labelled(
        ("Car", 12.0, 3.1, np.pi, -0.1, (1.5, 1.7, 4.1)),
        ("Pedestrian", 9.0, -3.4, 0.5, 0.2, (1.8, 0.6, 0.9)),
        ("Cyclist", 16.0, -1.2, 0.1, 0.0, (1.7, 0.6, 1.8)),
        ("Truck", 35.0, 0.3, 0.0, 0.4, (3.2, 2.5, 8.7)),
    )
    posed = posed_scene_of_labels(boxes, small_rig(0.0, 0.54), seed=4)
    actors = posed.instant.actors
    np.testing.assert_allclose(actors.pose[1:5], boxes.poses, atol=1e-12)
    np.testing.assert_allclose(actors.z[1:5], 1.65 - boxes.location[:, 1], atol=1e-12)
    np.testing.assert_array_equal(actors.dimensions[1:5], boxes.dimensions)
    found = render(posed, cameras=(), lidar=None).labels
    assert set(found.actor) >= {1, 2, 3}
    assert len(found.actor) == len(set(found.actor))
    for row, actor in enumerate(found.actor):
        if actor > 4:
            continue
        np.testing.assert_allclose(found.boxes.location[row], boxes.location[actor - 1], atol=1e-9)
        assert found.boxes.category[row] == boxes.category[actor - 1]
        turn = found.boxes.rotation_y[row] - boxes.rotation_y[actor - 1]
        assert np.exp(1j * turn) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.slow
def test_a_twin_of_a_real_frame_shows_its_cars(shared: Path) -> None:
    training = shared / "kitti/object/training"
    real = read_labels(training / "label_2/000107.txt")
    rig = SensorRig(read_calibration(training / "calib/000107.txt"))
    found = render(posed_scene_of_labels(real, rig, seed=0), cameras=(), lidar=None).labels
    for category, box2d, occlusion in zip(real.category, real.box2d, real.occlusion, strict=True):
        if occlusion > 0 or box2d[3] - box2d[1] < 25:
            continue
        same = found.boxes[found.boxes.category == category].box2d
        low, high = np.maximum(same[:, :2], box2d[:2]), np.minimum(same[:, 2:], box2d[2:])
        common = np.prod(np.clip(high - low, 0, None), axis=1)
        union = np.prod(same[:, 2:] - same[:, :2], axis=1) + np.prod(box2d[2:] - box2d[:2]) - common
        assert (common / union).max() > 0.7


@pytest.mark.parametrize("style", list(Style))
def test_a_frame_without_objects_has_a_place_too(style: Style) -> None:
    posed = posed_scene_of_labels(Boxes3D.empty(), small_rig(0.0), seed=1, style=style)
    capture = render(posed, cameras=(), lidar=None)
    assert posed.site.style is style
    assert len(capture.labels.boxes) == 0
    assert np.isfinite(capture.geometry.depth[30:]).all()
    assert np.isinf(capture.geometry.depth).any()


def test_two_sensor_vehicles_see_each_other() -> None:
    """The one that drives towards us is 15 m ahead and 3 m to the left, and so are we to it."""
    boxes = labelled(("Car", 15.0, 3.0, np.pi, 0.0, (1.5, 1.8, 4.7)))
    posed = posed_scene_of_labels(boxes, small_rig(0.0, 0.54), seed=2)
    opposite = np.eye(4)
    opposite[:2, :2], opposite[:2, 3] = [[-1, 0], [0, -1]], [15.0, 3.0]
    posed = replace(
        posed,
        instant=Instant(0.0, posed.instant.actors, (0, 1)),
        vehicle_to_world=np.stack([np.eye(4), opposite]),
    )
    one, two = (render(posed, ego=ego, cameras=(0,), lidar=LIDAR) for ego in (0, 1))
    for capture, own, other in ((one, 0, 1), (two, 1, 0)):
        assert own not in capture.labels.actor
        row = capture.labels.actor.tolist().index(other)
        np.testing.assert_allclose(
            capture.labels.boxes.location[row], [-3.0, 1.65, 15.0], atol=1e-6
        )
        assert capture.scan is not None
        assert own not in capture.scan.object_id
        assert other in capture.scan.object_id
    assert not np.array_equal(one.images[0], two.images[0])
