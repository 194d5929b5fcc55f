"""Non-maximum suppression against a plain loop over shapely's polygons."""

from __future__ import annotations

import numpy as np
import shapely

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.perception.nn.rotated_nms import rotated_nms


def _plain(rectangles: np.ndarray, scores: np.ndarray, threshold: float) -> list[int]:
    polygons = rectangle_polygons(rectangles[:, [0, 1, 4]], rectangles[:, 2], rectangles[:, 3])
    kept: list[int] = []
    for i in sorted(range(len(scores)), key=lambda i: -scores[i]):
        overlaps = (
            shapely.area(polygons[i] & polygons[j]) / shapely.area(polygons[i] | polygons[j])
            for j in kept
        )
        if all(overlap <= threshold for overlap in overlaps):
            kept.append(i)
    return kept


def test_agrees_with_polygons_of_another_library() -> None:
    randomness = np.random.default_rng(3)
    for threshold in (0.1, 0.3, 0.6):
        rectangles = np.column_stack(
            [
                randomness.normal(0, 3, (60, 2)),
                randomness.uniform(3, 5, 60),
                randomness.uniform(1, 2, 60),
                randomness.choice([0.0, 1.5], 60) + randomness.normal(0, 0.2, 60),
            ]
        )
        scores = randomness.random(60)
        kept = rotated_nms(rectangles, scores, threshold)
        assert kept.tolist() == _plain(rectangles, scores, threshold)
        assert 1 < len(kept) < 60


def test_of_two_equal_boxes_the_first_stays() -> None:
    rectangle = [3.0, 20.0, 3.9, 1.6, 0.4]
    assert rotated_nms([rectangle] * 3, [0.5, 0.5, 0.5], 0.6).tolist() == [0]


def test_a_turn_by_half_a_circle_is_the_same_rectangle() -> None:
    pair = [[3.0, 20.0, 3.9, 1.6, 0.4], [3.0, 20.0, 3.9, 1.6, 0.4 + np.pi]]
    assert rotated_nms(pair, [0.1, 0.2], 0.99).tolist() == [1]


def test_no_boxes() -> None:
    assert rotated_nms(np.zeros((0, 5)), np.zeros(0), 0.6).shape == (0,)
