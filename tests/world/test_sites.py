import numpy as np
import pytest
import shapely

from avsec_gym.world.site import Style
from avsec_gym.world.sites import draw_site


@pytest.mark.parametrize("style", list(Style))
def test_drawn_places_are_sound_and_differ(style: Style) -> None:
    turns, streets = [], 0
    for seed in range(25):
        site = draw_site(style, np.random.default_rng(seed), length=400.0)
        course = site.course
        assert course.end - course.start == pytest.approx(400.0)
        assert shapely.LineString(course.points).is_simple
        bend = np.abs(np.gradient(course.headings, course.spacing))
        right, left = site.section.edges
        assert bend.max() * max(left, -right) < 0.75, "sides do not fold in bends"
        if style == Style.HIGHWAY:
            assert bend.max() <= 1 / 400 + 1e-9
            assert site.side_streets == ()
        slopes = np.diff(site.ground.height(*course.points.T)) / course.spacing
        assert np.abs(slopes).max() < 0.045
        for street in site.side_streets:
            mouth = course.poses(street.along, 0.0)
            np.testing.assert_allclose(street.course.poses(0.0, 0.0)[:2], mouth[:2], atol=1e-6)
            reach = street.course.poses(street.course.end, 0.0)
            assert course.coordinates(*reach[:2])[1] * street.side > max(left, -right) + 10
        turns.append(np.ptp(course.headings))
        streets += len(site.side_streets)
    assert min(turns) < 0.02
    assert max(turns) > 0.2
    assert streets > 5 or style == Style.HIGHWAY


def test_one_seed_draws_one_place() -> None:
    one, two = (draw_site(Style.CITY, np.random.default_rng(4), length=200.0) for _ in range(2))
    np.testing.assert_array_equal(one.course.points, two.course.points)
    assert one.seed == two.seed
    assert one.section == two.section
