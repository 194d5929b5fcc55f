from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.geometry import box_corners, project
from avsec_gym.rig import camera_rig
from avsec_gym.world.actors import Actors
from avsec_gym.world.capture import pinhole
from avsec_gym.world.labels import (
    BARELY_VISIBLE,
    FULLY_VISIBLE,
    PARTLY_VISIBLE,
    FrameLabels,
    boxes_in_camera,
    dont_care_boxes,
    label_frame,
)
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.rendering.silhouettes import silhouettes
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box

pytestmark = pytest.mark.usefixtures("little_textures")

RIG = camera_rig([0.0, 0.54], focal_length=300.0, centre=(239.5, 71.5), size=(480, 144))
CAR = (1.5, 1.8, 4.2)


def people(*rows, z: float = 0.0) -> Actors:
    """Actors from (x, y, heading, category, dimensions, moving)."""
    count = len(rows)
    return Actors(
        id=np.arange(count),
        category=np.array([row[3] for row in rows]),
        dimensions=np.array([row[4] for row in rows], float),
        pose=np.array([row[:3] for row in rows], float),
        z=np.full(count, z),
        speed=np.array([5.0 * row[5] for row in rows]),
        moving=np.array([row[5] for row in rows]),
        appearance=np.full(count, 996),
        phase=np.zeros(count),
    )


def label(actors: Actors, *scenery, own: int | None = None, pose=None) -> FrameLabels:
    """Labels of actors that are boxes, behind scenery."""
    pose = np.eye(4) if pose is None else pose
    things = [Thing(mesh, Surface.BUILDING) for mesh in scenery]
    for i in range(len(actors)):
        if i != own:
            height, width, length = actors.dimensions[i]
            x, y, yaw = actors.pose[i]
            mesh = box(length, width, height).placed(x, y, actors.z[i], yaw)
            things.append(Thing(mesh, Surface.VEHICLE, i))
    scene, camera = RayScene(things), pinhole(RIG, 0, pose)
    geometry = Renderer(scene, Light()).geometry(camera)
    alone = silhouettes(scene, camera, len(actors))
    return label_frame(actors, RIG, pose, geometry, alone, own)


def projected(labels: FrameLabels) -> np.ndarray:
    """Bounds of the labelled 3D boxes' corners in the image, shape (N, 4)."""
    boxes = labels.boxes
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    pixels, depth = project(RIG.calibration.projection(0), corners)
    assert (depth > 0).all()
    bounds = np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)
    return np.clip(bounds, 0.0, [479, 143, 479, 143])


def test_boxes_in_space_and_in_the_image_belong_together() -> None:
    """Also on a slope, for a vehicle that stands anywhere, turned and tilted."""
    actors = people(
        (15.0, 2.0, 0.3, "Car", CAR, True),
        (24.0, -14.0, -2.0, "Pedestrian", (1.8, 0.6, 0.7), False),
        (12.0, -3.5, 1.4, "Cyclist", (1.7, 0.6, 1.8), True),
        (40.0, 16.0, 3.0, "Van", (2.2, 1.9, 5.0), False),
    )
    found = label(actors)
    assert found.actor.tolist() == [2, 0, 1, 3]  # from near to far
    assert found.boxes.category.tolist() == ["Cyclist", "Car", "Pedestrian", "Van"]
    assert found.boxes.moving is not None
    assert found.boxes.moving.tolist() == [True, True, False, False]
    np.testing.assert_allclose(found.boxes.box2d, projected(found), atol=0.05)
    np.testing.assert_allclose(found.boxes.dimensions, actors.dimensions[found.actor])
    np.testing.assert_allclose(found.boxes.poses[:, :2], actors.pose[found.actor, :2], atol=1e-9)
    np.testing.assert_allclose(found.boxes.location[:, 1], 1.65, atol=1e-9)
    turn = np.exp(1j * (found.boxes.poses[:, 2] - actors.pose[found.actor, 2]))
    np.testing.assert_allclose(turn, 1.0, atol=1e-9)
    np.testing.assert_array_equal(found.boxes.truncation, 0.0)
    np.testing.assert_array_equal(found.boxes.occlusion, 0.0)
    pose = np.eye(4)
    cos, sin = np.cos(2.5), np.sin(2.5)
    pose[:2, :2], pose[:3, 3] = [[cos, -sin], [sin, cos]], [100.0, -40.0, 3.0]
    x, y, heading = actors.pose.T
    there = Actors(
        **{
            **vars(actors),
            "pose": np.stack([100 + cos * x - sin * y, -40 + sin * x + cos * y, heading + 2.5], -1),
            "z": actors.z + 3.0,
        }
    )
    moved = label(there, pose=pose)
    for name in ("location", "rotation_y", "box2d", "alpha"):
        np.testing.assert_allclose(
            getattr(moved.boxes, name), getattr(found.boxes, name), atol=0.02
        )


def test_angles_are_those_of_the_devkit() -> None:
    """A car that drives straight away has rotation_y -pi/2; alpha is seen from the camera."""
    away = label(people((20.0, 0.0, 0.0, "Car", CAR, True))).boxes
    assert away.rotation_y[0] == pytest.approx(-np.pi / 2)
    assert away.alpha[0] == pytest.approx(-np.pi / 2)
    to_the_right = label(people((20.0, 0.0, -np.pi / 2, "Car", CAR, True))).boxes
    assert to_the_right.rotation_y[0] == pytest.approx(0.0)
    # Two cars that show the same side of themselves to the camera have one alpha.
    bearing = np.arctan2(8.0, 20.0)
    aside = label(people((20.0, 8.0, bearing, "Car", CAR, True))).boxes
    assert aside.alpha[0] == pytest.approx(-np.pi / 2)
    assert aside.rotation_y[0] == pytest.approx(-np.pi / 2 - bearing)


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_occlusion_is_the_share_of_the_silhouette_before_which_nothing_stands(level: int) -> None:
    """A block seen from the front, and a wall half way that covers a share of it."""
    steps = [1.0, FULLY_VISIBLE, PARTLY_VISIBLE, BARELY_VISIBLE, 0.03]
    visible = 0.5 * (steps[level] + steps[level + 1])
    block = people((12.0, 0.0, 0.0, "Car", (1.65, 4.0, 4.0), False))
    wall = box(0.01, 3.0, 4.0).placed(5.0, 1.0 - 2.0 * (1.0 - visible) + 1.5)
    found = label(block, wall)
    assert found.boxes.occlusion.tolist() == [level]
    # The 2D box goes round the whole object, hidden or not.
    np.testing.assert_allclose(found.boxes.box2d, projected(found), atol=0.05)


def test_one_actor_hides_another() -> None:
    found = label(
        people(
            (10.0, 0.0, 0.0, "Van", (2.0, 2.0, 2.0), False),
            (20.0, 1.5, 0.0, "Car", (1.5, 2.0, 2.0), False),
        )
    )
    assert found.boxes.category.tolist() == ["Van", "Car"]
    assert found.boxes.occlusion[0] == 0
    assert found.boxes.occlusion[1] >= 1


def test_the_occlusion_of_some_at_the_border_is_left_open() -> None:
    """A quarter of what the border cuts, an eighth of large vehicles: level 3, as in KITTI."""
    rows = [
        (11.0, 9.0 * 240 / 300 + 1.0, 0.0, "Car", (1.5, 2.0, 2.0), False),
        (20.0, -3.0, 0.0, "Car", (1.5, 2.0, 2.0), False),
        (20.0, 0.0, 0.0, "Van", (1.5, 2.0, 2.0), False),
    ]
    levels = {
        seed: sorted(
            label(replace(people(*rows), appearance=np.full(3, seed))).boxes.occlusion.tolist()
        )
        for seed in (996, 200, 50)
    }
    assert levels == {996: [0, 0, 0], 200: [0, 0, 3], 50: [0, 3, 3]}


def test_truncation_is_the_share_of_the_2d_box_outside_the_image() -> None:
    """A cube whose front is cut in the middle by the left border of the image."""
    cube = people((11.0, 9.0 * 240 / 300 + 1.0, 0.0, "Car", (1.5, 2.0, 2.0), False))
    found = label(cube)
    boxes = found.boxes
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    pixels, _ = project(RIG.calibration.projection(0), corners)
    whole = np.ptp(pixels[0], axis=0).prod()
    left, top, right, bottom = projected(found)[0]
    assert left == 0.0
    assert boxes.truncation[0] == pytest.approx(
        1 - (right - left) * (bottom - top) / whole, abs=0.01
    )
    assert 0.3 < boxes.truncation[0] < 0.8
    np.testing.assert_allclose(boxes.box2d, projected(found), atol=0.1)
    assert boxes.occlusion[0] == 0


def test_the_own_vehicle_and_what_is_not_seen_have_no_labels() -> None:
    actors = people(
        (0.0, 0.0, 0.0, "Car", CAR, True),
        (-15.0, 0.0, 0.0, "Car", CAR, True),
        (30.0, 0.5, 0.0, "Pedestrian", (1.7, 0.5, 0.5), True),
        (12.0, 6.0, 0.0, "Car", CAR, False),
    )
    found = label(actors, box(0.2, 3.0, 3.0).placed(14.0, 0.0), own=0)
    assert found.actor.tolist() == [3]
    assert len(found.dont_care) == 0


def test_what_is_too_small_to_label_is_not_cared_about() -> None:
    """Two cars far away, side by side, are one region; a third one is another."""
    actors = people(
        (85.0, 10.0, 0.0, "Car", CAR, False),
        (85.0, 12.2, 0.0, "Car", CAR, False),
        (85.0, -20.0, 0.0, "Car", CAR, False),
        (12.0, 0.0, 0.0, "Van", CAR, False),
    )
    found = label(actors)
    assert found.boxes.category.tolist() == ["Van"]
    location, rotation_y = boxes_in_camera(actors, RIG, np.eye(4))
    corners = box_corners(location[:3], actors.dimensions[:3], rotation_y[:3])
    pixels, _ = project(RIG.calibration.projection(0), corners)
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    pair = [*low[:2].min(axis=0), *high[:2].max(axis=0)]
    np.testing.assert_allclose(found.dont_care, [pair, [*low[2], *high[2]]], atol=0.05)
    written = dont_care_boxes(found.dont_care)
    assert set(written.category) == {"DontCare"}
    np.testing.assert_array_equal(written.location, -1000.0)
    np.testing.assert_array_equal(written.box2d, found.dont_care)


def test_an_empty_road_has_no_labels() -> None:
    alone = people((0.0, 0.0, 0.0, "Car", CAR, False))
    found = label(alone, box(1.0, 1.0, 1.0).placed(9.0, 0.0), own=0)
    assert len(found.boxes) == 0
    assert found.dont_care.shape == (0, 4)
