"""The networks of the package find cars in places that none of them has seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.detectors import make_detector
from avsec_gym.world.export import make_data_set, suite_recipe

SEED = 4000
"""Trainings, validations and results are of other sets."""
REACH = 40.0
"""Metres, which all of them look at."""


@pytest.fixture(scope="module")
def unseen(tmp_path_factory: pytest.TempPathFactory) -> KittiObject:
    root: Path = tmp_path_factory.mktemp("unseen") / "frames"
    make_data_set(suite_recipe("mixed", 10, SEED), root, workers=1)
    return KittiObject(root)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("detector", "in_image", "recall", "precision"),
    [
        ("dsgn", False, 0.3, 0.5),
        ("stereo_rcnn", False, 0.5, 0.5),
        ("pixor", False, 0.8, 0.8),
        ("pointrcnn", False, 0.8, 0.8),
        ({"name": "single_image", "detector": "faster_rcnn"}, True, 0.8, 0.7),
        ({"name": "single_image", "detector": "yolo"}, True, 0.6, 0.7),
    ],
)
def test_cars_are_found(
    unseen: KittiObject, detector: Any, in_image: bool, recall: float, precision: float
) -> None:
    network, found, right = make_detector(detector), [], []
    for id in unseen.ids(having=["label_2"]):
        truth, sure = unseen.labels(id), network.detect(unseen.frame(id))
        sure = sure[sure.score >= 0.3]  # As in all drives.
        same = overlaps(truth, sure, in_image) >= 0.5
        assert truth.truncation is not None
        assert truth.occlusion is not None
        plain = (truth.category == "Car") & (truth.location[:, 2] < REACH)
        plain &= (truth.truncation <= 0.3) & (truth.occlusion <= 1)
        found += same.any(axis=1)[plain].tolist()
        right += same.any(axis=0).tolist()
    assert len(found) > 15
    assert np.mean(found) >= recall
    assert np.mean(right) >= precision


def overlaps(truth: Boxes3D, boxes: Boxes3D, in_image: bool) -> Floats:
    """Intersection over union, by shapely, shape (N, M)."""
    ours, theirs = (
        shapely.box(*objects.box2d.T)  # type: ignore[union-attr]
        if in_image
        else np.array(rectangle_polygons(objects.poses, objects.length, objects.width), object)
        for objects in (truth, boxes)
    )
    common = shapely.area(shapely.intersection(ours[:, None], theirs[None]))
    union = shapely.area(ours)[:, None] + shapely.area(theirs)[None] - common
    return np.asarray(common / union)
