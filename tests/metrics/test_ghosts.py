"""Ghosts stand for nothing real, wherever that is labelled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.ghosts import ghosts, iou_from_above


def cars(
    *x_and_z: tuple[float, float],
    category: str = "Car",
    box2d: NDArray[np.float64] | None = None,
) -> Boxes3D:
    count = len(x_and_z)
    location = np.array([[x, 1.65, z] for x, z in x_and_z]).reshape(-1, 3)
    sizes = np.tile([1.5, 1.6, 4.0], (count, 1))
    heading = np.full(count, -np.pi / 2)  # They look ahead.
    return Boxes3D(location, sizes, heading, np.ones(count), np.full(count, category), box2d)


def test_a_ghost_overlaps_nothing_real() -> None:
    truth = cars((0, 20), (5, 30))
    found = cars((0.5, 21), (0, 26), (-5, 20))  # Drifted; behind a real one; anywhere.
    assert ghosts(found, truth).tolist() == [False, True, True]
    assert ghosts(found, Boxes3D.empty()).all()
    assert ghosts(Boxes3D.empty(), truth).shape == (0,)


def test_other_categories_are_real_too() -> None:
    assert not ghosts(cars((0, 20)), cars((0, 20), category="Van")).any()


def test_what_lies_in_a_region_not_to_care_about_is_no_ghost() -> None:
    region = cars((0, 500), category="DontCare", box2d=np.array([[100.0, 100, 200, 200]]))
    inside, half, outside = [110, 110, 150, 150], [180, 110, 240, 150], [300, 110, 340, 150]
    found = cars((0, 20), (3, 20), (6, 20), box2d=np.array([inside, half, outside], float))
    assert ghosts(found, region).tolist() == [False, True, True]


def test_overlaps_from_above_do_not_ask_how_high_a_box_is() -> None:
    one, other = cars((0, 20)), cars((0, 21))
    # Of 4 m length 1 m apart: 3 of 5; one of them is lifted.
    lifted = Boxes3D(
        other.location - np.array([0, 9.0, 0]),
        other.dimensions,
        other.rotation_y,
        other.score,
        ["Car"],
    )
    np.testing.assert_allclose(iou_from_above(one, lifted), [[0.6]])
