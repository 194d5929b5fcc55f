"""Labels against labels."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.world.layouts import generate_layouts
from studies.world.labels import COMPARED, LabelRow, boxes_of, compare, summary
from studies.world.layout_quantities import Sample

_NUMBERS = ("location", "dimensions", "rotation_y", "box2d", "truncation", "occlusion", "alpha")


def rows(seed: int, count: int = 60) -> list[LabelRow]:
    return [
        LabelRow(
            **{name: getattr(layout.boxes, name).tolist() for name in _NUMBERS},
            category=layout.boxes.category.tolist(),
        )
        for layout in generate_layouts(count, seed)
    ]


def test_rows_become_boxes_again_empty_ones_too() -> None:
    for layout, row in zip(generate_layouts(60, 1), rows(1), strict=True):
        boxes = boxes_of(row)
        assert np.array_equal(boxes.category, layout.boxes.category)
        assert np.array_equal(boxes.location, layout.boxes.location)


def test_the_same_frames_are_no_distance_apart_and_others_are() -> None:
    sample = Sample.of([boxes_of(row) for row in rows(0)])
    other = Sample.of([boxes_of(row) for row in rows(5)])
    same = compare(sample, sample)
    assert set(same) == set(COMPARED)
    assert all(each.distance == 0.0 for each in same.values())
    apart = compare(other, sample)
    assert all(each.distance is not None and each.distance > 0.0 for each in apart.values())
    assert sum(apart["occlusion"].ours) == pytest.approx(1.0, abs=1e-3)


def test_summary_counts_both() -> None:
    kitti = Sample.of([boxes_of(row) for row in rows(3, 80)])
    result = summary(rows(2, 30), kitti)
    assert (result.frames, result.kitti_frames) == (30, 80)
