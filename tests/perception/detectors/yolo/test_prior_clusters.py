"""Clusters of sizes."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.yolo.prior_clusters import prior_clusters, shape_overlaps


def test_well_separated_sizes_are_found() -> None:
    random = np.random.default_rng(0)
    middles = np.array([[10.0, 8], [40, 25], [30, 90]])
    sizes = np.concatenate([m * random.uniform(0.95, 1.05, (50, 2)) for m in middles])
    found = prior_clusters(sizes, 3, seed=1)
    np.testing.assert_allclose(found, middles, rtol=0.03)


def test_overlaps_of_shapes() -> None:
    found = shape_overlaps(np.array([[4.0, 2.0]]), np.array([[2.0, 4.0], [4.0, 2.0]]))
    np.testing.assert_allclose(found, [[4 / 12, 1.0]])


def test_too_few_sizes() -> None:
    with pytest.raises(ConfigurationError, match="2 different sizes"):
        prior_clusters(np.array([[1.0, 2], [1, 2], [3, 4]]), 3)
