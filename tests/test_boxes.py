"""The container for labels and detections."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import fields, replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from tests.strange_values import STRANGE


def some_boxes(count: int = 3, **optional: object) -> Boxes3D:
    return Boxes3D(
        location=np.arange(3.0 * count).reshape(count, 3),
        dimensions=np.tile([1.5, 1.6, 3.9], (count, 1)),
        rotation_y=np.zeros(count),
        score=np.linspace(0, 1, count),
        category=np.array(["Car", "Van", "Pedestrian"] * count)[:count],
        **optional,  # type: ignore[arg-type]
    )


def test_size_names_and_poses() -> None:
    boxes = some_boxes()
    assert len(boxes) == 3
    np.testing.assert_array_equal(boxes.length, 3.9)
    np.testing.assert_array_equal(boxes.width, 1.6)
    np.testing.assert_allclose(boxes.poses[1], [5.0, -3.0, -np.pi / 2])


def test_picking_keeps_every_column_together() -> None:
    boxes = some_boxes(moving=np.array([True, False, True]))
    picked = boxes[np.array([2, 0])]
    assert picked.category.tolist() == ["Pedestrian", "Car"]
    assert picked.moving is not None
    assert picked.moving.tolist() == [True, True]
    assert len(boxes[boxes.score > 0.2]) == 2
    assert boxes[1:].box2d is None


def test_joining_keeps_an_optional_column_that_all_have() -> None:
    flags = np.zeros(3, bool)
    joined = Boxes3D.concatenate([some_boxes(moving=flags), some_boxes(moving=~flags)])
    assert joined.moving is not None
    assert joined.moving.sum() == 3
    assert Boxes3D.concatenate([some_boxes(moving=flags), some_boxes()]).moving is None
    assert len(Boxes3D.concatenate([])) == 0
    assert len(Boxes3D.concatenate([Boxes3D.empty(), some_boxes()])) == 3


def test_wrong_shapes_and_values_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="box2d has shape"):
        some_boxes(box2d=np.zeros((3, 3)))
    with pytest.raises(ConfigurationError, match="moving has shape"):
        some_boxes(moving=np.zeros(2, bool))
    with pytest.raises(ConfigurationError, match="not finite"):
        some_boxes(alpha=np.array([0.0, np.nan, 0.0]))


@pytest.mark.parametrize("name", ["rotation_y", "alpha"])
def test_angles_of_more_turns_than_any_source_gives_are_refused(name: str) -> None:
    """Beyond, sine and cosine are noise: 1e300 rad points anywhere."""
    some_boxes(alpha=np.zeros(3))
    replace(some_boxes(), **{name: np.array([0.0, -100.0, 4 * np.pi])})
    for bad in (100.1, -1e300):
        with pytest.raises(ConfigurationError, match=f"{name} holds an angle of .* radians"):
            replace(some_boxes(), **{name: np.array([0.0, bad, 0.0])})


@pytest.mark.parametrize("name", [field.name for field in fields(Boxes3D)])
def test_whatever_is_no_column_is_refused_by_name(name: str) -> None:
    for value in STRANGE:
        with suppress(ConfigurationError):
            replace(some_boxes(), **{name: value})
    with pytest.raises(ConfigurationError, match="Boxes3D"):
        replace(some_boxes(), **{name: 5})
