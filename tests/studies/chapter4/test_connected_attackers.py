"""All attackers at a street of boxes, and what is made of what they reach."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.settings import ConnectedCondition
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.validation.connected.recordings import RecordedInstant
from studies.chapter4 import connected_attackers
from studies.chapter4.connected_attackers import (
    ATTACKERS,
    ConnectedAttackers,
    main,
)
from studies.chapter4.connected_attackers_page import attackers_page
from tests.validation.connected.conftest import CARS, POSES, pose_at, scan_of

_PLACES = (*POSES, pose_at(24, 14, -2.0), pose_at(-8, 6, 0.3))


@dataclass(frozen=True)
class _Street:
    """A place at which all vehicles see all cars."""

    whole: RecordedInstant

    def instant(self, condition: ConnectedCondition) -> RecordedInstant:
        return RecordedInstant(self.whole.id, self.whole.scans[: condition.vehicles])


@pytest.fixture(scope="module")
def found() -> ConnectedAttackers:
    street = _Street(RecordedInstant("0", tuple(scan_of(pose, *CARS) for pose in _PLACES)))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(connected_attackers, "usual_places", lambda *_: [street])
        return connected_attackers.connected_attackers(1)


@pytest.mark.slow
def test_every_attacker_is_judged_with_three_and_with_five_vehicles(
    found: ConnectedAttackers,
) -> None:
    assert {(row.attacker, row.vehicles) for row in found.rows} == {
        (name, vehicles) for name in ATTACKERS for vehicles in (3, 5)
    }
    for row in found.rows:
        # Two victims are two attacks, in one cluster.
        expected = 2 if row.attacker in ("two_victims", "same_ghost") else 1
        assert row.covered.of == row.end_to_end.of == expected, row.attacker
        assert row.end_to_end.count <= row.decidable.count <= row.covered.count
        assert row.detected.of == row.decidable.count
        assert row.victim.count + row.another.count <= row.victim.of
        assert row.wrongly.of == 1
    points = {row.attacker: row.points for row in found.rows if row.vehicles == 5}
    assert points["cao_2019"] is not None
    assert points["cao_2019"] <= 60
    assert [row.named.count for row in found.clean] == [0, 0]


def test_a_plain_ghost_among_five_is_detected(found: ConnectedAttackers) -> None:
    [row] = [row for row in found.rows if (row.attacker, row.vehicles) == ("anywhere", 5)]
    assert row.decidable.count == row.end_to_end.count == 1
    assert row.another.count == row.wrongly.count == 0


def test_the_page_is_of_the_result_that_is_read(
    found: ConnectedAttackers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connected_attackers, "connected_attackers", lambda *_, **__: found)
    kept = tmp_path / "kept.json"
    assert main(["--limit", "1", "--json", str(kept)]) == 0
    again = row_of(ConnectedAttackers, json.loads(kept.read_text()))
    assert row_json(again) == row_json(found)
    page = attackers_page(again)
    assert page.count("| two victims, the same ghost |") == 4
    assert np.isfinite([row.threshold for row in found.clean]).all()
