"""The metrics of trainings are those of KITTI's average precision, by their names."""

from __future__ import annotations

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.perception.training.precision import precision


def frames(shift: float) -> list[Boxes3D]:
    """Two cars in each of ten frames, some metres to the right of where they are."""
    rng = np.random.default_rng(2)
    found = []
    for _ in range(10):
        location = np.column_stack(
            [rng.uniform(-4, 4, 2) + shift, np.full(2, 1.6), np.array([10.0, 25.0])]
        )
        left = 600 + 700 * location[:, 0] / location[:, 2]
        box2d = np.column_stack([left, [150.0, 160], left + 100, [220.0, 200]])
        found.append(
            Boxes3D(
                location,
                np.tile([1.5, 1.6, 3.9], (2, 1)),
                np.full(2, np.pi / 2),
                rng.uniform(0.5, 1.0, 2),
                np.array(["Car", "Car"]),
                box2d=box2d,
                alpha=np.zeros(2),
            )
        )
    return found


def test_names_state_view_recall_points_level_and_overlap() -> None:
    # 35 cm aside, cars overlap by more than half, and by less than 0.7 in space.
    labels, found = frames(0.0), frames(0.35)
    strict = average_precision(labels, found, classes=("Car",), min_iou=STANDARD_IOU)
    low = average_precision(labels, found, classes=("Car",), min_iou=LOW_IOU)
    expected = {
        "Car_3d_ap40": strict.value("Car", recall_points=40),
        "Car_3d_ap11_iou50": low.value("Car"),
        "Car_bev_ap11_hard": strict.value("Car", "bev", "hard"),
        "Car_2d_ap11_easy": strict.value("Car", "2d", "easy"),
        "Car_2d_ap40_iou50": low.value("Car", "2d", recall_points=40),
    }
    measures = [name.removeprefix("Car_") for name in expected]
    measured = precision(labels, found, "Car", measures)
    assert measured == expected
    assert list(measured) == list(expected)
    assert measured["Car_3d_ap11_iou50"] > measured["Car_3d_ap40"]


def test_other_overlaps_are_taken_for_the_easier_ones() -> None:
    labels, found = frames(0.0), frames(0.35)
    whole = {"Car": (0.999, 0.999, 0.999)}
    assert precision(labels, found, "Car", ["3d_ap11_iou50"], whole) == {"Car_3d_ap11_iou50": 0.0}
