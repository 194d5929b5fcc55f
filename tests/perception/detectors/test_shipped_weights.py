"""The networks of the package find cars in places that none of them has seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors import make_detector
from avsec_gym.world.export import make_data_set, suite_recipe

CAR = "Car"
SEED = 4000
"""Trainings, validations and results are of other sets."""


@pytest.fixture(scope="module")
def unseen(tmp_path_factory: pytest.TempPathFactory) -> KittiObject:
    root: Path = tmp_path_factory.mktemp("unseen") / "frames"
    make_data_set(suite_recipe("mixed", 10, SEED), root, workers=1)
    return KittiObject(root)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("detector", "metric", "least"),
    [
        ("dsgn", "bev", 20),
        ("stereo_rcnn", "bev", 20),
        ("pixor", "bev", 60),
        ("pointrcnn", "3d", 60),
        ({"name": "single_image", "detector": "faster_rcnn"}, "2d", 60),
        ({"name": "single_image", "detector": "yolo"}, "2d", 40),
    ],
)
def test_cars_are_found(unseen: KittiObject, detector: Any, metric: str, least: float) -> None:
    network, ids = make_detector(detector), unseen.ids(having=["label_2"])
    found = average_precision(
        [unseen.labels(id, keep_dont_care=True) for id in ids],
        [network.detect(unseen.frame(id)) for id in ids],
        classes=(CAR,),
        min_iou={CAR: (0.5, 0.5, 0.5)},
    )
    assert found.value(CAR, metric, "moderate", 40) > least
