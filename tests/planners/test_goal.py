"""The goal test against shapely, and where a search steers to, against the shapes' boxes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from avsec_gym.errors import PlanningError
from avsec_gym.planners.goal import goal_arrays, reaches, region_box
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Disc, Polygon, Rectangle, Shape

ELL = Polygon(((0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (2.0, 2.0), (2.0, 5.0), (0.0, 5.0)))
SHAPES: dict[str, Shape] = {
    "disc": Disc(2.0, 3.0, -1.0),
    "rectangle": Rectangle(5.0, 2.0, 1.0, 2.0, 0.6),
    "polygon that is not convex": ELL,
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_centre_is_in_the_region_where_shapely_says_so(name: str) -> None:
    shape = SHAPES[name]
    polygon = shape.polygon()
    goals = goal_arrays((Goal((0, 10), (shape,)),))
    x, y = np.random.default_rng(0).uniform(-4.0, 8.0, (2, 1500))
    far = shapely.distance(polygon.boundary, shapely.points(x, y)) > 1e-3  # A disc is a 256-gon.
    for a, b in zip(x[far].tolist(), y[far].tolist(), strict=True):
        inside = bool(shapely.contains_xy(polygon, a, b))
        assert reaches(a, b, 0.0, 5.0, 5, goals) == inside, (a, b)


def test_any_of_several_shapes_of_any_of_several_goals_will_do() -> None:
    goals = goal_arrays(
        (Goal((0, 4), (Disc(1.0, 0.0, 0.0), Disc(1.0, 10.0, 0.0))), Goal((6, 9), (ELL,)))
    )
    seen = {
        (x, y, step): bool(reaches(x, y, 0.0, 5.0, step, goals))
        for x, y in ((0.5, 0.0), (10.5, 0.5), (1.0, 4.5), (20.0, 0.0))
        for step in (4, 5, 6, 9, 10)
    }
    assert [place for place, inside in seen.items() if inside] == [
        (0.5, 0.0, 4),
        (0.5, 0.0, 6),  # A corner of the L lies in the first disc.
        (0.5, 0.0, 9),
        (10.5, 0.5, 4),
        (1.0, 4.5, 6),
        (1.0, 4.5, 9),
    ]


def test_ends_of_intervals_belong_to_them() -> None:
    goals = goal_arrays((Goal((2, 5), None, heading=(-0.5, 0.25), velocity=(3.0, 7.0)),))

    def found(heading: float = 0.0, velocity: float = 5.0, step: int = 3) -> bool:
        return bool(reaches(1e3, -1e3, heading, velocity, step, goals))

    assert [found(step=step) for step in range(1, 7)] == [False, True, True, True, True, False]
    assert [found(velocity=v) for v in (2.99, 3.0, 7.0, 7.01)] == [False, True, True, False]
    assert [found(h) for h in (-0.51, -0.49, 0.24, 0.26)] == [False, True, True, False]
    # Whole turns make no difference.
    assert [found(h + 2 * np.pi) for h in (-0.51, -0.49, 0.24)] == [False, True, True]
    assert [found(h - 4 * np.pi) for h in (-0.49, 0.24, 0.26)] == [True, True, False]


def test_a_heading_interval_of_a_whole_turn_is_any_heading() -> None:
    goals = goal_arrays((Goal((0, 5), None, heading=(-np.pi, np.pi)),))
    assert all(reaches(0.0, 0.0, h, 1.0, 1, goals) for h in np.linspace(-10, 10, 41).tolist())


@pytest.mark.parametrize("name", SHAPES)
def test_the_box_of_a_region_is_that_of_its_shape(name: str) -> None:
    shape = SHAPES[name]
    x1, y1, x2, y2 = shape.polygon().bounds
    assert region_box((shape,)) == pytest.approx((x1, x2, y1, y2), abs=1e-3)


def test_the_box_of_a_region_holds_all_its_shapes() -> None:
    box = region_box((Disc(1.0, -5.0, 0.0), Disc(2.0, 4.0, 6.0)))
    assert box == pytest.approx((-6.0, 6.0, -1.0, 8.0))
    assert region_box(None) == (-np.inf, np.inf, -np.inf, np.inf)


def test_reference_mode_steers_for_one_shape_s_box_or_for_the_first_one_s_centre() -> None:
    rectangle, disc = Rectangle(4.0, 2.0, 10.0, 1.0), Disc(1.0, 5.0, 6.0)
    aims = [
        goal_arrays((Goal((0, 5), region),)).aim.tolist()
        for region in ((rectangle,), (disc,), (rectangle, disc), None)
    ]
    assert aims[0] == pytest.approx([8.0, 12.0, 0.0, 2.0])
    assert aims[1] == pytest.approx([5.0, 5.0, 6.0, 6.0])
    assert aims[2] == pytest.approx([10.0, 10.0, 1.0, 1.0])
    assert aims[3] == [0.0, 0.0, 0.0, 0.0]


def test_a_problem_without_goal_is_refused() -> None:
    with pytest.raises(PlanningError, match="at least one goal"):
        goal_arrays(())
