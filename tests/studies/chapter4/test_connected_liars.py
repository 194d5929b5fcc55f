"""A liar is found where one can be, and its search ends."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.surface_exchange import ComparedSurfaces
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from studies.chapter4 import connected_liars
from studies.chapter4.connected_liars import (
    ConnectedLiars,
    LiarRow,
    LiedAt,
    by_rays,
    by_surfaces,
    contradictions,
    main,
    with_a_copy,
    with_liars,
)
from studies.chapter4.connected_liars_page import liars_page
from studies.chapter4.connected_liars_page import main as show
from studies.chapter4.usual_places import shipped_constants
from tests.validation.connected.conftest import CARS, POSES, scan_of

_CONSTANTS = shipped_constants()


@pytest.fixture(scope="module")
def contradicted() -> list[VehicleScan]:
    """Three vehicles without an attack, of which the first sees what the others do not."""
    return [
        scan_of(POSES[0], CARS[0], CARS[1]),
        scan_of(POSES[1], CARS[1]),
        scan_of(POSES[2], CARS[1]),
    ]


def _by_rays(honest: list[VehicleScan], liars: int) -> tuple[bool, bool]:
    constants = with_liars(_CONSTANTS, liars)
    validator = ConnectedValidator(constants, proposer=RememberedProposals())
    return by_rays(honest, validator.validate(honest), validator, 8)


def test_a_liar_sides_with_one_that_contradicts_another(contradicted: list[VehicleScan]) -> None:
    pytest.importorskip("cma")
    pair = contradicted[:2]
    assert contradictions(ConnectedValidator(_CONSTANTS).validate(pair)).max() > 8
    # Two trust each other, and a third one settles it; where one may lie, nothing does.
    assert _by_rays(pair, 0) == (False, True)
    assert _by_rays(pair, 1) == (False, False)
    # Two honest ones that contradict a third name it, whoever lies.
    assert _by_rays(contradicted, 1) == (False, True)


def test_no_contradiction_is_no_use_to_a_liar() -> None:
    pytest.importorskip("cma")
    assert _by_rays([scan_of(pose, CARS[0]) for pose in POSES[:2]], 0) == (False, False)


def test_a_copied_surface_sides_with_it(contradicted: list[VehicleScan]) -> None:
    rule = with_liars(_CONSTANTS, 0)
    # A distance that every two surfaces exceed, and one that none does.
    assert by_surfaces(contradicted[:2], replace(rule, theta=99.0)) == (False, False)
    compared = ComparedSurfaces(
        np.array([[[np.nan, 0.3], [0.3, np.nan]]]), np.array([[1.0, np.nan]])
    )
    whole = with_a_copy(compared, 0).distances[0]
    expected = [[np.nan, 0.3, 0.0], [0.3, np.nan, 0.3], [0.0, 0.3, np.nan]]
    np.testing.assert_array_equal(whole, expected)
    np.testing.assert_array_equal(with_a_copy(compared, 1).distances[0, 2], [0.3, np.nan, np.nan])


def _result() -> ConnectedLiars:
    some, none = share_of([True, False], ["0", "1"]), share_of([False, False], ["0", "1"])
    rows = [LiarRow("rays", 5, 0, none, some), LiarRow("rays", 5, 1, none, none)]
    return ConnectedLiars(2, 7, 100, {"3": none, "5": some}, rows)


def test_the_page_states_each_row_and_is_of_the_result_that_is_read(tmp_path: Path) -> None:
    result = _result()
    kept, page = tmp_path / "kept.json", tmp_path / "page.md"
    kept.write_text(json.dumps(row_json(result)))
    assert row_of(ConnectedLiars, json.loads(kept.read_text())) == result
    assert show([str(kept), "--out", str(page)]) == 0
    assert page.read_text() == liars_page(result)
    [line] = [line for line in page.read_text().splitlines() if line.startswith("| rays | 5 | 0 ")]
    assert "| 50.0 [" in line
    assert "0 (the default)" in page.read_text()


def test_the_command_writes_its_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connected_liars, "connected_liars", lambda *_, **__: _result())
    kept = tmp_path / "kept.json"
    assert main(["--limit", "2", "--json", str(kept)]) == 0
    assert json.loads(kept.read_text())["places"] == 2


def test_places_that_were_tried_are_not_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[int] = []

    def lied_at(place: int, *_: object) -> dict[str, object]:
        tried.append(place)
        named = [["rays", 3, 0, False, place == 1], ["rays", 5, 1, False, False]]
        return {"contradicted": {"3": False, "5": True}, "named": named}

    monkeypatch.setattr(connected_liars, "_lied_at", lied_at)
    monkeypatch.setattr(connected_liars, "usual_places", lambda _, places, *__: range(places))
    path = tmp_path / "samples.jsonl"
    for places, new in ((2, [0, 1]), (2, []), (3, [2])):
        tried.clear()
        kept = JsonLines(path, LiedAt)
        result = connected_liars.connected_liars(places, kept=kept)
        assert tried == new
    first, second = result.rows
    assert (first.method, first.vehicles, first.liars) == ("rays", 3, 0)
    assert (first.convicted.count, first.convicted.of, second.convicted.count) == (1, 3, 0)
    assert (result.contradicted["3"].count, result.contradicted["5"].count) == (0, 3)
