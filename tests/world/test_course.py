import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.world.course import Course, course_from_curvature
from avsec_gym.world.section import CrossSection, Lane, Line, LineKind, Strip, Surface

bends = st.lists(st.floats(-0.02, 0.02), min_size=3, max_size=6)


def winding(knots: list[float], pose: tuple[float, float, float]) -> Course:
    curvature = np.interp(np.linspace(0, 1, 201), np.linspace(0, 1, len(knots)), knots)
    return course_from_curvature(curvature, start=-60.0, pose=pose)


def test_constant_curvature_is_a_circle() -> None:
    course = course_from_curvature(np.full(161, 0.02), start=-10.0, pose=(3.0, 4.0, 0.5))
    along = np.linspace(-10, 150, 55)
    x, y, heading = course.poses(along, 0.0).T
    np.testing.assert_allclose(heading, 0.5 + 0.02 * along, atol=1e-9)
    np.testing.assert_allclose(x, 3 + 50 * (np.sin(heading) - np.sin(0.5)), atol=5e-3)
    np.testing.assert_allclose(y, 4 - 50 * (np.cos(heading) - np.cos(0.5)), atol=5e-3)
    # The middle of the circle is 50 m to the left, wherever one is.
    centre = course.poses(along, 50.0)[:, :2]
    np.testing.assert_allclose(
        centre, [[3 - 50 * np.sin(0.5), 4 + 50 * np.cos(0.5)]] * 55, atol=0.01
    )


def test_left_is_left() -> None:
    """Of a road that leads north: west."""
    course = course_from_curvature(np.zeros(50), pose=(10.0, 0.0, np.pi / 2))
    np.testing.assert_allclose(course.poses(20.0, 3.0), [7.0, 20.0, np.pi / 2], atol=1e-9)
    np.testing.assert_allclose(course.coordinates(7.0, 20.0), (20.0, 3.0), atol=1e-9)


@given(bends, st.floats(-100, 100), st.floats(-100, 100), st.floats(-3, 3))
def test_the_course_is_as_long_as_its_coordinate_and_passes_its_pose(
    knots: list[float], x: float, y: float, heading: float
) -> None:
    course = winding(knots, (x, y, heading))
    np.testing.assert_allclose(course.poses(0.0, 0.0)[:2], [x, y], atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * (course.poses(0.0, 0.0)[2] - heading)), 1.0, atol=1e-9)
    line = course.poses(np.linspace(course.start, course.end, 4001), 0.0)
    length = np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1).sum()
    assert length == pytest.approx(course.end - course.start, rel=1e-4)
    steps = np.diff(line[:, :2], axis=0)
    middle = 0.5 * (line[1:, 2] + line[:-1, 2])
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    assert np.abs(np.angle(np.exp(1j * (direction - middle)))).max() < 0.02


@given(bends, st.floats(-59, 139), st.floats(-12, 12))
def test_coordinates_lead_back_to_the_place(knots: list[float], along: float, left: float) -> None:
    course = winding(knots, (5.0, -8.0, 1.2))
    x, y, _ = course.poses(along, left)
    found = course.coordinates(x, y)
    np.testing.assert_allclose(found, (along, left), atol=0.004)


@given(st.floats(-300, 300), st.floats(-20, 20), st.booleans())
def test_beyond_its_ends_the_road_runs_on_straight(along: float, left: float, curved: bool) -> None:
    course = course_from_curvature(np.full(81, 0.01 if curved else 0.0), start=-20.0)
    if -20 <= along <= 60:
        return
    end = -20.0 if along < 0 else 60.0
    x, y, heading = course.poses(end, 0.0)
    beyond = along - end
    expected = (
        x + beyond * np.cos(heading) - left * np.sin(heading),
        y + beyond * np.sin(heading) + left * np.cos(heading),
    )
    found = course.poses(along, left)
    np.testing.assert_allclose(found[:2], expected, atol=0.006 * abs(beyond) + 1e-6)
    assert found[2] == pytest.approx(heading)
    np.testing.assert_allclose(
        course.coordinates(*found[:2]), (along, left), atol=0.006 * abs(beyond) + 0.02
    )


def test_shapes_follow_the_inputs() -> None:
    course = course_from_curvature(np.zeros(50))
    assert course.poses(np.zeros((3, 1)), np.zeros(4)).shape == (3, 4, 3)
    along, left = course.coordinates(np.zeros((2, 3)), np.ones((2, 3)))
    assert along.shape == left.shape == (2, 3)
    many = np.random.default_rng(0).uniform(0, 49, 50_000)
    np.testing.assert_allclose(course.coordinates(many, 0 * many)[0], many, atol=1e-9)


SECTION = CrossSection(
    strips=(
        Strip(Surface.PAVEMENT, -6.0, -3.2, 0.12, "slabs"),
        Strip(Surface.KERB, -3.2, -3.0, 0.12, "kerb"),
        Strip(Surface.ROAD, -3.0, 3.0),
        Strip(Surface.VERGE, 3.0, 5.0, 0.02, "grass"),
        Strip(Surface.ROAD, 5.0, 8.0),
        Strip(Surface.CYCLE_PATH, 8.0, 9.5, 0.05),
    ),
    lines=(Line(LineKind.DASHED, 0.0),),
    lanes=(Lane(-1.5, 1, 13.0), Lane(1.5, -1, 13.0)),
)


def test_a_section_knows_what_lies_where_and_how_high() -> None:
    places = [-7.0, -5.0, -3.1, -2.9, 2.9, 4.0, 7.0, 9.0, 10.0]
    expected = [
        Surface.TERRAIN, Surface.PAVEMENT, Surface.KERB, Surface.ROAD, Surface.ROAD,
        Surface.VERGE, Surface.ROAD, Surface.CYCLE_PATH, Surface.TERRAIN,
    ]  # fmt: skip
    assert SECTION.surface(places).tolist() == expected
    np.testing.assert_allclose(SECTION.height(places), [0, 0.12, 0.12, 0, 0, 0.02, 0, 0.05, 0])
    assert SECTION.height(np.zeros((2, 3))).shape == (2, 3)
    assert SECTION.edges == (-6.0, 9.5)
    assert SECTION.carriageway == (-3.0, 8.0)
