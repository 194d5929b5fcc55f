"""One vehicle that lies convicts no honest one, whatever it sends: drawn, and searched."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected import accusation
from avsec_gym.validation.connected.accusation import (
    CLEAR_RAYS,
    LAYERS,
    NO_LONE_AUTHOR,
    lone_authors,
    upheld_by_distances,
    upheld_by_rays,
)
from avsec_gym.validation.connected.admission import admitted_counts, admitted_proposals
from avsec_gym.validation.connected.base_station import complete_set_of_regions
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.naming import attacked_vehicles
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.rays.claim_message import decode_claims, encode_claims
from avsec_gym.validation.connected.rays.claims import (
    MARGIN,
    MOST_VOXELS_OF_ONE,
    Claims,
    claim,
    grid_shapes,
)
from avsec_gym.validation.connected.rays.decision import (
    CANNOT_TELL,
    Decision,
    DecisionRule,
    decide,
)
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.rates import RayRates
from avsec_gym.validation.connected.rays.ray_outcomes import MISSING, SUPPORT, THROUGH
from avsec_gym.validation.connected.rays.witness import (
    WitnessMargins,
    outcomes,
)
from avsec_gym.validation.connected.rays.witness_counts import (
    WitnessCounts,
    count_rays,
    decode_counts,
    encode_counts,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle import propose_regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import CARS, POSES, car_regions, scan_of

_LIAR = 3
_RATES, _RULE = RayRates(), DecisionRule()
_THETA = 0.8


@pytest.fixture(scope="module")
def scans() -> list[VehicleScan]:
    """Three honest vehicles that all see the same cars; their own poses are a little off."""
    random = np.random.default_rng(0)
    found = []
    for pose in POSES:
        measured = pose.copy()
        measured[:2, 3] += random.normal(0, 0.2, 2)
        found.append(VehicleScan(scan_of(pose, *CARS).points, measured))
    return found


@pytest.fixture(scope="module")
def honest(scans: list[VehicleScan]) -> list[Observer]:
    return [observe(scan) for scan in scans]


def _honest_counts(honest: list[Observer], claims: list[Claims], regions: Regions) -> np.ndarray:
    """What the honest say of each other, shape (R, 4, 4, 3)."""
    counts = np.zeros((len(regions), 4, 4, 3), np.int64)
    for j, k in product(range(3), range(3)):
        if j != k:
            said = count_rays(honest[k], claims[j], regions, _MARGINS)
            counts[said.region, j, k] = said.counts
    return counts


def _lies(
    honest: list[Observer], region: Regions, rule: DecisionRule
) -> tuple[Decision, np.ndarray, np.ndarray]:
    """Decisions over all that the liar can say of one region, with counts and layers behind them.

    It denies or confirms each honest claim, or is silent; it claims nothing, or those voxels that
    one honest vehicle sees through and no other, that one sees and another does not, and so on.
    """
    claims = [claim(observer, region) for observer in honest]
    truth = _honest_counts(honest, claims, region)[0]
    room = int(grid_shapes(region.grown(MARGIN, MARGIN).size).prod())
    voxels = np.arange(0, room, max(1, room // 1500))
    everywhere = Claims(np.array([0]), np.zeros((1, 2)), np.array([len(voxels)]), voxels)
    seen = np.stack([outcomes(each, everywhere, region, _MARGINS) for each in honest])
    of_liar = [(np.zeros((3, 3), np.int64), 0)]
    for k in range(3):
        through, others = seen[k] == THROUGH, np.delete(seen, k, axis=0)
        for chosen in (
            through & ~np.isin(others, (SUPPORT, THROUGH, MISSING)).any(axis=0),
            through & (others != THROUGH).all(axis=0),
            through & (others == SUPPORT).any(axis=0),
            seen[k] == SUPPORT,
        ):
            kept = voxels[chosen][:MOST_VOXELS_OF_ONE]
            if len(kept):
                lie = Claims(np.array([0]), np.zeros((1, 2)), np.array([len(kept)]), kept)
                lie = decode_claims(encode_claims(lie), region)
                said = [count_rays(each, lie, region, _MARGINS) for each in honest]
                rows = np.concatenate([each.counts for each in said])
                of_liar.append((rows, int(lie.layers(region)[0])))
    cases, layers = [], []
    of_honest = [int(each.layers(region)[0]) if len(each) else 0 for each in claims]
    for (row, high), says in product(of_liar, product((SUPPORT, THROUGH, None), repeat=3)):
        counts = truth.copy()
        counts[_LIAR, :3] = row
        for j, outcome in enumerate(says):
            if outcome is not None and len(claims[j]):
                lie_of = np.zeros((1, 3), np.int64)
                lie_of[0, outcome] = MOST_VOXELS_OF_ONE
                sent = encode_counts(WitnessCounts(np.array([0]), lie_of))
                # More than was claimed is not taken: the best that is taken is all of it.
                assert not len(admitted_counts(decode_counts(sent, region), claims[j]).region) or (
                    claims[j].count[0] == MOST_VOXELS_OF_ONE
                )
                counts[j, _LIAR, outcome] = claims[j].count[0]
        cases.append(counts)
        layers.append([*of_honest, high])
    every = np.array(cases)
    return decide(every, _RATES, rule), every, np.array(layers)


def _convicts(
    honest: list[Observer], region: Regions, author: int, rule: DecisionRule = _RULE
) -> bool:
    decision, counts, layers = _lies(honest, region, rule)
    authors = np.full(len(counts), author)
    named = upheld_by_rays(decision, counts, layers, authors, _RATES, rule)
    return bool(((named >= 0) & (named != _LIAR)).any())


def _region(numbers: np.ndarray) -> Regions:
    """A region that the liar makes up, near a car, of eight numbers from 0 to 1."""
    x, y, _ = CARS[int(numbers[0] * 0.999 * len(CARS))]
    centre = np.array([[x, y, 0.0]]) + (numbers[1:4] - 0.5) * np.array([6, 6, 1.5])
    size = 0.1 + numbers[4:7] * [6, 6, 3]
    return Regions(centre, size[None], np.array([numbers[7] * 2 * np.pi]))


def _contradiction(honest: list[Observer], region: Regions) -> float:
    """How strongly some honest vehicle contradicts another in a region."""
    claims = [claim(observer, region) for observer in honest]
    counts = _honest_counts(honest, claims, region)[0].astype(float)
    return float((counts[..., THROUGH] - 2 * counts[..., SUPPORT]).max())


_MARGINS = WitnessMargins(fastest=0.0, resolved=200.0)
"""Those against which the liar was searched; the usual ones contradict less readily."""
_FOUND = (
    (5.78, -4.99, -0.41, 1.09, 5.32, 0.63, 3.7),
    (20.95, 11.36, -0.63, 0.96, 5.55, 2.88, 0.36),
    (17.77, 9.16, -0.38, 4.6, 1.55, 1.99, 0.2),
)
"""Regions in which honest vehicles contradict each other, found by search."""


@pytest.mark.parametrize("numbers", _FOUND)
def test_a_region_made_for_it_convicts_none(
    honest: list[Observer], numbers: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    place = np.array(numbers)
    region = Regions(place[None, :3], place[None, 3:6], place[6:])
    assert not _convicts(honest, region, _LIAR)
    monkeypatch.setattr(accusation, "CLEAR_RAYS", 0)
    monkeypatch.setattr(accusation, "LAYERS", 0)
    assert not _convicts(honest, region, _LIAR)
    # It does if its author accuses by any ray; in the last one more rays support, too.
    assert _convicts(honest, region, NO_LONE_AUTHOR) == (numbers != _FOUND[2])


@pytest.mark.slow
def test_the_worst_of_many_regions_convict_no_honest_vehicle(honest: list[Observer]) -> None:
    drawn = [_region(numbers) for numbers in np.random.default_rng(0).random((400, 8))]
    drawn.sort(key=lambda region: -_contradiction(honest, region))
    assert _contradiction(honest, drawn[0]) > 0
    for region in drawn[:30]:
        assert not _convicts(honest, region, _LIAR)


@pytest.mark.slow
def test_cma_es_over_the_liars_message_convicts_no_honest_vehicle(honest: list[Observer]) -> None:
    """It climbs the strongest contradiction among the honest, which is what a liar can use."""
    cma = pytest.importorskip("cma")
    random = np.random.default_rng(1)

    def climbed(numbers: np.ndarray) -> float:
        return _contradiction(honest, _region(np.asarray(numbers)))

    for seed in range(4):
        start = max(random.random((100, 8)), key=climbed)
        options = {"bounds": [0, 1], "seed": seed + 1, "verbose": -9, "maxfevals": 250}
        search = cma.CMAEvolutionStrategy(start, 0.2, options)
        while not search.stop():
            drawn = search.ask()
            search.tell(drawn, [-climbed(each) for each in drawn])
        assert not _convicts(honest, _region(np.asarray(search.result.xbest)), _LIAR)


def test_honest_regions_convict_no_honest_vehicle_even_with_the_liars_voice(
    scans: list[VehicleScan], honest: list[Observer]
) -> None:
    proposer = ClusterProposer()
    messages = [propose_regions(number, scan, proposer) for number, scan in enumerate(scans)]
    # It proposes every car as well, a third of its length and width off.
    shifted = car_regions(*CARS)
    shifted = Regions(
        shifted.centre + np.array([1.2, 0.5, 0.2]), shifted.size * 0.9, shifted.heading + 0.2
    )
    messages.append(RegionMessage(_LIAR, np.eye(4), shifted))
    taken = admitted_proposals(messages)
    complete = complete_set_of_regions(taken)
    regions = regions_in_world(complete.regions, complete.pose)
    proposals = {each.sender: regions_in_world(each.regions, each.pose) for each in taken}
    authors = lone_authors(regions, proposals)
    assert len(regions) >= len(CARS)
    for index, author in enumerate(authors):
        assert not _convicts(honest, regions[np.array([index])], int(author))


def test_the_lone_author_is_who_proposed_a_region_alone() -> None:
    one, two = car_regions((0, 0, 0), (20, 0, 0)), car_regions((0.2, 0.1, 0.05))
    raised = Regions(two.centre + np.array([20, 0, 1.2]), two.size, two.heading)
    assert lone_authors(one, {4: one, 7: two}).tolist() == [NO_LONE_AUTHOR, 4]
    # At another height it is another object.
    assert lone_authors(one, {4: one, 7: raised}).tolist() == [4, 4]
    assert lone_authors(Regions.empty(), {4: one}).shape == (0,)
    assert lone_authors(one, {}).tolist() == [NO_LONE_AUTHOR] * 2


@settings(deadline=None, max_examples=300)
@given(
    vehicles=st.integers(3, 6),
    honest=arrays(np.float64, (6, 6), elements=st.floats(0, _THETA) | st.just(np.nan)),
    lies=arrays(np.float64, 6, elements=st.floats(0, 2) | st.just(np.nan)),
    author=st.integers(-1, 5),
)
def test_distances_of_one_liar_convict_no_honest_vehicle(
    vehicles: int, honest: np.ndarray, lies: np.ndarray, author: int
) -> None:
    distances = np.minimum(honest, honest.T)[:vehicles, :vehicles]
    distances[0], distances[:, 0] = lies[:vehicles], lies[:vehicles]
    np.fill_diagonal(distances, np.nan)
    named = attacked_vehicles(distances, _THETA)
    assert upheld_by_distances(named, distances, _THETA, author) <= {0}


def test_four_vehicles_of_which_one_lies_name_an_honest_one_by_lemma_1_alone() -> None:
    # All honest ones agree. The liar, 0, agrees with 2 and 3 and contradicts 1: the first element
    # of e that is 0 holds the liar.
    distances = np.full((4, 4), 0.2)
    distances[0, 1] = distances[1, 0] = 1.8
    np.fill_diagonal(distances, np.nan)
    assert attacked_vehicles(distances, _THETA) == {1}
    assert upheld_by_distances(frozenset({1}), distances, _THETA, NO_LONE_AUTHOR) == frozenset()


def test_in_a_region_of_its_own_a_liar_convicts_none_by_distances() -> None:
    # A and B contradict each other at a wrong heading; the liar sends what B sees.
    distances = np.array([[np.nan, 1.2, 1.2], [1.2, np.nan, 0.0], [1.2, 0.0, np.nan]])
    assert attacked_vehicles(distances, _THETA) == {0}
    assert upheld_by_distances(frozenset({0}), distances, _THETA, author=2) == frozenset()
    assert upheld_by_distances(frozenset({0}), distances, _THETA, author=NO_LONE_AUTHOR) == {0}


def test_few_rays_or_a_claim_in_one_layer_accuse_none() -> None:
    def named(through: int, support: int, layers: int, missing: int = 0) -> int:
        counts = np.zeros((1, 3, 3, 3), np.int64)
        counts[0, 1, 0], counts[0, 1, 2] = (0, 30, 0), (support, through, missing)
        decision = decide(counts, _RATES, _RULE)
        assert decision.named.tolist() == [1]
        every, alone = np.full((1, 3), layers), np.array([NO_LONE_AUTHOR])
        return int(upheld_by_rays(decision, counts, every, alone, _RATES, _RULE)[0])

    assert named(CLEAR_RAYS, 0, LAYERS) == 1
    assert named(CLEAR_RAYS - 1, 0, LAYERS) == CANNOT_TELL
    assert named(CLEAR_RAYS, 0, LAYERS - 1) == CANNOT_TELL
    # Half as many rays that support are no accusation, whatever their ratio.
    assert named(CLEAR_RAYS, CLEAR_RAYS // 2 - 1, LAYERS) == 1
    assert named(CLEAR_RAYS, CLEAR_RAYS // 2, LAYERS, missing=20) == CANNOT_TELL


def test_a_victim_with_two_witnesses_stays_named() -> None:
    counts = np.zeros((1, 3, 3, 3), np.int64)
    counts[0, 1, 0], counts[0, 1, 2] = (0, 30, 0), (0, 30, 0)
    decision = decide(counts, _RATES, _RULE)
    for author, expected in ((1, 1), (NO_LONE_AUTHOR, 1), (0, -1)):
        layers = np.full((1, 3), LAYERS)
        named = upheld_by_rays(decision, counts, layers, np.array([author]), _RATES, _RULE)
        assert named.tolist() == [expected]


def test_who_passes_through_what_the_accusers_claim_sides_with_the_accused() -> None:
    counts = np.zeros((1, 4, 4, 3), np.int64)
    # Vehicles 2 and 3 claim, and confirm each other, what rays of vehicle 0 pass through.
    counts[0, [2, 3], 0] = 0, 40, 0
    counts[0, [2, 3], [3, 2]] = 40, 0, 0
    layers, authors = np.full((1, 4), LAYERS), np.array([NO_LONE_AUTHOR])

    def named() -> int:
        decision = decide(counts, _RATES, _RULE)
        assert decision.named[0] == 0
        return int(upheld_by_rays(decision, counts, layers, authors, _RATES, _RULE)[0])

    assert named() == 0
    # Those of vehicle 1 pass through it, too.
    counts[0, 2, 1] = 0, 40, 0
    assert named() == CANNOT_TELL


def _accused(
    accusing: dict[int, int], vehicles: int = 4, liars: int = 0, author: int = NO_LONE_AUTHOR
) -> int:
    """Who is named where vehicles pass through what vehicle 0 claims, by so many rays each."""
    counts = np.zeros((2, vehicles, vehicles, 3), np.int64)
    for witness, rays in accusing.items():
        counts[0, 0, witness, THROUGH] = rays
    # In another region all bear witness of each other: all take part.
    counts[1, :, :, SUPPORT] = 20
    rule = DecisionRule(liars=liars)
    decision = decide(counts, _RATES, rule)
    assert decision.named[0] == 0
    layers, authors = np.full((2, vehicles), LAYERS), np.full(2, author)
    return int(upheld_by_rays(decision, counts, layers, authors, _RATES, rule)[0])


@pytest.mark.parametrize("vehicles", [3, 4, 6])
def test_two_clear_accusers_name_a_vehicle(vehicles: int) -> None:
    assert _accused({1: CLEAR_RAYS, 2: CLEAR_RAYS}, vehicles) == 0
    assert _accused({1: 30, 2: CLEAR_RAYS - 1}, vehicles) == CANNOT_TELL


def test_the_author_of_a_region_is_a_third_voice() -> None:
    weak = CLEAR_RAYS - 1
    assert _accused({1: 30, 2: 30}, author=2) == CANNOT_TELL
    assert _accused({1: 30, 2: weak, 3: 30}, author=3) == 0
    assert _accused({1: 30, 2: 30, 3: weak}, author=3) == 0
    assert _accused({1: 30, 2: weak, 3: weak}, author=3) == CANNOT_TELL
    assert _accused({1: weak, 2: weak, 3: 30}, author=3) == CANNOT_TELL
    # Of a third who contradicts nothing there is no voice.
    assert _accused({1: 30, 3: 30}, author=3) == CANNOT_TELL


def test_where_one_may_lie_a_third_accuses_who_need_not_be_clear() -> None:
    assert _accused({1: 30, 2: 30}, liars=1) == CANNOT_TELL
    assert _accused({1: 30, 2: 30, 3: 30}, liars=1) == 0
    assert _accused({1: 30, 2: 30, 3: CLEAR_RAYS - 1}, liars=1) == 0
    assert _accused({1: 30, 2: CLEAR_RAYS - 1, 3: CLEAR_RAYS - 1}, liars=1) == CANNOT_TELL
    # Of three vehicles, then, none is named.
    assert _accused({1: 30, 2: 30}, vehicles=3, liars=1) == CANNOT_TELL
    with pytest.raises(ConfigurationError, match="liars"):
        DecisionRule(liars=-1)


def test_who_sends_nothing_hinders_no_accusation() -> None:
    counts = np.zeros((1, 4, 4, 3), np.int64)
    counts[0, 0, 1:3, THROUGH] = 30
    decision = decide(counts, _RATES, _RULE)
    layers, authors = np.full((1, 4), LAYERS), np.array([NO_LONE_AUTHOR])
    assert upheld_by_rays(decision, counts, layers, authors, _RATES, _RULE)[0] == 0
