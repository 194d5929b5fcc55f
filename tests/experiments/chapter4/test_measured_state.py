"""What is kept of an instant, and what counts as a miss."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.measured_state import Naming
from avsec_gym.experiments.chapter4.settings import BY_RAYS
from tests.experiments.chapter4.known_run import attacked, clean


@pytest.mark.parametrize(
    ("turn", "covered", "decidable", "highest", "naming"),
    [
        (0, False, False, -np.inf, Naming.NO_ALARM),
        (1, False, False, -np.inf, Naming.NO_ALARM),
        (2, True, False, -np.inf, Naming.VICTIM),
        (4, True, True, 5.0, Naming.VICTIM),
    ],
)
def test_what_is_not_decidable_is_a_miss(
    turn: int, covered: bool, decidable: bool, highest: float, naming: Naming
) -> None:
    state = attacked(turn)
    assert (state.covered, state.is_decidable()) == (covered, decidable)
    assert state.highest("rays") == highest
    assert state.naming("rays") == naming


def test_what_decides_changes_what_is_decidable() -> None:
    state = attacked(3)
    assert state.is_decidable()
    assert not state.is_decidable(BY_RAYS)
    assert (state.highest("rays"), state.highest("rays", BY_RAYS)) == (5.0, -np.inf)
    assert clean(0).highest("surfaces") > clean(0).highest("surfaces", BY_RAYS)


def test_a_method_sends_its_own_kinds_of_messages() -> None:
    state = clean(0)
    assert state.nbytes("surfaces").tolist() == [1000, 3000, 2000]
    assert state.nbytes("rays").tolist() == [100, 200, 300]
    assert state.nbytes("learned").tolist() == [1090, 3180, 2270]
    assert not len(attacked(4).nbytes("rays"))
