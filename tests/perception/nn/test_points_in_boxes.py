"""Points in boxes by shapely, and the first of them by plain loops."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import torch

from avsec_gym.geometry import box_corners
from avsec_gym.perception.nn.points_in_boxes import (
    enlarged,
    first_inside,
    in_box_frames,
    points_in_boxes,
)

BOXES = torch.tensor(
    [
        [2.0, 1.6, 12.0, 1.5, 1.7, 4.0, 0.4],
        [-3.0, 1.7, 20.0, 1.4, 1.6, 3.6, -2.2],
        [2.5, 1.6, 14.0, 1.6, 1.8, 4.4, 1.7],
    ],
    dtype=torch.float64,
)


def places(count: int = 4000) -> torch.Tensor:
    drawn = np.random.default_rng(0).uniform([-6, -1, 8], [6, 3, 24], (count, 3))
    return torch.from_numpy(drawn)


def test_as_shapely_sees_them_from_above() -> None:
    points = places()
    inside = points_in_boxes(points, BOXES)
    for box, found in zip(BOXES.numpy(), inside.numpy(), strict=True):
        bottom = box_corners(box[:3], box[3:6], box[6])[:4, [0, 2]]
        above = shapely.contains(shapely.Polygon(bottom), shapely.points(points[:, [0, 2]].numpy()))
        height = (points[:, 1] < box[1]) & (points[:, 1] > box[1] - box[3])
        np.testing.assert_array_equal(found, above & height.numpy())
        assert found.sum() > 10


def test_the_front_is_ahead_and_corners_are_where_the_label_has_them() -> None:
    corners = torch.from_numpy(box_corners(BOXES[:, :3], BOXES[:, 3:6], BOXES[:, 6]))
    along, down, across = in_box_frames(corners, BOXES).unbind(-1)
    height, width, length = BOXES[:, 3:6, None].unbind(1)
    front = torch.tensor([1.0, -1, -1, 1] * 2, dtype=torch.float64)
    assert torch.allclose(along, front * length / 2)
    assert torch.allclose(across.abs(), (width / 2).expand(-1, 8))
    assert torch.allclose(down, -height * (torch.arange(8) > 3))


def test_enlarged_boxes_reach_as_far_on_all_sides() -> None:
    aligned = BOXES[:1].clone()
    aligned[:, 6] = 0.0
    grown = box_corners(*(part[0] for part in _parts(enlarged(aligned, 0.5))))
    small = box_corners(*(part[0] for part in _parts(aligned)))
    np.testing.assert_allclose(np.ptp(grown, axis=0), np.ptp(small, axis=0) + 1)
    np.testing.assert_allclose(grown.mean(0), small.mean(0))


def _parts(boxes: torch.Tensor) -> tuple[np.ndarray, ...]:
    rows = boxes.numpy()
    return rows[:, :3], rows[:, 3:6], rows[:, 6]


@pytest.mark.parametrize("count", [3, 50])
def test_the_first_ones_in_their_order_and_again_from_the_first(count: int) -> None:
    inside = points_in_boxes(places(400), torch.cat([BOXES, BOXES[:1] + 100]))
    found = first_inside(inside, count)
    assert found.shape == (4, count)
    for row, mask in zip(found.tolist(), inside.tolist(), strict=True):
        held = [index for index, is_in in enumerate(mask) if is_in][:count]
        assert row == [held[k % len(held)] if held else 0 for k in range(count)]
    assert not inside[3].any()
