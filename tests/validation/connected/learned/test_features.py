"""What the features of a region state, by hand."""

import numpy as np
import pytest

from avsec_gym.validation.connected.learned.features import (
    FEATURES,
    RegionEvidence,
    region_features,
)
from avsec_gym.validation.connected.rays.decision import DecisionRule
from avsec_gym.validation.connected.rays.rates import RayRates, log_likelihood_ratio
from avsec_gym.validation.connected.regions import Regions

RATES = RayRates()


def _pose(x: float, y: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return pose


@pytest.fixture
def evidence() -> RegionEvidence:
    """Three vehicles and two regions, of the second of which nothing is known."""
    regions = Regions(np.array([[3.0, 4.0, 0.0], [500.0, 0, 0]]), np.full((2, 3), 2.0), np.zeros(2))
    counts = np.zeros((2, 3, 3, 3), np.int64)
    counts[0, 1, 0] = 0, 20, 3
    counts[0, 1, 2] = 2, 10, 0
    counts[0, 0, 2] = 12, 0, 0
    counts[0, 2, 0] = 2, 2, 9  # Too few rays that returned: it tells nothing.
    distances = np.full((2, 3, 3), np.nan)
    distances[0, 0, 1] = distances[0, 1, 0] = 1.4
    distances[0, 1, 2] = distances[0, 2, 1] = 0.2
    return RegionEvidence(regions, counts, distances, {0: _pose(0, 0), 1: _pose(3, 16)})


def test_a_region_by_hand(evidence: RegionEvidence) -> None:
    features = dict(zip(FEATURES, region_features(evidence, RATES, DecisionRule())[0], strict=True))
    assert np.expm1(features["rays through, of the pair with most"]) == pytest.approx(20)
    assert np.expm1(features["rays through, of all pairs"]) == pytest.approx(30)
    assert np.expm1(features["rays that support, of all pairs"]) == pytest.approx(14)
    assert np.expm1(features["rays without a return, of all pairs"]) == pytest.approx(3)
    highest = log_likelihood_ratio([0, 20, 3], RATES)
    assert features["log-likelihood ratio, highest of a pair"] == pytest.approx(highest)
    assert features["distance of surfaces, largest"] == 1.4
    assert features["distance of surfaces, median"] == pytest.approx(0.8)
    assert features["surfaces compared"] == 2
    assert (features["witnesses"], features["claims that they tell of"]) == (2, 2)
    assert np.expm1(features["nearest vehicle"]) == pytest.approx(5.0)
    assert np.expm1(features["second nearest vehicle"]) == pytest.approx(12.0)


def test_where_nothing_was_compared_nothing_speaks_for_an_attack(evidence: RegionEvidence) -> None:
    features = region_features(evidence, RATES, DecisionRule())
    assert not features[1, :11].any()
    assert np.expm1(features[1, 11:]) == pytest.approx([100.0, 100.0])
    assert evidence.compared(RATES).tolist() == [True, False]


def test_numbers_of_vehicles_do_not_matter(evidence: RegionEvidence) -> None:
    order = np.array([2, 0, 1])
    other = RegionEvidence(
        evidence.regions,
        evidence.counts[:, order][:, :, order],
        evidence.distances[:, order][:, :, order],
        {int(np.flatnonzero(order == number)[0]): pose for number, pose in evidence.poses.items()},
    )
    np.testing.assert_allclose(
        region_features(other, RATES, DecisionRule()),
        region_features(evidence, RATES, DecisionRule()),
    )


def test_without_regions_there_are_no_features() -> None:
    nothing = RegionEvidence(
        Regions.empty(), np.zeros((0, 2, 2, 3), np.int64), np.zeros((0, 2, 2)), {}
    )
    assert region_features(nothing, RATES, DecisionRule()).shape == (0, len(FEATURES))
