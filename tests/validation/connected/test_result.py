"""What a result states of its regions, by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest

from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.traffic import SentMessages


@pytest.fixture
def result() -> ConnectedResult:
    """A quiet region, a ghost whose victim cannot be named, an object removed from vehicle 1."""
    centres = np.array([[0.0, 0, 0], [10, 0, 0], [20.123, 5, 0]])
    regions = Regions(centres, np.tile([4.0, 2.0, 1.5], (3, 1)), np.array([0.0, 0.1, 0.25]))
    ghost = np.array([[0.0, 0], [0.4, 0.3], [0.1, 0.05]])
    removal = np.array([[0.0, 0], [0.2, 0.1], [0.05, 0.8]])
    return ConnectedResult(
        "7", "rays", regions, np.array([-np.inf, 5, 9]), np.array([0.0, 0.7, 0.9]),
        np.array([False, True, True]), ghost, removal,
        np.array([NO_ATTACK, CANNOT_TELL, 1]), SentMessages(2),
    )  # fmt: skip


def test_the_likeliest_attack_comes_first_with_its_kind_and_share(result: ConnectedResult) -> None:
    first, second = result.accusations
    assert (first.index, first.kind, first.vehicle, first.share) == (2, "removal", 1, 0.8)
    assert (second.index, second.kind, second.vehicle, second.share) == (
        1,
        "ghost",
        CANNOT_TELL,
        0.4,
    )
    assert (first.probability, second.probability) == (0.9, 0.7)


def test_a_row_names_the_victim_and_null_where_it_cannot_be_decided(
    result: ConnectedResult,
) -> None:
    row = json.loads(json.dumps(result.to_json()))
    assert row["alarm"]
    assert row["accused"] == [1]
    assert (row["regions"], row["decidable"], row["score"]) == (3, 2, 9.0)
    assert [each["vehicle"] for each in row["accusations"]] == [1, None]
    assert row["accusations"][0] == {
        "kind": "removal",
        "vehicle": 1,
        "probability": 0.9,
        "share": 0.8,
        "centre": [20.12, 5.0, 0.0],
        "size": [4.0, 2.0, 1.5],
        "heading": 0.25,
    }


def test_what_was_compared_is_counted(result: ConnectedResult) -> None:
    assert result.decidable_share == pytest.approx(2 / 3)
    assert result.highest_score == 9.0
