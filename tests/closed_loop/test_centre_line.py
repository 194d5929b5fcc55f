"""Distances along a line and beside it."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from avsec_gym.closed_loop.centre_line import CentreLine

ANGLES = np.linspace(0.0, 1.0, 101)
CIRCLE = CentreLine(np.column_stack([50.0 * np.sin(ANGLES), 50.0 * (1 - np.cos(ANGLES))]))
"""A bend to the left with a radius of 50 m."""


@pytest.mark.parametrize("line", [CIRCLE, CentreLine(np.array([[1.0, 2.0], [4.0, 6.0]]))])
@pytest.mark.parametrize("along", [-7.0, 2.2, 20.0, 60.0])
def test_places_and_coordinates_are_inverse(line: CentreLine, along: float) -> None:
    for left in (-1.0, 0.0, 2.5):
        found = line.coordinates(*line.place(along, left))
        np.testing.assert_allclose(found, (along, left), atol=0.05)


def test_a_bend_has_the_length_and_the_headings_of_its_circle() -> None:
    assert CIRCLE.length == pytest.approx(50.0, abs=1e-3)
    assert CIRCLE.heading(25.0) == pytest.approx(0.5, abs=1e-3)
    x, y = CIRCLE.place(25.0, 10.0)
    assert np.hypot(x, y - 50.0) == pytest.approx(40.0, abs=0.01)


def test_straight_and_bent_code_agree() -> None:
    straight = CentreLine(np.array([[0.0, 0.0], [30.0, 40.0]]))
    same = CentreLine(np.array([[0.0, 0.0], [15.0, 20.0], [30.0, 40.0]]))
    for x, y in ((-3.0, 1.0), (10.0, 20.0), (50.0, 40.0)):
        np.testing.assert_allclose(straight.coordinates(x, y), same.coordinates(x, y), atol=1e-9)
    assert straight.heading(4.0) == pytest.approx(same.heading(4.0))


def test_the_nearest_point_is_shapelys() -> None:
    draw = np.random.default_rng(6)
    points = np.cumsum(draw.uniform(0.5, 3.0, (30, 2)) * (1.0, 0.4), axis=0)
    line, same = CentreLine(points), shapely.LineString(points)
    for along in draw.uniform(5.0, line.length - 5.0, 200):
        x, y = line.place(along, draw.uniform(-4.0, 4.0))
        found, left = line.coordinates(x, y)
        point = shapely.Point(x, y)
        assert found == pytest.approx(same.project(point), abs=1e-9)
        assert abs(left) <= same.distance(point) + 1e-9
