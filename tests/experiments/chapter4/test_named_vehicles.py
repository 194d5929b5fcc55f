"""Who is named, of what methods decide and by the thesis' own rule."""

from __future__ import annotations

import numpy as np

from avsec_gym.experiments.chapter4.named_vehicles import NamedVehicles
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.result import Naming


def test_names_of_a_method() -> None:
    named = NamedVehicles.of(np.array([NO_ATTACK, CANNOT_TELL, 1, 2]), 3)
    assert named.namings(1).tolist() == [
        Naming.NO_ALARM,
        Naming.CANNOT_TELL,
        Naming.VICTIM,
        Naming.ANOTHER,
    ]
    assert (named.honest(), named.honest(1), named.honest(0)) == (2, 1, 2)


def test_the_thesis_names_whose_two_distances_exceed_theta() -> None:
    nan = np.nan
    far = np.array([[nan, 0.1, 1.2], [0.1, nan, 1.4], [1.2, 1.4, nan]])
    all_far = np.array([[nan, 1.1, 1.2], [1.1, nan, 1.4], [1.2, 1.4, nan]])
    distances = np.stack([far, all_far, np.full((3, 3), nan)])
    named = NamedVehicles.of_thesis(distances, 0.8)
    assert named.namings(2).tolist() == [Naming.VICTIM, Naming.CANNOT_TELL, Naming.NO_ALARM]
    assert named.namings(0).tolist() == [Naming.ANOTHER, Naming.CANNOT_TELL, Naming.NO_ALARM]
    assert (named.honest(2), named.honest(0), named.honest()) == (0, 1, 1)


def test_a_victim_named_with_another_is_another() -> None:
    both = NamedVehicles(np.array([True]), np.array([[True, True, False, False]]))
    assert both.namings(0).tolist() == [Naming.ANOTHER]
    assert both.honest(0) == 1


def test_without_regions_none_is_named() -> None:
    for named in (
        NamedVehicles.of(np.zeros(0, np.int64), 3),
        NamedVehicles.of_thesis(np.zeros((0, 3, 3)), 0.8),
    ):
        assert named.honest() == 0
        assert len(named.namings(0)) == 0
