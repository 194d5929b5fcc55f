from collections.abc import Callable

import numpy as np
import pytest
import shapely

from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.ground import Ground
from avsec_gym.world.road.sections import (
    campus_section,
    city_section,
    highway_section,
    residential_section,
    rural_section,
)
from avsec_gym.world.scenery.composition import compose
from avsec_gym.world.scenery.plot import Placement, Plot
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface
from avsec_gym.world.shapes import box
from avsec_gym.world.site import SideStreet, Site, Style

STREET = CrossSection(
    strips=(
        Strip(Surface.PAVEMENT, -6.0, -3.2, 0.12, "slabs"),
        Strip(Surface.KERB, -3.2, -3.0, 0.12),
        Strip(Surface.ROAD, -3.0, 3.0),
        Strip(Surface.PARKING, 3.0, 5.0),
        Strip(Surface.KERB, 5.0, 5.2, 0.12),
        Strip(Surface.PAVEMENT, 5.2, 8.0, 0.12, "slabs"),
    ),
    lines=(),
    lanes=(Lane(-1.5, 1, 13.0), Lane(1.5, -1, 13.0)),
)
SECTIONS: dict[Style, Callable[[np.random.Generator], CrossSection]] = {
    Style.CITY: city_section,
    Style.RESIDENTIAL: residential_section,
    Style.CAMPUS: campus_section,
    Style.HIGHWAY: highway_section,
    Style.RURAL: rural_section,
}
BOX = box(1.0, 1.0, 1.0)


def straight(section: CrossSection = STREET, **more) -> Site:
    course = course_from_curvature(np.zeros(201), start=-50.0)
    return Site(Style.CITY, course, section, Ground((2.0, 0.01, 0.0)), 1, **more)


def put(plot: Plot, along: float, left: float, **how) -> bool:
    return plot.place(BOX, Surface.FURNITURE, along, left, **{"size": (1.0, 1.0), **how})


def test_nothing_stands_on_the_road_and_little_beside_it() -> None:
    plot = Plot(straight(), -40.0, 100.0)
    assert not put(plot, 10.0, 0.0, on_road=True)
    assert not put(plot, 10.0, 3.2, on_road=True)  # half on the carriageway
    assert not put(plot, 10.0, -4.5)  # the pavement only for what belongs there
    assert put(plot, 10.0, -4.5, on_road=True)
    assert put(plot, 10.0, 9.0)
    assert len(plot.placements) == 2


def test_nothing_stands_on_another_or_where_it_must_not() -> None:
    closed = shapely.Point(30.0, 12.0).buffer(3.0)
    plot = Plot(straight(), -40.0, 100.0, [closed])
    assert put(plot, 10.0, 9.0)
    assert not put(plot, 10.6, 9.6)
    assert put(plot, 11.2, 9.0)
    assert not put(plot, 30.0, 9.2)
    assert put(plot, 30.0, 8.6 + 7.5)
    assert not put(plot, 12.0, 14.0, size=(4.0, 4.0), scale=3.0)
    assert put(plot, 60.0, 14.0, size=(4.0, 4.0), scale=2.5)


def test_many_things_stand_clear_of_one_another() -> None:
    rng = np.random.default_rng(0)
    plot = Plot(straight(), -40.0, 100.0)
    for _ in range(900):
        put(plot, rng.uniform(-40, 100), rng.uniform(8, 60), heading=rng.uniform(0, 6))
    assert 300 < len(plot.placements) < 900
    footprints = [
        shapely.convex_hull(shapely.MultiPoint(placement.mesh(0.0).vertices[:, :2]))
        for placement in plot.placements
    ]
    first, second = shapely.STRtree(footprints).query(footprints, predicate="intersects")
    assert (first == second).all()


def test_things_stand_on_the_ground_or_the_pavement_and_houses_on_their_lowest_corner() -> None:
    plot = Plot(straight(), -40.0, 100.0)
    put(plot, 20.0, -4.5, on_road=True)
    put(plot, 20.0, 10.0)
    plot.place(box(10.0, 8.0, 6.0), Surface.BUILDING, 50.0, 20.0, size=(10.0, 8.0), sunk=0.05)
    lamp, bin_, house = (placement.mesh(0.0).bounds[0][2] for placement in plot.placements)
    assert lamp == pytest.approx(2.0 + 0.2 + 0.12, abs=1e-5)
    assert bin_ == pytest.approx(2.2, abs=1e-5)
    assert house == pytest.approx(2.0 + 0.01 * 45.0 - 0.05, abs=1e-5)


def test_a_footprint_lies_where_its_mesh_does() -> None:
    """Houses have their origin in the middle of the facade and reach away from the road."""
    plot = Plot(straight(), -40.0, 100.0)
    house = box(10.0, 8.0, 6.0).placed(0.0, 4.0)
    for side in (1, -1):
        edge = 9.0 if side > 0 else -7.0
        heading = 0.0 if side > 0 else np.pi
        how = {"heading": heading, "size": (10.0, 8.0), "offset": 4.0}
        assert plot.place(house, Surface.BUILDING, 30.0, edge, **how)
        low, high = plot.placements[-1].mesh(0.0).bounds
        np.testing.assert_allclose([low[0], high[0]], [25.0, 35.0], atol=1e-4)
        expected = sorted([edge, edge + side * 8.0])
        np.testing.assert_allclose([low[1], high[1]], expected, atol=1e-4)
        assert not put(plot, 34.0, edge + side * 7.0)
        assert put(plot, 34.0, edge + side * 9.5)


def test_the_mouth_of_a_side_street_stays_open() -> None:
    away = course_from_curvature(np.zeros(61), pose=(30.0, 0.0, np.pi / 2))
    other = CrossSection((Strip(Surface.ROAD, -3.0, 3.0),), (), (Lane(-1.5, 1, 8.0),))
    plot = Plot(straight(side_streets=(SideStreet(30.0, 1, away, other),)), -40.0, 100.0)
    assert not put(plot, 30.0, 20.0)
    assert not put(plot, 30.0, 6.5, on_road=True)
    assert put(plot, 30.0, -7.0)
    assert put(plot, 45.0, 20.0)


def test_pavements_begin_beyond_parked_cars() -> None:
    plot = Plot(straight(), -40.0, 100.0)
    assert plot.kerb(1) == pytest.approx(5.2)
    assert plot.kerb(-1) == pytest.approx(3.2)
    bare = Plot(straight(CrossSection((Strip(Surface.ROAD, -3.0, 4.0),), (), ())), -40.0, 100.0)
    assert (bare.kerb(1), bare.kerb(-1)) == (4.0, 3.0)


def test_added_meshes_stay_where_they_are() -> None:
    plot = Plot(straight(), -40.0, 100.0)
    there = BOX.placed(20.0, -8.0, 1.0, 0.3)
    plot.add(there, Surface.FURNITURE, (20.0, -8.0), 2.0)
    plot.add(there, Surface.FURNITURE, (0.0, 0.0), np.inf)
    near, endless = plot.placements
    assert (near.x, near.y, near.reach) == (20.0, -8.0, 2.0)
    for placement in (near, endless):
        np.testing.assert_allclose(placement.mesh(9.0).vertices, there.vertices, atol=1e-5)


@pytest.fixture(scope="module")
def composed() -> dict[Style, tuple[Site, shapely.Geometry, list[Placement]]]:
    """A bent road of each style with a free line of sight and an actor beside it."""
    result = {}
    for number, style in enumerate(Style):
        section = SECTIONS[style](np.random.default_rng(number))
        bends = 0.006 * np.sin(np.linspace(0.0, 4.0, 221))
        course = course_from_curvature(bends, start=-70.0, pose=(1.0, 2.0, 0.3))
        site = Site(style, course, section, Ground((0.0, 0.01, -0.02)), 40 + number)
        edge = section.edges[1]
        eye, x, y = shapely.Point(1, 2), *course.poses(60.0, edge + 4.0)[:2]
        clear = shapely.convex_hull(shapely.union(eye, shapely.Point(x, y).buffer(1.5)))
        result[style] = (site, clear, compose(site, -50.0, 120.0, [clear]))
    return result


def standing(placements: list[Placement]) -> list[Placement]:
    """Those that found a place of their own, not rails and backdrops."""
    return [placement for placement in placements if np.isfinite(placement.reach)]


@pytest.mark.parametrize("style", list(Style))
def test_every_style_has_what_belongs_to_it(composed, style: Style) -> None:
    _, _, placements = composed[style]
    kinds = [placement.surface for placement in placements]
    assert kinds.count(Surface.VEGETATION) > 10
    built = kinds.count(Surface.BUILDING)
    assert built > 8 if style in (Style.CITY, Style.RESIDENTIAL) else built < 25
    assert kinds.count(Surface.FURNITURE) >= 3


@pytest.mark.parametrize("style", list(Style))
def test_scenery_stands_off_roads_and_lines_of_sight(composed, style: Style) -> None:
    site, clear, placements = composed[style]
    places = np.array([[each.x, each.y] for each in standing(placements) if each.z != 0.0])
    along, left = site.course.coordinates(*places.T)
    inside = (along > -50) & (along < 120)
    off_road = (Surface.ROAD, Surface.PARKING, Surface.CYCLE_PATH)
    assert not np.isin(site.section.surface(left[inside]), off_road).any()
    assert not shapely.contains_xy(clear, *places.T).any()


@pytest.mark.parametrize("style", list(Style))
def test_the_same_site_has_the_same_scenery(composed, style: Style) -> None:
    site, clear, placements = composed[style]
    again = compose(site, -50.0, 120.0, [clear])
    assert len(again) == len(placements)
    for one, two in zip(placements, again, strict=True):
        assert (one.x, one.y, one.z, one.yaw, one.scale) == (
            two.x,
            two.y,
            two.z,
            two.yaw,
            two.scale,
        )
        assert one.surface is two.surface
    for index in np.linspace(0, len(placements) - 1, 7).astype(int):
        one, two = placements[index].mesh(20.0), again[index].mesh(20.0)
        np.testing.assert_array_equal(one.vertices, two.vertices)
        assert one.materials == two.materials


def test_houses_do_not_stand_in_one_another(composed) -> None:
    for style in (Style.CITY, Style.RESIDENTIAL):
        houses = [each for each in standing(composed[style][2]) if each.surface is Surface.BUILDING]
        plans = []
        for house in houses:
            mesh = house.mesh(0.0)
            low = mesh.vertices[mesh.vertices[:, 2] < mesh.bounds[0][2] + 2.5]
            plans.append(shapely.convex_hull(shapely.MultiPoint(low[:, :2])))
        first, second = shapely.STRtree(plans).query(plans, predicate="intersects")
        for i, j in zip(first, second, strict=True):
            if i < j:
                common = shapely.area(shapely.intersection(plans[i], plans[j]))
                assert common < 0.08 * min(plans[i].area, plans[j].area)


def test_nothing_solid_reaches_into_the_way_of_traffic() -> None:
    """Houses, lamps, signs, rails and gantries leave the lanes free up to 2.2 m."""
    for style in (Style.CITY, Style.HIGHWAY, Style.RURAL):
        for seed in range(4):
            section = SECTIONS[style](np.random.default_rng(seed))
            course = course_from_curvature(np.zeros(201), start=-60.0)
            site = Site(style, course, section, Ground(), seed)
            for placed in compose(site, -50.0, 120.0):
                if placed.surface not in (Surface.BUILDING, Surface.FURNITURE):
                    continue
                spots = placed.mesh(60.0).vertices
                spots = spots[(spots[:, 2] > 0.15) & (spots[:, 2] < 2.2)]
                for lane in section.lanes:
                    in_lane = np.abs(spots[:, 1] - lane.left) < 0.5 * lane.width - 0.2
                    in_lane &= (spots[:, 0] > -50) & (spots[:, 0] < 120)
                    assert not in_lane.any(), (style, seed, placed.surface)
