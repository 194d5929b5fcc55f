"""Naming the attacked vehicles of a region, against every set of attacked ones."""

from itertools import combinations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.distance_thresholds import distance_threshold
from avsec_gym.validation.connected.naming import (
    attacked_vehicles,
    comparable_vehicles,
    is_alarm,
)


def _distances(vehicles: int, attacked: set[int]) -> np.ndarray:
    """Attacked vehicles agree with no other one, not even with each other."""
    i, j = np.indices((vehicles, vehicles))
    far = np.isin(i, list(attacked)) | np.isin(j, list(attacked))
    return np.where(i == j, np.nan, np.where(far, 1.2, 0.1))


@pytest.mark.parametrize("victim", range(3))
def test_of_three_the_one_with_two_far_distances_is_named(victim: int) -> None:
    assert attacked_vehicles(_distances(3, {victim}), 0.8) == {victim}


def test_of_three_that_all_disagree_none_is_named() -> None:
    distances = _distances(3, {0, 1})
    assert attacked_vehicles(distances, 0.8) == frozenset()
    assert is_alarm(distances, 0.8)


def test_without_an_attack_there_is_no_alarm() -> None:
    assert not is_alarm(_distances(4, set()), 0.8)
    assert attacked_vehicles(_distances(4, set()), 0.8) == frozenset()


@pytest.mark.parametrize("vehicles", [4, 5, 6])
def test_algorithm_2_names_every_set_that_leaves_two_vehicles_sound(vehicles: int) -> None:
    # Its limit: of n + 1 sensors n - 2 are attacked at most.
    for count in range(vehicles - 2):
        for attacked in combinations(range(vehicles), count):
            assert attacked_vehicles(_distances(vehicles, set(attacked)), 0.8) == set(attacked)


def test_who_compared_nothing_is_no_witness() -> None:
    distances = _distances(4, {2})
    distances[0, 1:] = distances[1:, 0] = np.nan
    assert comparable_vehicles(distances).tolist() == [1, 2, 3]
    assert attacked_vehicles(distances, 0.8) == {2}
    assert not len(comparable_vehicles(np.full((3, 3), np.nan)))


def test_so_many_distances_lie_beyond_theta() -> None:
    samples = np.random.default_rng(0).permutation(np.arange(100.0))
    for rate in (0.0, 0.1, 0.29, 0.3, 1.0):
        beyond = samples > distance_threshold(np.r_[samples, np.nan], rate)
        assert beyond.sum() == round(100 * rate)


@pytest.mark.parametrize(("samples", "rate"), [([], 0.1), ([np.nan], 0.1), ([1.0], 1.1), ([-1], 0)])
def test_thresholds_of_nothing_are_refused(samples: list[float], rate: float) -> None:
    with pytest.raises(ConfigurationError):
        distance_threshold(samples, rate)
