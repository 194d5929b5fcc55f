import dataclasses

import numpy as np
import pytest

from avsec_gym.world.road.overlay import Overlay, paint_overlay
from avsec_gym.world.road.surface import painted_edges
from avsec_gym.world.section import Line, LineKind
from avsec_gym.world.site import Style

START, END = -30.0, 90.0


def pixels(overlay, along, left):
    """Values at road coordinates, as the docstring of `Overlay` states."""
    column = np.floor((np.asarray(along) - overlay.start) / overlay.metres_per_pixel).astype(int)
    row = np.floor((overlay.top - np.asarray(left)) / overlay.metres_per_pixel).astype(int)
    return overlay.picture[row, column].astype(float)


def painted(overlay, along, left):
    """Share of places that are white."""
    values = pixels(overlay, along, left)
    return ((values[..., :3].min(-1) > 180) & (values[..., 3] > 60)).mean()


def with_lines(make_site, *lines):
    place = make_site(Style.RURAL)
    section = dataclasses.replace(place.section, lines=lines)
    return dataclasses.replace(place, section=section)


@pytest.mark.parametrize("seed", range(4))
def test_lines_lie_at_their_offsets(make_site, seed):
    place = with_lines(
        make_site, Line(LineKind.SOLID, 0.7, 0.12), Line(LineKind.DASHED, -0.7, 0.12)
    )
    overlay = paint_overlay(place, START, END, np.random.default_rng(seed))
    along = np.arange(START + 1, END - 1, 0.5)
    assert painted(overlay, along, np.full_like(along, 0.7)) > 0.8
    for left in (0.6, 0.8):
        assert painted(overlay, along, np.full_like(along, left)) < 0.05
    dash, gap = along[along % 9.0 < 2.9], along[along % 9.0 > 3.1]
    assert painted(overlay, dash, np.full_like(dash, -0.7)) > 0.8
    assert painted(overlay, gap, np.full_like(gap, -0.7)) < 0.05


def test_dashes_are_longer_on_highways(make_site):
    place = dataclasses.replace(
        with_lines(make_site, Line(LineKind.DASHED, 0.7, 0.15)), style=Style.HIGHWAY
    )
    overlay = paint_overlay(place, START, END, np.random.default_rng(1))
    along = np.arange(START + 1, END - 1, 0.25)
    dash, gap = along[along % 18.0 < 5.9], along[along % 18.0 > 6.1]
    assert painted(overlay, dash, np.full_like(dash, 0.7)) > 0.8
    assert painted(overlay, gap, np.full_like(gap, 0.7)) < 0.05


def test_a_double_line_is_two(make_site):
    overlay = paint_overlay(
        with_lines(make_site, Line(LineKind.DOUBLE, 0.5)), START, END, np.random.default_rng(1)
    )
    along = np.arange(START + 1, END - 1, 0.5)
    assert painted(overlay, along, np.full_like(along, 0.5)) < 0.05
    for left in (0.38, 0.62):
        assert painted(overlay, along, np.full_like(along, left)) > 0.8


@pytest.mark.parametrize("style", list(Style))
def test_every_style_is_painted_the_same_again_and_with_measure(make_site, style):
    place = make_site(style, mouth=True)
    one, two = (paint_overlay(place, START, END, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one.picture, two.picture)
    right, left = painted_edges(place.section)
    assert one.top == left
    assert one.picture.shape[0] * one.metres_per_pixel >= left - right
    assert one.picture.shape[1] * one.metres_per_pixel >= END - START
    alpha = one.picture[..., 3].mean() / 255.0
    assert 0.005 < alpha < 0.35


def test_long_drives_stay_within_memory(make_site):
    overlay = paint_overlay(make_site(Style.HIGHWAY), -40.0, 1500.0, np.random.default_rng(0))
    assert sum(level.nbytes for level in overlay.levels()) < 66e6


def test_levels_are_means_of_light_times_alpha():
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (32, 64, 4)).astype(np.uint8)
    levels = Overlay(picture, 0.0, 0.0, 0.025).levels()
    assert [level.shape[:2] for level in levels[:3]] == [(32, 64), (16, 32), (8, 16)]
    light = (picture[..., :3] / 255.0) ** 2.2 * picture[..., 3:] / 255.0
    for level in levels[:4]:
        np.testing.assert_allclose((level[..., :3] / 255.0) ** 2.2, light, atol=0.02)
        light = 0.25 * (light[::2, ::2] + light[1::2, ::2] + light[::2, 1::2] + light[1::2, 1::2])
    assert levels[-1][..., 3].mean() == pytest.approx(picture[..., 3].mean(), abs=2)
