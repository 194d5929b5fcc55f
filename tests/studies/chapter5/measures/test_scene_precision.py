"""Average precision of a single scene: curves drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from studies.chapter5.measures.scene_precision import scene_precision


def car(x: float = 0.0, z: float = 15.0, score: float = 1.0) -> Boxes3D:
    """Along the lane, 4 m long and 1.65 m wide."""
    return Boxes3D([[x, 1.65, z]], [[1.5, 1.65, 4.0]], [-np.pi / 2], [score], ["Car"])


def boxes(*parts: Boxes3D) -> Boxes3D:
    return Boxes3D.concatenate(parts) if parts else Boxes3D.empty()


def test_curves_by_hand() -> None:
    near, far = car(z=12.0), car(z=30.0)
    truth = boxes(near, far)

    def of(*seen: tuple[float, float]) -> float:
        seen_boxes = boxes(*(car(z=z, score=score) for z, score in seen))
        return scene_precision(truth, seen_boxes, 0.5)

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


def test_the_overlap_decides_and_no_car_is_nothing() -> None:
    truth, shifted = boxes(car(z=12.0)), boxes(car(z=13.0, score=0.9))
    # Of 4 m length 1 m aside: 3 of 5.
    assert scene_precision(truth, shifted, 0.59) == 1
    assert scene_precision(truth, shifted, 0.61) == 0
    assert np.isnan(scene_precision(boxes(), shifted, 0.5))
