from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.world.road.materials import ground_materials, strip_material
from avsec_gym.world.road.sections import (
    campus_section,
    city_section,
    highway_section,
    residential_section,
    rural_section,
    section_for_lanes,
)
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Style
from avsec_gym.world.textures.ground import TEXTURES

SECTIONS = {
    Style.CITY: city_section,
    Style.RESIDENTIAL: residential_section,
    Style.CAMPUS: campus_section,
    Style.HIGHWAY: highway_section,
    Style.RURAL: rural_section,
}


def check(section):
    """No gaps, sensible widths, lanes on the road."""
    for strip, following in pairwise(section.strips):
        assert strip.left == pytest.approx(following.right)
    assert all(strip.left - strip.right > 0.05 for strip in section.strips)
    right, left = section.carriageway
    offsets = [lane.left for lane in section.lanes]
    assert offsets == sorted(offsets)
    assert (section.surface(offsets) == Surface.ROAD).all()
    assert all(right < line.left < left for line in section.lines)
    # Whoever keeps right drives along the course; the others come towards him.
    directions = [lane.direction for lane in section.lanes]
    assert directions == sorted(directions, reverse=True)


@pytest.mark.parametrize("style", list(Style))
@pytest.mark.parametrize("seed", range(25))
def test_sections_are_consistent(style, seed):
    section = SECTIONS[style](np.random.default_rng(seed))
    check(section)
    own = [lane.left for lane in section.lanes if lane.direction == 1]
    assert min(own, key=abs) == pytest.approx(0.0)
    assert all(2.5 <= lane.width <= 3.75 for lane in section.lanes)


@given(
    st.lists(st.floats(2.6, 9.0), max_size=4),
    st.none() | st.floats(2.5, 14.0),
    st.none() | st.floats(2.5, 14.0),
    st.sampled_from(list(Style)),
    st.integers(0, 1000),
)
@settings(max_examples=80)
def test_sections_reach_given_lanes_and_parked_cars(steps, right, left, style, seed):
    offsets = [0.0, *np.cumsum(steps).tolist()]
    parked_right = None if right is None else -right
    parked_left = None if left is None else offsets[-1] + left
    section = section_for_lanes(
        offsets, 3.5, style, np.random.default_rng(seed), parked_right, parked_left
    )
    check(section)
    assert [lane.left for lane in section.lanes] == pytest.approx(offsets)
    if style == Style.HIGHWAY:
        return
    reachable = (Surface.ROAD, Surface.PARKING)
    if parked_right is not None:
        assert section.surface(parked_right + 0.1) in reachable
    if parked_left is not None:
        assert section.surface(parked_left - 0.1) in reachable


@pytest.mark.parametrize("style", list(Style))
def test_every_strip_has_a_texture(make_site, style):
    for seed in range(20):
        place = make_site(style, seed)
        materials = ground_materials(place)
        names = {strip_material(materials, strip).texture for strip in place.section.strips}
        names |= {material.texture for material in materials.values()}
        for name in names:
            family, _, variant = name.partition("/")
            assert int(variant or 0) < TEXTURES[family].variants
