"""Box voting against plain loops, with shapely for the overlap."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from avsec_gym.geometry import bird_eye_iou, wrap_angle
from avsec_gym.perception.nn.box_voting import voted_boxes


def _candidates(seed: int, count: int = 40) -> tuple[NDArray[np.float64], ...]:
    """Three cars, each found many times, some of them turned round."""
    random = np.random.default_rng(seed)
    centres = np.array([[0.0, 1.6, 10.0], [4.0, 1.7, 14.0], [1.5, 1.6, 12.0]])
    which = random.integers(3, size=count)
    location = centres[which] + random.normal(0, 0.4, (count, 3))
    dimensions = np.array([1.5, 1.6, 4.0]) * random.uniform(0.9, 1.1, (count, 3))
    yaw = np.array([0.1, 1.5, -3.1])[which] + random.normal(0, 0.3, count)
    yaw = wrap_angle(yaw + np.pi * (random.random(count) < 0.3))
    return location, dimensions, yaw, random.uniform(0.05, 0.9, count)


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_plain_loops(seed: int) -> None:
    location, dimensions, yaw, scores = _candidates(seed)
    kept = np.array([3, 0, 17])
    found = voted_boxes(location, dimensions, yaw, scores, kept, overlap=0.3, turn=0.5)
    poses = np.column_stack([location[:, [0, 2]], -yaw])
    overlaps = bird_eye_iou(poses, dimensions[:, [2, 1]], poses, dimensions[:, [2, 1]])
    for i, row in enumerate(kept):
        place, size, turned, total, other_way = np.zeros(3), np.zeros(3), 0.0, 0.0, 0.0
        for j in range(len(scores)):
            turn = float(wrap_angle(yaw[j] - yaw[row]))
            is_reversed = abs(turn) > np.pi / 2
            if is_reversed:
                turn = float(wrap_angle(turn + np.pi))
            if j == row or (overlaps[row, j] > 0.3 and abs(turn) < 0.5):
                place, size = place + scores[j] * location[j], size + scores[j] * dimensions[j]
                turned, total = turned + scores[j] * turn, total + scores[j]
                other_way += scores[j] * is_reversed
        np.testing.assert_allclose(found[0][i], place / total)
        np.testing.assert_allclose(found[1][i], size / total)
        expected = yaw[row] + turned / total + np.pi * (other_way > total / 2)
        assert abs(wrap_angle(found[2][i] - expected)) < 1e-9


def test_a_box_alone_stays_where_it_is() -> None:
    location, dimensions, yaw, scores = (values[:1] for values in _candidates(0))
    found = voted_boxes(location, dimensions, yaw, scores, np.array([0]), overlap=0.3, turn=0.5)
    for before, after in zip((location, dimensions, yaw), found, strict=True):
        np.testing.assert_allclose(after, before)
