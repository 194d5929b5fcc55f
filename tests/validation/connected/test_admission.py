"""What a vehicle sends beyond what it can know is left out, and what the others send stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.admission import (
    LARGEST,
    MOST_OF_ONE,
    admitted_counts,
    admitted_crops,
    admitted_proposals,
)
from avsec_gym.validation.connected.base_station import complete_set_of_regions, region_distances
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.region_message import MOST_REGIONS, RegionMessage
from avsec_gym.validation.connected.rays.claims import Claims
from avsec_gym.validation.connected.rays.witness_counts import WitnessCounts
from avsec_gym.validation.connected.regions import Regions
from tests.validation.connected.conftest import car_regions, pose_at

_HONEST = [
    RegionMessage(0, pose_at(0, 0, 0), car_regions((10, 3, 0), (20, -3, 0.1))),
    RegionMessage(1, pose_at(30, 2, np.pi), car_regions((12, 6, 0))),
]


def _many(count: int, spacing: float = 5.0) -> Regions:
    side = int(np.ceil(np.sqrt(count)))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)[:count]
    centre = np.c_[spacing * (grid - side / 2), np.zeros(count)]
    return Regions(centre, np.ones((count, 3)), np.zeros(count))


def test_a_sender_on_the_other_side_of_the_earth_leaves_the_others_their_set() -> None:
    far = np.eye(4)
    far[0, 3] = 2e6
    liar = RegionMessage(2, far, _many(5))
    with pytest.raises(DataError):
        complete_set_of_regions([*_HONEST, liar]).to_bytes()
    complete = complete_set_of_regions(admitted_proposals([liar, *_HONEST]))
    assert complete.to_bytes() == complete_set_of_regions(_HONEST).to_bytes()


def test_a_thousand_regions_crowd_out_none_of_the_others() -> None:
    liar = RegionMessage(0, pose_at(5, 5, 0), _many(MOST_REGIONS, spacing=0.9))
    honest = [RegionMessage(each.sender + 1, each.pose, each.regions) for each in _HONEST]
    taken = admitted_proposals([liar, *honest])
    assert [len(each.regions) for each in taken] == [MOST_OF_ONE, 2, 1]
    complete = complete_set_of_regions(taken)
    there = regions_in_world(complete.regions, complete.pose).centre[:, :2]
    for message in honest:
        for place in regions_in_world(message.regions, message.pose).centre[:, :2]:
            assert np.linalg.norm(there - place, axis=1).min() < 2


def test_a_region_as_large_as_a_town_is_left_out() -> None:
    town = Regions(np.zeros((1, 3)), np.array([[600.0, 600, 5]]), np.zeros(1))
    assert len(admitted_proposals([RegionMessage(0, np.eye(4), town)])[0].regions) == 0


def test_of_two_messages_of_one_sender_the_first_counts_and_a_fallen_vehicle_none() -> None:
    again = RegionMessage(0, _HONEST[0].pose, Regions.empty())
    fallen = pose_at(0, 0, 0) @ np.diag([1.0, -1, -1, 1])
    taken = admitted_proposals([*_HONEST, again, RegionMessage(2, fallen, _many(2))])
    assert [(each.sender, len(each.regions)) for each in taken] == [(0, 2), (1, 1)]


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.floats(0, 6))
def test_any_messages_make_a_set_that_can_be_sent(seed: int, count: int, spread: float) -> None:
    random = np.random.default_rng(seed)
    messages = []
    for _ in range(count):
        pose = pose_at(0, 0, random.uniform(-4, 4))
        pose[:3, 3] = random.uniform(-1, 1, 3) * 10**spread
        number = int(random.integers(300))
        regions = Regions(
            random.uniform(-327, 327, (number, 3)) * random.random(),
            random.uniform(0.01, 655, (number, 3)) ** random.random(),
            random.uniform(-4, 4, number),
        )
        sender = int(random.integers(4))
        # As it comes out of its bytes.
        messages.append(RegionMessage.from_bytes(RegionMessage(sender, pose, regions).to_bytes()))
    taken = admitted_proposals(messages)
    complete = complete_set_of_regions(taken)
    assert len(complete.to_bytes()) == complete.nbytes
    assert (complete.regions.size <= LARGEST).all()
    assert sum(len(each.regions) for each in taken) <= MOST_REGIONS


def test_points_outside_of_a_crop_are_left_out() -> None:
    complete = RegionMessage(65535, np.eye(4), car_regions((10, 3, 0)))
    inside = np.array([[1.0, 0.5, 0.7], [2.05, -0.85, -0.45]])
    outside = np.array([[300.0, 0, 0], [0, 1.6, 0], [0, 0, 2.2], [0, 0, -0.6]])
    first = CropMessage(1, (np.concatenate([inside, outside]),))
    messages = [first, CropMessage(1, (outside,)), CropMessage(0, ()), CropMessage(2, (inside,))]
    taken = admitted_crops(messages, complete)
    assert [each.sender for each in taken] == [1, 2]
    assert taken[0].crops[0].tolist() == inside.tolist()
    assert region_distances(complete, taken, 3).shape == (1, 3, 3)


def test_a_witness_says_no_more_than_was_claimed() -> None:
    claims = Claims(np.array([2, 5]), np.zeros((2, 2)), np.array([3, 1]), np.arange(4))
    said = WitnessCounts(
        np.array([2, 4, 5, 9]), np.array([[1, 2, 0], [1, 0, 0], [1, 1, 0], [0] * 3])
    )
    taken = admitted_counts(said, claims)
    assert taken.region.tolist() == [2, 9]
    nothing = WitnessCounts(np.zeros(0, np.int64), np.zeros((0, 3), np.int64))
    assert len(admitted_counts(nothing, claims).region) == 0
