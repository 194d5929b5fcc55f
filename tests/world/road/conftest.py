"""Sites for the tests of roads."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.ground import Ground
from avsec_gym.world.road.sections import (
    campus_section,
    city_section,
    highway_section,
    residential_section,
    rural_section,
)
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface
from avsec_gym.world.site import SideStreet, Site, Style

SECTIONS = {
    Style.CITY: city_section,
    Style.RESIDENTIAL: residential_section,
    Style.CAMPUS: campus_section,
    Style.HIGHWAY: highway_section,
    Style.RURAL: rural_section,
}


@pytest.fixture
def make_site() -> Callable[..., Site]:
    """Makes a site of a style, drivable from -30 m to 90 m."""
    return _site


def _site(style: Style, seed: int = 1, *, mouth: bool = False) -> Site:
    """A winding road over a swell, perhaps with a side street on the left at 30 m."""
    bends = 0.012 * np.sin(np.linspace(0.0, 4.0, 161))
    course = course_from_curvature(bends, start=-40.0, pose=(3.0, -5.0, 0.4))
    ground = Ground((1.0, 0.02, -0.01), np.array([[40.0, 10.0, 45.0, 2.0]]))
    section = SECTIONS[style](np.random.default_rng(seed))
    streets = ()
    if mouth:
        x, y, heading = course.poses(30.0, 0.0)
        away = course_from_curvature(np.zeros(61), pose=(x, y, heading + 1.4))
        kerb = [
            Strip(Surface.KERB, 2.75, 2.9, 0.12, "kerb"),
            Strip(Surface.PAVEMENT, 2.9, 4.5, 0.12, "slabs"),
        ]
        other = [Strip(s.surface, -s.left, -s.right, s.height, s.material) for s in kerb[::-1]]
        road = Strip(Surface.ROAD, -2.75, 2.75)
        lanes = (Lane(-1.4, 1, 8.0), Lane(1.4, -1, 8.0))
        streets = (SideStreet(30.0, 1, away, CrossSection((*other, road, *kerb), (), lanes)),)
    return Site(style, course, section, ground, seed, streets)
