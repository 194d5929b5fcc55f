"""Votes over boxes, by hand."""

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.defences.box_vote import boxes_by_vote


def _cars(*rows: tuple[float, float, float, float], category: str = "Car") -> Boxes3D:
    """Cars by x, z, rotation_y and score."""
    x, z, turned, score = np.array(rows).reshape(-1, 4).T
    return Boxes3D(
        np.c_[x, np.full_like(x, 1.6), z],
        np.tile([1.5, 1.7, 4.2], (len(x), 1)),
        turned,
        score,
        np.full(len(x), category),
        box2d=np.c_[x, x, x + 1, x + 1],
        alpha=turned,
    )


def test_what_most_looks_have_is_kept_at_the_median_place() -> None:
    looks = [
        _cars((0.0, 20.0, 1.5, 0.9), (8.0, 30.0, 0.0, 0.8)),
        _cars((0.2, 20.4, 1.6, 0.6)),
        _cars((0.1, 22.0, 1.4, 0.3), (-7.0, 15.0, 0.0, 0.95)),
    ]
    (voted,) = (boxes_by_vote(looks),)
    assert voted.location.tolist() == [[pytest.approx(0.1), 1.6, pytest.approx(20.4)]]
    assert voted.rotation_y == pytest.approx([1.5])
    assert voted.alpha == pytest.approx([1.5])
    assert voted.score == pytest.approx([(0.9 + 0.6 + 0.3) / 3])
    assert voted.box2d is not None
    assert voted.box2d[0, 0] == pytest.approx(0.1)


def test_half_of_the_looks_is_not_most() -> None:
    assert len(boxes_by_vote([_cars((0.0, 20.0, 0.0, 0.9)), _cars()])) == 0


def test_two_boxes_of_one_look_are_two_objects_and_one_vote_each() -> None:
    near = _cars((0.0, 20.0, 0.0, 0.9), (0.3, 20.0, 0.0, 0.7))
    assert len(boxes_by_vote([near, near, near])) == 2
    assert len(boxes_by_vote([near, _cars(), _cars()])) == 0


def test_a_look_that_found_nothing_is_one_without_a_vote() -> None:
    look = _cars((0.0, 20.0, 0.1, 0.9))
    for nothing in (Boxes3D.empty(), _cars()):
        (voted,) = (boxes_by_vote([nothing, look, look]),)
        assert voted.score == pytest.approx([0.6])
        assert voted.box2d is not None
        assert voted.alpha is not None
    assert len(boxes_by_vote([Boxes3D.empty(), Boxes3D.empty()])) == 0


def test_other_categories_do_not_vote_for_one_another() -> None:
    car, van = _cars((0.0, 20.0, 0.0, 0.9)), _cars((0.0, 20.0, 0.0, 0.9), category="Van")
    assert len(boxes_by_vote([car, van])) == 0


def test_headings_at_the_seam_have_their_median_there() -> None:
    looks = [_cars((0.0, 20.0, turned, 0.9)) for turned in (np.pi - 0.1, -np.pi + 0.1, np.pi)]
    (turned,) = boxes_by_vote(looks).rotation_y
    assert np.cos(turned) == pytest.approx(-1)


def test_the_best_comes_first_and_alike_looks_are_returned() -> None:
    look = _cars((0.0, 20.0, 0.0, 0.3), (9.0, 30.0, 1.0, 0.9))
    voted = boxes_by_vote([look] * 5)
    assert voted.location[:, 2].tolist() == [30.0, 20.0]
    assert voted.score.tolist() == pytest.approx([0.9, 0.3])
    assert len(boxes_by_vote([_cars(), _cars()])) == 0
