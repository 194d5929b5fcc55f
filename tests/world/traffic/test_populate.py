import numpy as np
import pytest

from avsec_gym.world.site import Site, Style
from avsec_gym.world.sites import draw_site
from avsec_gym.world.traffic import populate
from avsec_gym.world.traffic.pavements import make_way, pavements_of, walking_route
from avsec_gym.world.traffic.population import Bystander


@pytest.mark.parametrize("style", list(Style))
def test_there_are_empty_and_full_places(style: Style) -> None:
    counts = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        counts.append(len(populate(draw_site(style, rng, length=250.0), rng)))
    assert max(counts) > 3 * min(counts)
    assert max(counts) > 12


def test_only_ego_vehicles_at_density_zero() -> None:
    for style in Style:
        rng = np.random.default_rng(0)
        site = draw_site(style, rng, length=250.0)
        assert len(populate(site, rng, density=0.0, egos=2)) == 2


def test_a_campus_has_more_people_than_cars_and_a_highway_none() -> None:
    people = dict.fromkeys(Style, 0)
    moving_cars = dict(people)
    for style in Style:
        for seed in range(8):
            rng = np.random.default_rng(seed)
            population = populate(draw_site(style, rng, length=200.0), rng)
            categories = [traveller.category for traveller in population.travellers]
            people[style] += sum(each in ("Pedestrian", "Cyclist") for each in categories)
            moving_cars[style] += sum(each == "Car" for each in categories)
    assert people[Style.HIGHWAY] == 0
    assert people[Style.CAMPUS] > moving_cars[Style.CAMPUS]
    assert people[Style.CAMPUS] > people[Style.RURAL]


def test_lines_on_a_pavement_lead_around_whoever_stands_there(street: Site) -> None:
    pavement = pavements_of(street, np.random.default_rng(0))[0]
    standing = Bystander("Pedestrian", (1.75, 0.6, 0.6), (40.0, -6.5, 0.0))
    way, refused = make_way(street, pavement, [standing])
    assert refused == []
    for line in range(len(way.directions)):
        poses = walking_route(street, way, line).poses
        assert np.hypot(poses[:, 0] - 40.0, poses[:, 1] + 6.5).min() > 0.7
        assert np.abs(np.diff(poses[:, 2])).max() < 0.25
    blocking = Bystander("Car", (1.5, 1.7, 4.0), (80.0, -5.5, 0.0))
    assert make_way(street, pavement, [standing, blocking])[1] == [1]
