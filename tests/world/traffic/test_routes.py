import numpy as np
import pytest

from avsec_gym.geometry import wrap_angle
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.traffic.routes import SPACING, along_course, evenly, join


def test_a_route_beside_a_bend_is_even_and_points_along_itself() -> None:
    bend = course_from_curvature(np.pad(np.full(60, 1 / 40), 10))
    for left, direction in ((3.0, 1), (-5.0, -1)):
        poses = along_course(bend, left, direction, margin=20.0)
        steps = np.diff(poses[:, :2], axis=0)
        assert np.hypot(*steps.T) == pytest.approx(SPACING, abs=1e-3)
        middle = 0.5 * (poses[1:, 2] + poses[:-1, 2])
        assert np.abs(wrap_angle(np.arctan2(steps[:, 1], steps[:, 0]) - middle)).max() < 3e-3


def test_an_arc_stays_an_arc() -> None:
    angles = np.linspace(0.0, np.pi / 2, 9)
    arc = np.stack([10 * np.sin(angles), 10 - 10 * np.cos(angles), angles], axis=-1)
    even = evenly(arc)
    assert np.hypot(even[:, 0], even[:, 1] - 10) == pytest.approx(10.0, abs=1e-3)
    assert SPACING * (len(even) - 1) == pytest.approx(5 * np.pi, abs=SPACING)


@pytest.mark.parametrize("angle", [-1.8, -1.57, -1.2, 1.3, 1.57, 1.9])
def test_a_turn_is_continuous_in_place_heading_and_curvature(angle: float) -> None:
    first = along_course(course_from_curvature(np.zeros(61)))
    crossing = course_from_curvature(np.zeros(61), start=-30.0, pose=(30.0, 0.0, angle))
    poses, begin, end = join(first, along_course(crossing), 8.0, 8.0)
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T) == pytest.approx(SPACING, abs=0.02)
    bend = np.diff(poses[:, 2]) / SPACING
    assert np.abs(bend).max() < 0.4
    assert np.abs(np.diff(bend)).max() < 0.1
    assert poses[-1, 2] == pytest.approx(angle)
    assert 20.0 < begin < end < 42.0
    assert (poses[: int(begin / SPACING), 2] == 0).all()
