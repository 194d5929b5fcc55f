"""Boxes as actions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.box_coding import BoxCoding


def boxes(count: int, seed: int = 0) -> Boxes3D:
    rng = np.random.default_rng(seed)
    return Boxes3D(
        location=rng.uniform([-30, 0, 2], [30, 3, 70], (count, 3)),
        dimensions=rng.uniform([1.2, 1.4, 3.0], [2.0, 2.0, 5.0], (count, 3)),
        rotation_y=rng.uniform(-9.0, 9.0, count),
        score=rng.uniform(0.1, 1.0, count),
        category=np.full(count, "Car"),
    )


def test_what_is_encoded_is_decoded_best_first() -> None:
    made = boxes(7)
    order = np.argsort(-made.score)
    back = BoxCoding(20).decode(BoxCoding(20).encode(made))
    np.testing.assert_allclose(back.location, made.location[order], atol=1e-4)
    np.testing.assert_allclose(back.dimensions, made.dimensions[order], atol=1e-5)
    np.testing.assert_allclose(back.score, made.score[order], atol=1e-6)
    turned = back.rotation_y - made.rotation_y[order]
    np.testing.assert_allclose(np.exp(1j * turned), 1.0, atol=1e-5)


def test_the_best_ones_are_kept_where_there_is_no_room() -> None:
    made = boxes(9)
    back = BoxCoding(4).decode(BoxCoding(4).encode(made))
    np.testing.assert_allclose(back.score, np.sort(made.score)[::-1][:4], atol=1e-6)


def test_an_idle_action_is_no_box_and_every_action_is_one_that_fits() -> None:
    coding = BoxCoding(5)
    assert len(coding.decode(np.full(coding.size, -1.0))) == 0
    assert np.abs(coding.encode(Boxes3D.empty())).max() == 1.0
    any_action = coding.decode(np.random.default_rng(1).uniform(-1, 1, coding.size))
    assert (any_action.dimensions > 0).all()


@pytest.mark.parametrize("score", [0.0, -2.0])
def test_scores_of_zero_and_less_are_no_boxes(score: float) -> None:
    made = boxes(3)
    made = replace(made, score=np.where(np.arange(3) == 1, score, made.score))
    assert len(BoxCoding(5).decode(BoxCoding(5).encode(made))) == 2
