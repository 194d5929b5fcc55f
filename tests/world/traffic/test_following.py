"""Few vehicles on a straight street, whose behaviour is known beforehand."""

import numpy as np
import pytest

from avsec_gym.world.actors import Instant
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.models.people import stride_length
from avsec_gym.world.site import Site
from avsec_gym.world.traffic import Population, run
from avsec_gym.world.traffic.driving import Manners, equilibrium_gap
from avsec_gym.world.traffic.pavements import WIDTH
from avsec_gym.world.traffic.population import Traveller
from avsec_gym.world.traffic.roads import main_route
from avsec_gym.world.traffic.routes import Route, along_course
from avsec_gym.world.traffic.state import MANNERS

CAR = (1.5, 1.7, 4.0)
PERSON = (1.75, 0.6, 0.8)
NO_WEAVE = (0.0, 75.0, 0.0)


def car(place: float, speed: float, desired: float = 14.0, **more: object) -> Traveller:
    return Traveller("Car", CAR, 0, place, speed, desired, NO_WEAVE)._replace(**more)


def drive(
    site: Site, routes: list[Route], travellers: list[Traveller], duration: float
) -> list[Instant]:
    population = Population(
        tuple(routes),
        np.full((len(routes), 2), -1),
        tuple(travellers),
        (),
        (0,),
        np.zeros(len(travellers), np.int64),
        np.zeros(len(travellers)),
    )
    return run(site, population, duration)


def column(instants: list[Instant], name: str, actor: int) -> np.ndarray:
    return np.array([getattr(each.actors, name)[each.actors.id == actor][0] for each in instants])


def test_a_car_behind_a_standing_one_stops_before_it(street: Site) -> None:
    lane = main_route(street, -1.75, 1)
    standing = car(600.0, 0.0, pause=(0.0, 1e9))
    instants = drive(street, [lane], [car(480.0, 14.0), standing], 25.0)
    gap = column(instants, "pose", 1)[:, 0] - column(instants, "pose", 0)[:, 0] - 4.0
    speed = column(instants, "speed", 0)
    assert 1.0 < gap[-1] < 4.0
    assert gap.min() > 1.0
    assert speed[-1] == 0.0
    assert np.diff(speed).min() > -0.5, "it stops comfortably"
    assert np.ptp(column(instants, "pose", 1), axis=0).max() == 0.0


def test_the_gap_behind_a_steady_leader_is_that_of_the_formula(street: Site) -> None:
    lane = main_route(street, -1.75, 1)
    instants = drive(street, [lane], [car(330.0, 8.0), car(360.0, 8.0, desired=8.0)], 35.0)
    gap = column(instants, "pose", 1)[:, 0] - column(instants, "pose", 0)[:, 0] - 4.0
    manners = Manners(*map(np.array, MANNERS["Car"]))
    assert gap[-1] == pytest.approx(float(equilibrium_gap(8.0, 14.0, manners)), rel=0.03)
    assert column(instants, "speed", 0)[-1] == pytest.approx(8.0, abs=0.1)


def test_a_free_car_comes_as_far_as_its_speed_says(street: Site) -> None:
    instants = drive(street, [main_route(street, -1.75, 1)], [car(400.0, 14.0)], 5.0)
    way = np.diff(column(instants, "pose", 0)[:, 0])
    assert way == pytest.approx(1.4, abs=1e-3)
    assert [instant.time for instant in instants] == pytest.approx(0.1 * np.arange(51))


def crossing_person(opens: float, polite: bool) -> tuple[Route, Traveller]:
    """A person who waits at the right kerb, 60 m ahead of a car at 440 m on its route."""
    line = course_from_curvature(np.zeros(61), pose=(50.0, -12.0, np.pi / 2))
    route = Route(along_course(line), WIDTH, gate=7.4, clear=18.0)
    person = Traveller("Pedestrian", PERSON, 1, 6.9, 0.0, 1.4, (0.0, 5.0, 0.0))
    return route, person._replace(opens=opens, polite=polite)


def test_a_polite_person_lets_a_car_pass_before_crossing(street: Site) -> None:
    route, person = crossing_person(0.0, True)
    instants = drive(
        street, [main_route(street, -1.75, 1), route], [car(460.0, 14.0), person], 20.0
    )
    assert column(instants, "speed", 0).min() > 13.5
    passed = column(instants, "pose", 0)[:, 0] > 50.0
    on_road = column(instants, "pose", 1)[:, 1] > -3.9
    assert on_road[-1]
    assert not (on_road & ~passed).any()


def test_a_car_stops_for_a_pedestrian_on_the_road(street: Site) -> None:
    route, person = crossing_person(0.0, False)
    instants = drive(
        street, [main_route(street, -1.75, 1), route], [car(436.0, 14.0), person], 25.0
    )
    car_x, person_y = column(instants, "pose", 0)[:, 0], column(instants, "pose", 1)[:, 1]
    in_lane = (person_y > -3.5) & (person_y < 0.0)
    assert in_lane.any()
    assert (car_x[in_lane] < 50.0 - 2.0).all()
    assert column(instants, "speed", 0).min() < 8.0
    assert car_x[-1] > 60.0, "and goes on"


def test_no_traveller_passes_a_gate_before_it_opens(street: Site) -> None:
    lane = main_route(street, -1.75, 1)
    red = Route(lane.poses, lane.width, gate=500.0, clear=505.0, shown=lane.shown)
    instants = drive(street, [red], [car(400.0, 14.0, opens=15.0)], 20.0)
    front = column(instants, "pose", 0)[:, 0] + 452.0
    before = np.array([instant.time < 15.0 for instant in instants])
    assert front[before].max() < 500.0
    assert front[before].max() > 498.0
    assert front[-1] > 505.0


def test_steps_follow_the_way_that_a_person_walks(street: Site) -> None:
    route = Route(along_course(street.course, -5.0), WIDTH)
    walker = Traveller("Pedestrian", PERSON, 0, 150.0, 1.4, 1.4, (0.0, 5.0, 0.0))
    instants = drive(street, [route], [walker], 2.0)
    cycles = np.unwrap(column(instants, "phase", 0), period=1.0)
    assert cycles[10] == pytest.approx(1.4 / stride_length(PERSON[0]))
    assert cycles[5] == pytest.approx(0.5 * cycles[10])
    assert column(instants, "z", 0) == pytest.approx(0.12)
