"""Labels as images' truth: who is learned, who is left alone, and where."""

from __future__ import annotations

import numpy as np
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.detectors.image_truth import image_truth

LIKE = torch.zeros(1, dtype=torch.float64)
BOX = [10.0, 20, 59, 49]


def _truth(*names: str, boxes: list[list[float]] | None = None, **changes: object):  # type: ignore[no-untyped-def]
    labels = image_boxes(np.array(boxes or [BOX] * len(names)), np.ones(len(names)), names)
    labels = Boxes3D(**{**vars(labels), **changes})  # type: ignore[arg-type]
    return image_truth(labels, ("Car", "Pedestrian"), (0.5, 2.0), LIKE)


def test_boxes_follow_the_image_and_classes_their_order() -> None:
    truth = _truth("Pedestrian", "Truck", "Car")
    assert truth.classes.tolist() == [1, 0]
    # The middles of pixels are whole numbers, so the left one, 10, is 10.5 from the edge.
    assert truth.boxes[0].tolist() == [20.5, 9.75, 118.5, 24.25]
    assert not len(truth.ignored)


def test_what_is_alike_or_unclear_is_left_alone() -> None:
    names = ("Van", "DontCare", "Person_sitting", "Car", "Cyclist")
    truth = _truth(*names, occlusion=np.array([0, 0, 0, 3, 0]))
    assert len(truth.boxes) == 0
    assert len(truth.ignored) == 4
    tiny = _truth("Car", boxes=[[10, 20, 59, 25]])  # 2.5 pixels high in the network's input
    assert (len(tiny.boxes), len(tiny.ignored)) == (0, 1)


def test_an_empty_street() -> None:
    truth = image_truth(Boxes3D.empty(), ("Car",), (1.0, 1.0), LIKE)
    assert truth.boxes.shape == truth.ignored.shape == (0, 4)
    assert truth.boxes.dtype == torch.float64
