"""What is kept of an instant is read back as it was."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, BY_RAYS, EXACT, JUDGED, USUAL
from avsec_gym.experiments.chapter4.state_rows import CATEGORIES, measured_states
from avsec_gym.kitti.labels import CATEGORIES as OF_KITTI
from tests.experiments.chapter4.known_run import Kept, attacked, clean, known_rows


def same(one: MeasuredState, other: MeasuredState) -> bool:
    facts = [
        (each.place, each.attack, each.honest, each.pairs, each.seconds, each.from_station)
        for each in (one, other)
    ]
    arrays = [
        (one.distances, other.distances),
        *((one.decidable[by], other.decidable[by]) for by in (BY_GEOMETRY, BY_RAYS)),
        *((one.scores[each], other.scores[each]) for each in one.scores),
        *((one.probabilities[each], other.probabilities[each]) for each in one.probabilities),
        *((one.named[each], other.named[each]) for each in one.named),
        *((one.sent[each], other.sent[each]) for each in {**one.sent, **other.sent}),
    ]
    return facts[0] == facts[1] and all(np.array_equal(a, b) for a, b in arrays)


def test_states_are_read_back_as_they_were() -> None:
    kept = Kept(known_rows(12))
    of_clean = measured_states(kept, JUDGED, USUAL, "clean")  # type: ignore[arg-type]
    # Twelve regions and more are in their own order, not in that of texts.
    assert all(same(state, clean(number)) for number, state in enumerate(of_clean))
    for kind in ("ghost", "removal"):
        of_attacks = measured_states(kept, JUDGED, USUAL, kind)  # type: ignore[arg-type]
        assert all(same(state, attacked(number, kind)) for number, state in enumerate(of_attacks))  # type: ignore[arg-type]
        assert len(of_clean) == len(of_attacks) == 12
    assert measured_states(kept, JUDGED, EXACT, "clean") == []  # type: ignore[arg-type]


@pytest.mark.parametrize("lacking", ["learned score", "rays probability", "thesis honest", "pairs"])
def test_what_kept_less_is_no_state(lacking: str) -> None:
    rows = [row for row in known_rows(2) if not row.name.startswith(lacking)]
    assert measured_states(Kept(rows), JUDGED, USUAL, "clean") == []  # type: ignore[arg-type]


def test_rows_of_a_state_are_unique() -> None:
    rows = known_rows(3)
    assert len({(row.setting, row.scenario, row.name) for row in rows}) == len(rows)


def test_all_categories_of_labels_can_be_kept() -> None:
    assert {*CATEGORIES} >= {*OF_KITTI} - {"DontCare"}
