"""Vehicles that make up all of their messages: searched by CMA-ES, through the whole exchange."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected import accusation, ray_exchange
from avsec_gym.validation.connected.attacks.lying_vehicle import (
    NUMBERS,
    Colluders,
    Lie,
    LyingVehicle,
    lie_about,
    nearest_to_conviction,
)
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.traffic import MessageKind
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import CARS, POSES, car_regions, scan_of

_LIAR = 3
_FOUND = np.concatenate(
    [
        (0.402, 0.844, 0.507, 0.442, 0.837, 0.495, 0.545),
        (0.407, 0.039, 0.254, 0.886, 0.939, 0.977),
        (0.981, 0.763, 0.576, 0.915, 0.469),
    ]
)
"""The lie that CMA-ES found where any contradiction counted: it had vehicle 1 named.

The region is bent such that it cuts the roof of a car out of it: a ring of vehicle 1 lies on that,
and rays of vehicle 0 pass close above."""

Search = tuple[list[VehicleScan], list[Regions], ConnectedValidator]


@pytest.fixture(scope="module")
def street() -> Search:
    """Three honest vehicles whose poses are a little off, what they propose, and a validator."""
    random = np.random.default_rng(0)
    scans, targets = [], []
    proposed: dict[int, Regions] = {}
    usual = ClusterProposer()
    for pose in POSES:
        measured = pose.copy()
        measured[:2, 3] += random.normal(0, 0.2, 2)
        scans.append(VehicleScan(scan_of(pose, *CARS).points, measured))
        regions = proposed[len(scans[-1].points)] = usual(scans[-1].points)
        targets.append(regions_in_world(regions, measured))
    scans.append(VehicleScan(np.zeros((0, 4), np.float32), np.eye(4)))
    proposed[0] = Regions.empty()
    assert len(proposed) == 4
    constants = read_connected_fit(SHIPPED_FIT).constants()
    # What it proposes of a scan does not change while lies are searched.
    return scans, targets, ConnectedValidator(constants, proposer=lambda p: proposed[len(p)])


@pytest.fixture(autouse=True)
def _rays_are_sorted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    observers: dict[VehicleScan, Observer] = {}

    def once(scan: VehicleScan) -> Observer:
        if scan not in observers:
            observers[scan] = observe(scan)
        return observers[scan]

    monkeypatch.setattr(ray_exchange, "observe", once)


def _lied(
    street: Search, target: Regions, numbers: np.ndarray
) -> tuple[ConnectedResult, LyingVehicle]:
    scans, _, validator = street
    liar = LyingVehicle(_LIAR, lie_about(target, numbers))
    return validator.validate(scans, wire=liar), liar


def _roof(street: Search) -> Regions:
    """What vehicle 1 proposes where it sees no more of a car than a ring on the roof."""
    return street[1][1][np.array([2])]


def _where_lower_rays_do_not_count(street: Search) -> Search:
    scans, targets, validator = street
    constants = validator.constants
    margins = replace(constants.margins, below=0.0)
    return scans, targets, replace(validator, constants=replace(constants, margins=margins))


def _aside() -> np.ndarray:
    """The region itself, claimed nearly whole by a vehicle that is not in it: it sees nothing."""
    numbers = np.full(NUMBERS, 0.5)
    numbers[7:10], numbers[10:13], numbers[15:17] = 0.05, 0.95, 0.7
    return numbers


def test_the_lie_that_was_found_convicts_none_any_more(
    street: Search, monkeypatch: pytest.MonkeyPatch
) -> None:
    result, liar = _lied(street, _roof(street), _FOUND)
    assert not liar.is_lone_author
    assert result.accused == ()
    assert nearest_to_conviction(result, liar) < 0
    # As it was: a ring on a roof, and seven rays above it, were an accuser, though lower rays end
    # on the car, and the vehicle that sides with the accused did not count.
    street = _where_lower_rays_do_not_count(street)
    monkeypatch.setattr(accusation, "ACCUSERS", 1)
    assert _lied(street, _roof(street), _FOUND)[0].accused == ()
    monkeypatch.setattr(accusation, "CLEAR_RAYS", 0)
    monkeypatch.setattr(accusation, "LAYERS", 0)
    result, liar = _lied(street, _roof(street), _FOUND)
    assert result.accused == (1,)
    assert nearest_to_conviction(result, liar) == 1


def test_naming_an_honest_vehicle_is_the_whole_of_a_conviction(street: Search) -> None:
    result, liar = _lied(street, _roof(street), _aside())
    for named in range(5):
        accused = replace(result, named=np.full_like(result.named, named))
        score = nearest_to_conviction(accused, liar)
        assert (score == 1.0) == (named != liar.number), named
    assert -1 < nearest_to_conviction(result, liar) < 0
    assert nearest_to_conviction(replace(result, regions=Regions.empty()), liar) == -2


def test_a_liar_sends_what_the_base_station_takes(street: Search) -> None:
    result, liar = _lied(street, _roof(street), _aside())
    assert not result.traffic.refused
    sent = result.traffic.sent[_LIAR]
    assert set(sent) == {MessageKind.PROPOSALS, MessageKind.CLAIMS, MessageKind.COUNTS}
    assert result.counts is not None
    # It denies or supports all that the honest vehicles claim of the region.
    claimed = result.counts[liar.index, :_LIAR, _LIAR].sum(axis=-1)
    assert (claimed > 0).sum() >= 2
    honest = np.delete(result.counts[liar.index], _LIAR, axis=0)[:, :_LIAR]
    expected = max(float((honest[..., 1] - 2 * honest[..., 0]).max()), 0.0)
    assert max(liar.contradiction(), 0.0) == expected


def test_a_region_of_its_own_counts_for_nothing(street: Search) -> None:
    numbers = _aside()
    numbers[:2] = 1.0, 0.0
    result, liar = _lied(street, _roof(street), numbers)
    assert liar.is_lone_author
    assert nearest_to_conviction(result, liar) == -2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("vehicle", "proposal", "lower_rays", "contradict"),
    [(1, 2, True, False), (1, 2, False, True), (0, 3, True, False)],
    ids=["a ring on a roof", "a ring on a roof without lower rays", "a car"],
)
def test_cma_es_over_all_messages_of_a_liar_convicts_no_honest_vehicle(
    vehicle: int, proposal: int, lower_rays: bool, contradict: bool, street: Search
) -> None:
    cma = pytest.importorskip("cma")
    street = street if lower_rays else _where_lower_rays_do_not_count(street)
    target = street[1][vehicle][np.array([proposal])]
    options = {"bounds": [0, 1], "seed": 1, "verbose": -9, "maxfevals": 150}
    # The measure is flat where no honest vehicle contradicts another.
    options |= {"tolflatfitness": 10**6, "tolfun": 0, "tolfunhist": 0}
    search = cma.CMAEvolutionStrategy(_aside(), 0.12, options)
    nearest = []
    while not search.stop():
        drawn = search.ask()
        lies = [_lied(street, target, np.asarray(each)) for each in drawn]
        assert not any(set(result.accused) - {_LIAR} for result, _ in lies)
        nearest.append([nearest_to_conviction(*each) for each in lies])
        search.tell(drawn, [-each for each in nearest[-1]])
    # Over the roof it finds where honest vehicles contradict each other, unless they look lower,
    # too: -0.5 is no ray.
    assert (np.max(nearest) > -0.5) == contradict


def _convicted(scans: list[VehicleScan], region: Regions, victim: int) -> tuple[int, set[int]]:
    """Who is named where two more vehicles deny what an honest one claims, and anywhere."""
    nothing = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    whole = np.array([[0.05] * 3, [0.95] * 3])
    lie = Lie(region, whole, (0.0, 0.0), (20.0, 20.0), victim=victim)
    liars = Colluders((len(scans), len(scans) + 1), lie)
    result = ConnectedValidator().validate([*scans, nothing, nothing], wire=liars)
    assert not result.traffic.refused
    assert not liars.liars[0].is_lone_author
    return int(result.named[liars.index]), set(result.accused)


def test_two_colluders_convict_no_honest_vehicle_that_an_honest_one_confirms() -> None:
    scans = [scan_of(pose, CARS[0]) for pose in POSES]
    for victim in range(3):
        named, _ = _convicted(scans, car_regions(CARS[0]), victim)
        assert named == CANNOT_TELL


def test_two_colluders_convict_a_vehicle_that_is_alone_with_them() -> None:
    """What no rule can hold off: of what one honest vehicle sees, two liars are the majority."""
    scans = [scan_of(POSES[0], CARS[0])]
    assert _convicted(scans, car_regions(CARS[0]), 0) == (0, {0})


def test_colluders_are_others_than_their_victim(street: Search) -> None:
    lie = Lie(street[1][1][np.array([2])], np.zeros((2, 3)), (0.0, 0.0), (0.0, 0.0), victim=1)
    for numbers in ((), (1, 3)):
        with pytest.raises(ConfigurationError, match="other than their victim 1"):
            Colluders(numbers, lie)


@pytest.mark.parametrize("share", [0.0, 1.0, 1.7])
def test_a_lie_at_the_border_of_its_box_claims_one_layer(street: Search, share: float) -> None:
    numbers = np.full(NUMBERS, 0.5)
    numbers[[7, 10]] = share
    result, _ = _lied(street, _roof(street), numbers)
    assert not result.traffic.refused
    assert MessageKind.CLAIMS in result.traffic.sent[_LIAR]
