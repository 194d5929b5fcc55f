from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.world.road.canvas import RoadCanvas
from avsec_gym.world.road.paving import paint_paving
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface
from avsec_gym.world.site import Site, Style
from avsec_gym.world.textures.paving import LAYINGS


@pytest.fixture
def paved(make_site: Callable[..., Site]) -> tuple[RoadCanvas, Site]:
    site = make_site(Style.CAMPUS)
    strip = Strip(Surface.ROAD, -3.0, 3.0, 0.0, "slabs")
    section = CrossSection((strip,), (), (Lane(0.0, 1, 8.0),))
    canvas = RoadCanvas(np.zeros((240, 1600, 4), np.uint8), 10.0, 3.0, 40.0)
    return canvas, replace(site, section=section, side_streets=())


def test_each_stone_has_its_shade_and_no_shade_comes_again(paved) -> None:
    canvas, site = paved
    paint_paving(canvas, site, [], np.random.default_rng(0))
    alpha = canvas.picture[..., 3].astype(float)
    assert 0.02 < alpha.std() / 255 < 0.2
    # Half of all neighbouring pixels or more belong to one stone.
    assert (np.diff(alpha, axis=1) == 0).mean() > 0.8
    period = round(4.8 * canvas.scale)
    one, other = alpha[:, :-period].ravel(), alpha[:, period:].ravel()
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.15


def test_other_surfaces_stay_as_they_are(paved) -> None:
    canvas, site = paved
    strip = replace(site.section.strips[0], material="asphalt")
    plain = replace(site, section=replace(site.section, strips=(strip,)))
    paint_paving(canvas, plain, [], np.random.default_rng(0))
    assert not canvas.picture.any()


@pytest.mark.parametrize("name", list(LAYINGS))
def test_layings_fit_their_textures(name: str) -> None:
    from avsec_gym.world.textures.ground import TEXTURES

    size = TEXTURES[name.partition("/")[0]].size
    laying = LAYINGS[name]
    for whole, stone in zip(size, (laying.length, laying.width), strict=True):
        assert whole / stone == pytest.approx(round(whole / stone))
    if laying.stagger:
        assert round(size[1] / laying.width) % 2 == 0
