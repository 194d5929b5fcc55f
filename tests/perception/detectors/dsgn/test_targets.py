"""Anchors' targets against plain loops over every anchor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import box_corners
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.grid import CAR, CYCLIST, PEDESTRIAN, GridAxis, WorldGrid
from avsec_gym.perception.detectors.dsgn.targets import AnchorTargets, anchor_targets

CLASSES = ("Pedestrian", "Car", "Cyclist")


@pytest.fixture
def coarse(tiny: DsgnConfiguration) -> DsgnConfiguration:
    grid = WorldGrid(GridAxis(-10, 10, 40), GridAxis(2.5, -0.7, 8), GridAxis(22, 2, 40))
    return replace(tiny, anchors=(PEDESTRIAN, CAR, CYCLIST), grid=grid)


def _random_boxes(seed: int, count: int = 6) -> Boxes3D:
    randomness = np.random.default_rng(seed)
    return Boxes3D(
        np.column_stack(
            [
                randomness.uniform(-12, 12, count),
                randomness.uniform(1.4, 1.9, count),
                randomness.uniform(1, 25, count),
            ]
        ),
        np.column_stack(
            [
                randomness.uniform(1.4, 1.8, count),
                randomness.uniform(0.5, 1.9, count),
                randomness.uniform(0.7, 4.5, count),
            ]
        ),
        randomness.uniform(-np.pi, np.pi, count),
        np.ones(count),
        randomness.choice([*CLASSES, "Van", "Truck", "Person_sitting", "DontCare"], count),
        truncation=randomness.choice([0.0, 0.5, 0.99], count),
    )


def _oracle(
    boxes: Boxes3D, configuration: DsgnConfiguration
) -> dict[tuple[int, ...], tuple[np.ndarray, float, bool]]:
    """By (angle, class, row, column): corners, centerness, and whether they are those turned."""
    names = {"Van": "Car", "Person_sitting": "Pedestrian"}
    categories = [names.get(name, name) for name in boxes.category]
    order = sorted(
        (i for i in range(len(boxes)) if categories[i] in CLASSES and boxes.truncation[i] < 0.98),
        key=lambda i: (CLASSES.index(categories[i]), -boxes.location[i, 2]),
    )
    cell = 0.5 * 0.5
    distances, objects, owners, ways = [], [], {}, {}
    for i in order:
        kind = CLASSES.index(categories[i])
        anchor = configuration.anchors[kind]
        true = [
            box_corners(boxes.location[i], boxes.dimensions[i], boxes.rotation_y[i] + turn)
            for turn in ((0.0, np.pi) if configuration.half_turns else (0.0,))
        ]
        found = {}
        for row in range(40):
            for column in range(40):
                place = np.array([-9.75 + 0.5 * column, anchor.centre_y, 21.75 - 0.5 * row])
                for angle in range(configuration.angles):
                    size = np.array([anchor.height, anchor.width, anchor.length])
                    bottom = place + np.array([0, anchor.height / 2, 0])
                    corners = box_corners(bottom, size, angle * np.pi / 2)
                    apart = [np.hypot(*(corners - way)[:4, [0, 2]].T).mean() for way in true]
                    found[angle, row, column] = min(*apart, 5.0)
                    ways[len(objects), angle, row, column] = int(np.argmin(apart))
        count = boxes.dimensions[i, 1] * boxes.dimensions[i, 2] / cell
        count = max(int(count / 4 if kind == 1 else count), 1)
        nearest = [key for key in sorted(found, key=found.__getitem__)[:count] if found[key] < 5]
        for angle, row, column in nearest:
            owners[angle, kind, row, column] = len(objects)
        distances.append((found, min((found[key] for key in nearest), default=0.0)))
        objects.append(true)
    result = {}
    for (angle, kind, row, column), number in owners.items():
        place = np.array(
            [-9.75 + 0.5 * column, configuration.anchors[kind].centre_y, 21.75 - 0.5 * row]
        )
        found, least = min(distances, key=lambda pair: pair[0][angle, row, column])
        centerness = np.exp(least - found[angle, row, column])
        # The original goes round the other way.
        way = ways[number, angle, row, column]
        corners = (objects[number][way] - place)[[0, 3, 2, 1, 4, 7, 6, 5]]
        result[angle, kind, row, column] = corners, centerness, bool(way)
    return result


def _as_dictionary(
    targets: AnchorTargets, image: int
) -> dict[tuple[int, ...], tuple[np.ndarray, float, bool]]:
    return {
        tuple(key[1:]): (corners.numpy(), float(centerness), bool(reverse))
        for key, corners, centerness, reverse in zip(
            torch.stack(targets.index, 1).tolist(),
            targets.corners,
            targets.centerness,
            targets.reversed,
            strict=True,
        )
        if key[0] == image
    }


@pytest.mark.slow
@pytest.mark.parametrize("half_turns", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_agrees_with_plain_loops(coarse: DsgnConfiguration, seed: int, half_turns: bool) -> None:
    if half_turns:
        coarse = replace(coarse, half_turns=True, angles=2)
    batch = [_random_boxes(seed), Boxes3D.empty(), _random_boxes(seed + 100)]
    targets = anchor_targets(batch, coarse, CLASSES)
    for image, boxes in enumerate(batch):
        expected, found = (
            _oracle(boxes, coarse) if len(boxes) else {},
            _as_dictionary(targets, image),
        )
        assert set(found) == set(expected)
        for key, (corners, centerness, reverse) in expected.items():
            np.testing.assert_allclose(found[key][0], corners, atol=1e-9)
            assert found[key][1] == pytest.approx(centerness, abs=1e-12)
            assert found[key][2] == reverse


def _car(x: float, z: float, yaw: float = 0.0) -> Boxes3D:
    return Boxes3D(
        np.array([[x, 1.65, z]]),
        np.array([[1.56, 1.6, 3.9]]),
        np.array([yaw]),
        np.ones(1),
        np.array(["Car"]),
    )


def test_a_car_of_the_anchor_s_size_takes_39_anchors_of_the_full_grid() -> None:
    configuration = DsgnConfiguration()
    targets = anchor_targets([_car(0.1, 20.1)], configuration)
    _, angle, category, row, column = targets.index
    assert len(row) == 39
    assert set(category.tolist()) == {1}
    assert set(angle.tolist()) == {0}
    best = int(targets.centerness.argmax())
    assert targets.centerness[best] == pytest.approx(1.0)
    assert configuration.grid.x.centres()[column[best]] == pytest.approx(0.1)
    assert configuration.grid.z.centres()[row[best]] == pytest.approx(20.1)
    # All within a disc of 39 cells, its centre the car's.
    apart = torch.hypot((row - row[best]) * 0.2, (column - column[best]) * 0.2)
    assert float(apart.max()) < 0.2 * (39 / np.pi) ** 0.5 + 0.15


def test_an_anchor_that_points_the_other_way_is_far(tiny: DsgnConfiguration) -> None:
    forwards = anchor_targets([_car(0.25, 14.25)], tiny).index[1]
    backwards = anchor_targets([_car(0.25, 14.25, np.pi)], tiny).index[1]
    assert set(forwards.tolist()) == {0}
    assert set(backwards.tolist()) == {2}


def test_classes_that_are_not_learned_and_far_objects_leave_no_target(
    tiny: DsgnConfiguration,
) -> None:
    truck = replace(_car(0, 14), category=np.array(["Truck"]))
    for boxes in (truck, _car(0, 70), _car(-40, 10), Boxes3D.empty()):
        targets = anchor_targets([boxes], tiny)
        assert targets.corners.shape == (0, 8, 3)
        assert all(len(part) == 0 for part in targets.index)


def test_of_two_objects_at_one_place_the_nearer_has_the_anchors(tiny: DsgnConfiguration) -> None:
    pair = Boxes3D.concatenate([_car(0.0, 14.0), _car(0.0, 14.2)])
    for boxes in (pair, pair[::-1]):
        targets = anchor_targets([boxes], tiny)
        rows = torch.from_numpy(tiny.grid.z.centres())[targets.index[3]]
        middle = targets.corners.mean(1)[:, 2] + rows
        nearer = (middle - 14.0).abs() < 1e-6
        assert int(nearer.sum()) == len(anchor_targets([pair[:1]], tiny).centerness)
