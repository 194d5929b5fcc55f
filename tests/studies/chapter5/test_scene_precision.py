"""Average precision of a single scene: curves drawn by hand."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from studies.chapter5.scene_precision import scene_precision


def test_curves_by_hand(made: ModuleType) -> None:
    near, far = made.car(z=12.0), made.car(z=30.0)
    truth = made.boxes(near, far)

    def of(*seen: tuple[float, float]) -> float:
        boxes = made.boxes(*(made.car(z=z, score=score) for z, score in seen))
        return scene_precision(truth, boxes, 0.5)

    assert of((12.0, 0.9), (30.0, 0.8)) == 1
    assert of((12.0, 0.9)) == of((30.0, 0.1)) == 0.5
    assert of() == 0
    # A surer box that is none: 2/3 at the second car, which is the best at the first as well.
    assert of((20.0, 0.95), (12.0, 0.9), (30.0, 0.8)) == pytest.approx(2 / 3)
    # Between them: 1 at the first, 2/3 at the second.
    assert of((12.0, 0.9), (20.0, 0.85), (30.0, 0.8)) == pytest.approx((1 + 2 / 3) / 2)
    # After them it costs nothing.
    assert of((12.0, 0.9), (30.0, 0.8), (20.0, 0.1)) == 1
    # A second box on one car is wrong.
    assert of((12.0, 0.9), (12.1, 0.85), (30.0, 0.8)) == pytest.approx((1 + 2 / 3) / 2)


def test_the_overlap_decides_and_no_car_is_nothing(made: ModuleType) -> None:
    truth, shifted = made.boxes(made.car(z=12.0)), made.boxes(made.car(z=13.0, score=0.9))
    # Of 4 m length 1 m aside: 3 of 5.
    assert scene_precision(truth, shifted, 0.59) == 1
    assert scene_precision(truth, shifted, 0.61) == 0
    assert np.isnan(scene_precision(made.boxes(), shifted, 0.5))
