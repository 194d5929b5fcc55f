"""Witnesses: a wall, a box, what hides it, and the rays of another place."""

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.rays.claims import (
    MARGIN,
    SEARCHED,
    Claims,
    claim,
    grid_shapes,
)
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.ray_outcomes import OCCLUDED, THROUGH
from avsec_gym.validation.connected.rays.witness import WitnessMargins, outcomes
from avsec_gym.validation.connected.rays.witness_counts import ACCUSING_RAYS, count_rays
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import TIP, RollingSweep
from tests.validation.connected.rays.world_of_planes import HEIGHT, Box, pose_at, scan_of

_BOX: Box = (10.0, 14.0, -1.0, 1.0, 0.0, 1.5)
_REGION = Regions(np.array([[12.0, 0.0, 0.0]]), np.array([[4.0, 2.0, 1.5]]), np.zeros(1))
_EXACT = WitnessMargins(position_noise=0.0, heading_noise=0.0)


@pytest.fixture(scope="module")
def claims() -> Claims:
    """What a vehicle claims that sees the box from its side."""
    return claim(observe(scan_of([_BOX], pose_at(12.0, -12.0, np.pi / 2))), _REGION)


def _shares(witness: Observer, claims: Claims, margins: WitnessMargins = _EXACT) -> np.ndarray:
    """Supporting, passing and missing shares of the only claim's voxels."""
    counts = count_rays(witness, claims, _REGION, margins).counts
    return np.asarray(counts[0] / claims.count[0])


def test_rays_that_end_on_the_box_support_it(claims: Claims) -> None:
    witness = observe(scan_of([_BOX], pose_at(3.0, -6.0, 0.7)))
    support, through, missing = _shares(witness, claims)
    assert support > 0.6
    assert through == missing == 0


@pytest.mark.parametrize("behind", [(), ((20.0, 21.0, -30.0, 30.0, 0.0, 5.0),)])
def test_rays_to_the_ground_or_a_wall_behind_pass_through_what_is_not_there(
    claims: Claims, behind: tuple[Box, ...]
) -> None:
    witness = observe(scan_of(behind, pose_at(0.0, 0.0)))
    support, through, _ = _shares(witness, claims)
    assert support == 0
    assert through > 0.6


def test_what_a_wall_hides_stays_open(claims: Claims) -> None:
    wall: Box = (5.0, 5.2, -20.0, 20.0, 0.0, 5.0)
    witness = observe(scan_of([wall], pose_at(0.0, 0.0)))
    assert _shares(witness, claims).tolist() == [0, 0, 0]


def test_over_a_low_wall_rays_pass_through_what_they_can_reach(claims: Claims) -> None:
    wall: Box = (5.0, 5.2, -20.0, 20.0, 0.0, 1.5)
    house: Box = (40.0, 50.0, -60.0, 60.0, 0.0, 20.0)
    witness = observe(scan_of([wall, house], pose_at(0.0, 0.0)))
    outcome = outcomes(witness, claims, _REGION, _EXACT)
    # Height above the wall's far edge at which the line from the sensor to each voxel crosses it.
    x, _, z = claims.places(_REGION).T
    eye = HEIGHT + TIP
    over = eye + (z - eye) * 5.2 / x - 1.5
    assert (outcome[over > 0.1] == THROUGH).all()
    assert (outcome[over < -0.1] == OCCLUDED).all()
    assert min((over > 0.1).sum(), (over < -0.1).sum()) > 5


def test_rays_that_were_lost_are_missing(claims: Claims) -> None:
    wall: Box = (20.0, 21.0, -30.0, 30.0, 0.0, 5.0)
    scan = scan_of([wall, _BOX], pose_at(0.0, 0.0), hidden=[_BOX])
    kept = ~_REGION.grown(0.4, 0.4).contains(0, scan.in_world())
    kept &= np.abs(scan.points[:, 1]) > 0.14 * scan.points[:, 0]
    lost = type(scan)(scan.points[kept], scan.pose)
    support, _, missing = _shares(observe(lost), claims)
    assert support == 0
    assert missing > 0.4


def test_far_away_a_missing_ray_tells_nothing(claims: Claims) -> None:
    witness = observe(scan_of([], pose_at(-40.0, 0.0)))
    sky = type(witness.scan)(witness.scan.points[witness.scan.points[:, 0] < 0], witness.pose)
    assert _shares(observe(sky), claims)[2] == 0


@pytest.mark.parametrize("error", [(0.4, 0.0), (0.0, 0.4), (-0.3, 0.3)])
def test_with_margins_for_noise_a_wrong_pose_does_not_contradict(
    claims: Claims, error: tuple[float, float]
) -> None:
    true = pose_at(3.0, -6.0, 0.7)
    wrong = true.copy()
    wrong[:2, 3] += error
    scan = scan_of([_BOX], true)
    support, through, _ = _shares(observe(type(scan)(scan.points, wrong)), claims, WitnessMargins())
    assert through < 0.03
    assert support > 0.3


def test_with_those_margins_a_ghost_is_still_seen_through(claims: Claims) -> None:
    witness = observe(scan_of([], pose_at(0.3, 0.3)))
    assert _shares(witness, claims, WitnessMargins())[1] > 0.6


def test_what_moves_is_looked_for_where_it_is_by_then() -> None:
    velocity, sweep = (12.0, 0.0), RollingSweep(10.0, 0.2, 0.1)
    moving = {"velocity": velocity, "sweep": sweep}
    first = observe(scan_of([_BOX], pose_at(12.0, -12.0, np.pi / 2), time=0.0, **moving))
    other = observe(scan_of([_BOX], pose_at(26.0, 6.0, -2.7), time=0.1, **moving))
    carried = claim(first, _REGION, np.array([velocity]))
    support, through, _ = _shares(other, carried)
    assert support > 0.5
    assert through < 0.02
    # Without its velocity, it is where it was.
    left = claim(first, _REGION)
    assert _shares(other, left, replace(_EXACT, fastest=0.0))[0] < support


@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_what_neither_tracks_may_have_moved_along_its_heading_or_across(speed: float) -> None:
    # A thin plate across its way, which is 3 m on after 0.1 s: rays pass where it was.
    plate: Box = (11.8, 12.2, -1.0, 1.0, 0.0, 1.5)
    moving = {"velocity": (speed, 0.0)}
    first = observe(scan_of([plate], pose_at(12.0, -12.0, np.pi / 2), **moving))
    other = observe(scan_of([plate], pose_at(12.0, 12.0, -np.pi / 2), time=0.1, **moving))
    region = Regions(np.array([[12.0, 0.0, 0.0]]), np.array([[0.5, 2.0, 1.5]]), np.zeros(1))
    claims = claim(first, region)

    def counted(margins: WitnessMargins) -> np.ndarray:
        return np.asarray(count_rays(other, claims, region, margins).counts[0])

    still = counted(replace(_EXACT, fastest=0.0))
    assert still[1] > 10 * max(still[0], 1)
    moved = counted(_EXACT)
    assert moved[0] > 5 * max(moved[1], 1)
    # Of one face that was seen, the heading may be off by a right angle: no accusation follows.
    turned = Regions(region.centre, region.size[:, [1, 0, 2]], np.array([np.pi / 2]))
    of_turned = claim(first, turned)
    across = count_rays(other, of_turned, turned, _EXACT).counts[0]
    assert 0 < across[1] < ACCUSING_RAYS <= still[1]
    # What the other vehicle claims there as a second thing does not speak for the first.
    shift = np.array([[np.sign(speed) * 3.0, 0.0, 0.0]])
    two = np.tile(turned.size, (2, 1)), np.tile(turned.heading, 2)
    both = Regions(np.concatenate([turned.centre, turned.centre + shift]), *two)
    voxels, count = np.tile(of_turned.voxel, 2), np.tile(of_turned.count, 2)
    twice = Claims(np.arange(2), np.zeros((2, 2)), count, voxels)
    assert count_rays(other, twice, both, _EXACT).counts[0, 1] >= ACCUSING_RAYS
    # Nor is it excused if it is nowhere.
    nothing = observe(scan_of([], other.pose, time=0.1))
    assert count_rays(nothing, claims, region, _EXACT).counts[0, 1] > 10


@pytest.mark.parametrize("apart", [0.3, 0.5, 2.0])
def test_long_after_rays_pass_through_only_what_stood_before_and_after(
    claims: Claims, apart: float
) -> None:
    empty = scan_of([], pose_at(0.0, 0.0))
    witness = observe(replace(empty, time=apart))
    # Where the box was, and may have left since.
    assert count_rays(observe(empty), claims, _REGION, _EXACT).counts[0, 1] >= ACCUSING_RAYS
    assert not count_rays(witness, claims, _REGION, _EXACT, ()).counts.any()

    def through(seen_at: float, shift: int = 0) -> int:
        voxel = claims.voxel + shift
        again = Claims(claims.region, claims.velocity, claims.count, voxel, np.array([seen_at]))
        return int(count_rays(witness, claims, _REGION, _EXACT, [again]).counts[0, 1])

    assert through(2 * apart) >= ACCUSING_RAYS
    # Another look before it, or one at something that reaches elsewhere, shows nothing.
    assert through(-apart) == through(0.0) == 0
    shape = grid_shapes(_REGION.grown(MARGIN, MARGIN).size)[0]
    assert through(2 * apart, shift=-5 * int(shape[1] * shape[2])) == 0
    # What the other vehicle tracks is carried along: there is no doubt where it is.
    tracked = replace(claims, velocity=np.array([[0.0, 0.01]]))
    assert count_rays(witness, tracked, _REGION, _EXACT, ()).counts[0, 1] >= ACCUSING_RAYS


def test_who_states_a_false_time_silences_no_witness_of_its_instant(claims: Claims) -> None:
    witness = observe(replace(scan_of([], pose_at(0.0, 0.0)), time=0.1))
    early = replace(claims, time=np.array([-SEARCHED]))
    assert count_rays(witness, early, _REGION, _EXACT).counts[0, 1] >= ACCUSING_RAYS


def test_rays_over_the_top_of_what_the_witness_sees_pass_through_nothing() -> None:
    low: Box = (10.0, 14.0, -1.0, 1.0, 0.0, 1.2)
    house: Box = (40.0, 50.0, -60.0, 60.0, 0.0, 20.0)
    shape = grid_shapes(_REGION.grown(MARGIN, MARGIN).size)[0]
    # All voxels from 1.4 to 1.6 m: the other vehicle's pose is a little too high.
    voxel = np.arange(7, shape.prod(), shape[2])[::4]
    top = Claims(np.array([0]), np.zeros((1, 2)), np.array([len(voxel)]), voxel)

    def through(box: list[Box], below: float) -> int:
        witness = observe(scan_of([*box, house], pose_at(-4.0, 0.0)))
        margins = replace(_EXACT, below=below)
        return int((outcomes(witness, top, _REGION, margins) == THROUGH).sum())

    assert through([low], 0.0) > len(voxel) / 2
    assert through([low], 0.5) < len(voxel) / 20
    # Nothing stands there: all rays pass through.
    assert through([], 0.5) == through([], 0.0) > len(voxel) / 2


def test_a_witness_far_away_says_nothing(claims: Claims) -> None:
    witness = observe(scan_of([], pose_at(-30.0, 0.0)))
    assert _shares(witness, claims, replace(_EXACT, resolved=60.0))[1] > 0.05
    assert _shares(witness, claims, replace(_EXACT, resolved=35.0)).tolist() == [0, 0, 0]


def test_a_witness_reports_nothing_of_where_it_stands_itself(claims: Claims) -> None:
    near: Box = (10.0, 13.0, -1.0, 1.0, 0.0, 1.5)
    inside = observe(scan_of([near], pose_at(14.0, 0.0, np.pi)))
    assert _shares(inside, claims).tolist() == [0, 0, 0]
    beside = observe(scan_of([near], pose_at(18.0, 0.0, np.pi)))
    assert _shares(beside, claims)[0] > 0


def test_a_vehicle_that_turns_while_it_looks_finds_things_where_they_are(claims: Claims) -> None:
    sweep = RollingSweep(20.0, 0.5, 0.1)
    for heading in (0.4, 2.5, -1.2):
        pose = pose_at(3.0, -6.0, heading)
        support, through, _ = _shares(observe(scan_of([_BOX], pose, sweep=sweep)), claims)
        assert support > 0.6
        assert through < 0.05


def test_a_beam_without_width_is_refused_and_the_narrowest_one_looks(claims: Claims) -> None:
    with pytest.raises(ConfigurationError, match="reach"):
        WitnessMargins(reach=0.0)
    narrow = WitnessMargins(reach=1e-4, around=0.0, around_sigmas=0.0)
    witness = observe(scan_of([_BOX], pose_at(0.0, 0.0, 0.0)))
    assert len(outcomes(witness, claims, _REGION, narrow)) == claims.count.sum()
