"""What is kept of an instant is read back as it was."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.measured_state import (
    MeasuredState,
    Naming,
    measured_states,
)
from avsec_gym.experiments.chapter4.settings import EXACT, JUDGED, METHODS, USUAL
from tests.experiments.chapter4.known_run import Kept, attacked, clean, known_rows


def same(one: MeasuredState, other: MeasuredState) -> bool:
    return (one.place, one.attacked) == (other.place, other.attacked) and all(
        np.array_equal(a, b)
        for a, b in [
            (one.decidable, other.decidable),
            (one.distances, other.distances),
            *((one.scores[m], other.scores[m]) for m in METHODS),
            *((one.named[m], other.named[m]) for m in METHODS),
            *((one.nbytes[m], other.nbytes[m]) for m in METHODS),
        ]
    )


def test_states_are_read_back_as_they_were() -> None:
    kept = Kept(known_rows(12))
    of_clean = measured_states(kept, JUDGED, USUAL, "clean")  # type: ignore[arg-type]
    of_ghosts = measured_states(kept, JUDGED, USUAL, "ghost")  # type: ignore[arg-type]
    # Twelve regions and more are in their own order, not in that of texts.
    assert all(same(state, clean(number)) for number, state in enumerate(of_clean))
    assert all(same(state, attacked(number)) for number, state in enumerate(of_ghosts))
    assert len(of_clean) == len(of_ghosts) == 12
    assert measured_states(kept, JUDGED, EXACT, "clean") == []  # type: ignore[arg-type]


def test_what_knew_fewer_methods_is_no_state() -> None:
    rows = [row for row in known_rows(2) if not row.name.startswith("learned")]
    assert measured_states(Kept(rows), JUDGED, USUAL, "clean") == []  # type: ignore[arg-type]


def test_rows_of_a_state_are_unique() -> None:
    rows = known_rows(3)
    assert len({(row.setting, row.scenario, row.name) for row in rows}) == len(rows)


@pytest.mark.parametrize(
    ("turn", "covered", "decidable", "highest", "naming"),
    [
        (0, False, False, -np.inf, Naming.NO_ALARM),
        (1, False, False, -np.inf, Naming.NO_ALARM),
        (2, True, False, -np.inf, Naming.NO_ALARM),
        (4, True, True, 5.0, Naming.VICTIM),
    ],
)
def test_what_is_not_decidable_is_a_miss(
    turn: int, covered: bool, decidable: bool, highest: float, naming: Naming
) -> None:
    state = attacked(turn)
    assert (state.covered, state.is_decidable) == (covered, decidable)
    assert state.highest("rays") == highest
    assert state.naming("rays") == naming
