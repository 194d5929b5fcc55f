"""What holds for all traffic, whatever the site."""

import hashlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.world.actors import Instant
from avsec_gym.world.site import Style
from avsec_gym.world.sites import draw_site
from avsec_gym.world.traffic import simulate, still

EVERY = [(style, 3) for style in Style]
MORE = [
    pytest.param(style, seed, marks=pytest.mark.slow) for style in Style for seed in range(10, 20)
]
VEHICLES = ("Car", "Van", "Truck")
places = pytest.mark.parametrize(("style", "seed"), [*EVERY, *MORE])


def overlapping(instant: Instant) -> list[tuple[int, int]]:
    actors = instant.actors
    shapes = rectangle_polygons(actors.pose, actors.dimensions[:, 2], actors.dimensions[:, 1])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    return [
        (int(actors.id[one]), int(actors.id[two]))
        for one, two in zip(first, second, strict=True)
        if one < two
    ]


def digest(instants: list[Instant]) -> str:
    code = hashlib.sha256()
    for instant in instants:
        actors = instant.actors
        code.update("".join(actors.category).encode())
        for name in ("id", "dimensions", "pose", "z", "speed", "moving", "appearance", "phase"):
            code.update(np.ascontiguousarray(getattr(actors, name)).tobytes())
    return code.hexdigest()


def traffic(seed: int, duration: float) -> list[Instant]:
    rng = np.random.default_rng(seed)
    site = draw_site(Style.CITY, rng, length=250.0)
    return simulate(site, rng, duration=duration, egos=2)


@places
def test_no_two_actors_overlap(watch: Callable, style: Style, seed: int) -> None:
    for instant in watch(style, seed).instants:
        assert overlapping(instant) == [], f"{style} {seed} at {instant.time:.1f} s"


@places
def test_motion_is_plausible(watch: Callable, style: Style, seed: int) -> None:
    seen = watch(style, seed)
    speeds, poses = seen.speeds[:, seen.moving], seen.poses[:, seen.moving]
    travellers = seen.population.travellers
    vehicle = np.array([traveller.category in VEHICLES for traveller in travellers])
    change = np.diff(speeds, axis=0) / 0.1
    assert np.nanmax(change, initial=0.0) < 4.0
    assert np.nanmin(change[:, vehicle], initial=0.0) > -8.0 - 1e-6
    assert np.nanquantile(change[:, vehicle], 0.01) > -3.0, "typically comfortable"
    assert (speeds[~np.isnan(speeds)] >= 0).all()

    turned = np.diff(poses[..., 2], axis=0)
    assert np.nanmax(np.abs(turned), initial=0.0) < 0.35, "no heading jumps"
    lateral = speeds[1:, vehicle] * turned[:, vehicle] / 0.1
    assert np.nanmax(np.abs(lateral), initial=0.0) < 3.2

    way = np.diff(poses[..., :2], axis=0)
    middle = poses[:-1, :, 2] + 0.5 * turned
    forward = way[..., 0] * np.cos(middle) + way[..., 1] * np.sin(middle)
    sideways = way[..., 1] * np.cos(middle) - way[..., 0] * np.sin(middle)
    expected = 0.05 * (speeds[1:] + speeds[:-1])
    assert np.nanmax(np.abs(forward - expected), initial=0.0) < 0.03
    assert np.nanmax(np.abs(sideways), initial=0.0) < 0.02


@places
def test_who_stands_stays_bit_for_bit(watch: Callable, style: Style, seed: int) -> None:
    seen = watch(style, seed)
    standing = seen.poses[:, seen.moving.stop :]
    assert (standing == standing[0]).all()
    waits = (seen.speeds[1:] == 0) & (seen.speeds[:-1] == 0)
    assert (np.diff(seen.poses, axis=0)[waits] == 0).all()
    for instant in seen.instants:
        assert (instant.actors.moving == (instant.actors.speed > 0.3)).all()


@places
def test_vehicles_keep_to_their_lanes(watch: Callable, style: Style, seed: int) -> None:
    """All but those that turn, pull out or change lanes."""
    seen = watch(style, seed)
    if style == Style.HIGHWAY:
        return
    right, left = seen.site.section.carriageway
    lanes = np.clip([lane.left for lane in seen.site.section.lanes], right + 1.2, left - 1.2)
    keeping = [
        index
        for index, one in enumerate(seen.population.travellers)
        if one.category in VEHICLES and not np.isfinite(seen.population.routes[one.route].gate)
    ]
    places = seen.poses[:, keeping].reshape(-1, 3)
    _, across = seen.site.course.coordinates(*places[~np.isnan(places[:, 0]), :2].T)
    assert np.abs(across[:, None] - lanes).min(axis=1).max(initial=0.0) < 0.6


@places
def test_people_stay_off_the_carriageway_unless_they_cross(
    watch: Callable, style: Style, seed: int
) -> None:
    seen = watch(style, seed)
    walking = [
        index
        for index, one in enumerate(seen.population.travellers)
        if one.category == "Pedestrian" and not np.isfinite(seen.population.routes[one.route].gate)
    ]
    places = seen.poses[:, walking].reshape(-1, 3)
    _, across = seen.site.course.coordinates(*places[~np.isnan(places[:, 0]), :2].T)
    right, left = seen.site.section.carriageway
    assert not ((across > right) & (across < left)).any()
    walked = seen.speeds[:, walking]
    assert np.nanmax(walked, initial=0.0) < 1.9


@places
def test_no_traveller_vanishes_in_sight_of_an_ego_vehicle(
    watch: Callable, style: Style, seed: int
) -> None:
    seen = watch(style, seed)
    there = ~np.isnan(seen.poses[..., 0])
    assert there[:, list(seen.population.egos)].all()
    ego = seen.poses[:, seen.population.egos[0], :2]
    apart = np.hypot(*np.moveaxis(seen.poses[..., :2] - ego[:, None], -1, 0))
    gone = there[:-1] & ~there[1:]
    come = ~there[:-1] & there[1:]
    assert (apart[:-1][gone] > 60).all()
    assert (apart[1:][come] > 60).all()


@pytest.mark.parametrize("style", list(Style))
def test_several_ego_vehicles_see_the_same_place(style: Style) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        instant = still(draw_site(style, rng, length=300.0), rng, egos=3)
        assert instant.egos == (0, 1, 2)
        assert overlapping(instant) == []
        egos = instant.actors.pick(np.arange(3))
        np.testing.assert_array_equal(egos.dimensions, np.tile([1.50, 1.80, 4.70], (3, 1)))
        apart = np.hypot(*(egos.pose[1:, :2] - egos.pose[0, :2]).T)
        assert ((apart > 13) & (apart < 80)).all()


def test_heights_are_those_of_the_ground_and_the_kerbs(watch: Callable) -> None:
    seen = watch(Style.CITY, 3)
    actors = seen.instants[50].actors
    ground = seen.site.ground.height(actors.pose[:, 0], actors.pose[:, 1])
    assert ((actors.z - ground > -1e-9) & (actors.z - ground < 0.13)).all()
    vehicle = np.isin(actors.category, VEHICLES) & actors.moving
    np.testing.assert_array_equal(actors.z[vehicle], ground[vehicle])


def test_a_shorter_run_is_the_beginning_of_a_longer_one() -> None:
    assert digest(traffic(5, 3.0)) == digest(traffic(5, 8.0)[:31])


def test_another_process_sees_the_same_traffic() -> None:
    path = Path(__file__)
    program = (
        f"import sys; sys.path.insert(0, {str(path.parent)!r});"
        "from test_simulation import digest, traffic; print(digest(traffic(2, 4.0)))"
    )
    output = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True,
        cwd=path.parents[3],
    ).stdout  # fmt: skip
    assert output.strip() == digest(traffic(2, 4.0))


def test_turning_vehicles_turn_into_side_streets_smoothly(watch: Callable) -> None:
    turned = 0
    for seed in range(3, 7):
        seen = watch(Style.CITY, seed)
        for index, one in enumerate(seen.population.travellers):
            heading = seen.poses[:, index, 2]
            heading = heading[~np.isnan(heading)]
            gate = seen.population.routes[one.route].gate
            if (
                one.category in VEHICLES
                and np.isfinite(gate)
                and len(heading) > 9
                and np.ptp(heading) > 1.2
            ):
                turned += 1
                rate = np.diff(heading) / 0.1
                assert np.abs(np.diff(rate)).max() < 0.2, "the yaw rate has no jumps"
    assert turned > 0
