"""Mismatches of boxes against every way to pair them, and bogus patches against their points."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import (
    bogus_patch,
    taken_for_an_obstacle,
)
from avsec_gym.experiments.chapter3.objects.object_mismatches import (
    boxes_seen_by,
    disparity_reach,
    mismatches,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.rig import camera_rig

RIG = camera_rig((0.0, 0.54, -0.27, 0.27))
LEAST, TALL, WIDTH = 0.5, 25.0, 110.0


def cars(*box2d: tuple[float, float, float, float], category: str = "Car") -> Boxes3D:
    return image_boxes(np.reshape(box2d, (-1, 4)), np.ones(len(box2d)), [category] * len(box2d))


def iou(one: Floats, other: Floats, reach: float) -> float:
    """The best over many small shifts."""
    best = 0.0
    for moved in np.linspace(0.0, reach, 200) if reach else (0.0,):
        width = min(one[2], other[2] + moved) - max(one[0], other[0] + moved)
        height = min(one[3], other[3]) - max(one[1], other[1])
        common = max(width, 0.0) * max(height, 0.0)
        areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)]
        best = max(best, common / (sum(areas) - common))
    return best


def fewest_mismatches(first: Floats, second: Floats, reach: float) -> int:
    """Over all ways to pair the boxes."""
    tall = [[int(box[3] - box[1] >= TALL) for box in boxes] for boxes in (first, second)]
    if reach:
        for i, box in enumerate(first):
            tall[0][i] *= box[0] >= reach
        for i, box in enumerate(second):
            tall[1][i] *= box[2] <= WIDTH - reach
    partners = [[iou(box, other, reach) > LEAST for other in second] for box in first]
    lonely = sum(tall[0]) + sum(tall[1])
    # So many of the second set that each of the first has one, or none of them.
    places = [*range(len(second)), *[-1] * len(first)]
    spared = [
        sum(tall[0][i] + tall[1][j] for i, j in enumerate(order) if j >= 0 and partners[i][j])
        for order in set(permutations(places, len(first)))
    ]
    return lonely - max(spared)


@pytest.mark.parametrize("reach", [0.0, 40.0])
@pytest.mark.parametrize("seed", range(12))
def test_the_best_of_all_ways_to_pair_boxes_counts(seed: int, reach: float) -> None:
    random = np.random.default_rng(seed)
    places = random.uniform(0, 60, (5, 2))
    both = [
        np.hstack([near, near + random.uniform((30, 15), (60, 45), (len(near), 2))])
        for near in (
            places[: random.integers(0, 5)] + random.normal(0, 4, 2),
            places[random.integers(0, 3) :] - [reach / 2, 0],
        )
    ]
    found = mismatches(*(cars(*map(tuple, boxes)) for boxes in both), LEAST, reach, WIDTH)
    assert found == fewest_mismatches(*both, reach)


def test_what_is_no_partner_and_what_is_no_mismatch() -> None:
    car = (100.0, 100.0, 200.0, 160.0)
    assert mismatches(cars(car), cars(car), 0.99) == 0
    assert mismatches(cars(car), cars(), 0.5) == mismatches(cars(), cars(car), 0.5) == 1
    assert mismatches(Boxes3D.empty(), Boxes3D.empty(), 0.5) == 0
    assert mismatches(cars(car), cars(car, category="Van"), 0.5) == 2
    assert mismatches(cars(car), cars(car, car), 0.5) == 1
    # Two thirds are more than a half, and less than 0.7.
    higher = (100.0, 100.0, 200.0, 190.0)
    assert [mismatches(cars(car), cars(higher), least) for least in (0.5, 0.7)] == [0, 2]
    # Far cars are not asked for.
    assert mismatches(cars((10, 10, 50, 34.9)), cars(), 0.5) == 0
    assert mismatches(cars((10, 10, 50, 35.0)), cars(), 0.5) == 1


def test_what_the_other_camera_would_not_show_is_no_mismatch() -> None:
    # If it is near, a car at the left edge of the left image is beyond that of the right one.
    for left, counted in ((20.0, 0), (60.0, 1)):
        only = cars((left, 100, left + 80, 160))
        assert mismatches(only, cars(), 0.5, reach=50.0, width=1000.0) == counted
        mirrored = cars((920 - left, 100, 1000 - left, 160))
        assert mismatches(cars(), mirrored, 0.5, reach=50.0, width=1000.0) == counted
        # In one image there is nothing that the other sensor cannot see.
        assert mismatches(only, cars(), 0.5) == 1
    # Yet it may have a partner.
    edge, other = cars((20, 100, 120, 160)), cars((0, 100, 90, 160))
    assert mismatches(edge, other, 0.5, reach=50.0, width=1000.0) == 0


def test_a_near_car_is_one_car_in_two_cameras() -> None:
    calibration = RIG.calibration
    rear = np.array([[-0.8, 0.1, 6.0], [0.8, 1.65, 6.0]])
    left, right = (project(calibration.projection(camera), rear)[0].ravel() for camera in (2, 1))
    seen = [cars(tuple(box)) for box in (left, right)]
    assert mismatches(seen[0], seen[1], 0.7) == 2
    reach = disparity_reach(calibration, 2, 1)
    assert reach == pytest.approx(721.5377 * 0.81 / 3.5)
    assert mismatches(seen[0], seen[1], 0.99, reach) == 0
    # Nothing stands farther right in the camera on the right.
    assert mismatches(seen[1], seen[0], 0.7, reach) == 2


def car_at(x: float, z: float, yaw: float = -np.pi / 2) -> Boxes3D:
    return Boxes3D(
        np.array([[x, 1.65, z]]), np.array([[1.5, 1.6, 4.0]]), np.array([yaw]), np.ones(1),
        np.array(["Car"]),
    )  # fmt: skip


def test_a_camera_shows_what_is_before_it() -> None:
    size, projection = (375, 1242), RIG.calibration.projection(3)
    boxes = Boxes3D.concatenate([car_at(0, 20), car_at(0, -20), car_at(60, 10), car_at(-3, 1)])
    seen = boxes_seen_by(boxes, projection, size)
    assert seen.location[:, 0].tolist() == [0, -3]
    assert seen.box2d is not None
    corners = np.array([[x, y, 18.0] for x in (-0.8, 0.8) for y in (0.15, 1.65)])
    pixels, _ = project(projection, corners)
    np.testing.assert_allclose(seen.box2d[0, [0, 2]], [pixels[:, 0].min(), pixels[:, 0].max()])
    assert seen.box2d[0, 3] == pytest.approx(pixels[:, 1].max())
    # Half beside and half behind the camera: up to the image's edge.
    assert seen.box2d[1, 0] == 0.0


@pytest.mark.parametrize("bearing", [0.0, 0.4, -0.4])
def test_a_bogus_patch_is_where_its_points_are(bearing: float) -> None:
    frame = SensorFrame("0", RIG.calibration, scan=np.zeros((3, 4), np.float32))
    tampered = LidarSpoofing(distance=8.0, bearing=bearing).attack(frame, 1)
    patch = bogus_patch(tampered)
    assert patch.dimensions[0] == pytest.approx([1.5, 0.1, 2.5], abs=0.2)
    # 8 m from the LiDAR, which stands 27 cm behind the cameras.
    assert patch.location[0] == pytest.approx(
        [-8 * np.sin(bearing), 1.65, 8 * np.cos(bearing) - 0.27], abs=0.15
    )
    bogus = tampered.frame.points[tampered.points, :3]
    places = transform_points(RIG.calibration.velodyne_to_camera, bogus)
    from_middle = places - patch.location[0]
    across = from_middle @ [np.cos(bearing), 0, np.sin(bearing)]
    ahead = from_middle @ [-np.sin(bearing), 0, np.cos(bearing)]
    assert np.abs(across).max() == pytest.approx(patch.dimensions[0, 2] / 2, abs=1e-6)
    assert np.abs(ahead).max() < 0.1


def test_which_boxes_take_a_bogus_return_for_an_obstacle() -> None:
    frame = SensorFrame("0", RIG.calibration, scan=np.zeros((3, 4), np.float32))
    patch = bogus_patch(LidarSpoofing(distance=8.0, bearing=0.0).attack(frame, 1))
    z = float(patch.location[0, 2])
    cases = [
        (car_at(0, z + 2.2), True),  # a car's rear, 20 cm behind the patch
        (car_at(0, z, yaw=0.0), True),  # a car's side
        (car_at(0.9, z + 2), True),
        (car_at(3.0, z + 2), False),  # beside it
        (car_at(0, z + 4), False),  # 2 m behind it
        (Boxes3D.empty(), False),
        (Boxes3D.concatenate([car_at(3, 30), car_at(0, z)]), True),
    ]
    for boxes, taken in cases:
        assert taken_for_an_obstacle(boxes, patch) is taken
    assert not taken_for_an_obstacle(car_at(0, z), Boxes3D.empty())
