"""Real triples, where they are at hand, and their page."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from avsec_gym.experiments.json_rows import row_json, row_of
from studies.chapter4.connected_real import (
    ConnectedReal,
    RealDecision,
    RegisteredScan,
    known_to_stand,
    main,
)
from studies.chapter4.connected_real_page import real_page
from studies.chapter4.usual_places import shipped_constants

_KITTI = Path(__file__).parents[4] / "shared" / "kitti"


def _result() -> ConnectedReal:
    decision = RealDecision("a/5", "paste", "rays", True, 120, 30, 20, 1, 4.5, "victim", (1,))
    clean = replace(decision, state="clean", points=0, score=None, about="", accused=())
    return ConnectedReal("a", [RegisteredScan("a/5", 0, -1.2, 0.021, 0.71)], [decision, clean])


def test_the_page_is_an_anecdote_of_the_result_that_is_read() -> None:
    result = _result()
    again = row_of(ConnectedReal, json.loads(json.dumps(row_json(result))))
    assert row_json(again) == row_json(result)
    page = real_page(again)
    assert "An anecdote" in page
    assert "| 5 | 0 | -1.20 | 2.1 | 71 |" in page
    assert "| 5 | paste | rays, still | 120 | 30 (20) | 4.50 | victim | 1 | 1 |" in page
    assert "| 5 | clean | rays, still | – | 30 (20) | – | – | 1 | none |" in page


def test_where_all_stands_nothing_may_have_moved() -> None:
    constants = shipped_constants()
    assert known_to_stand(constants).margins == replace(constants.margins, fastest=0.0)


def test_data_that_are_not_there_are_reported(tmp_path: Path) -> None:
    assert main(["--kitti", str(tmp_path)]) == 1


@pytest.mark.skipif(not (_KITTI / "raw").exists(), reason="no KITTI raw in ../shared")
@pytest.mark.slow
def test_the_real_triples_are_judged_and_drawn(tmp_path: Path) -> None:
    kept, images = tmp_path / "kept.json", tmp_path / "images"
    command = ["--kitti", str(_KITTI), "--images", str(images), "--json", str(kept)]
    assert main(command) == 0
    result = row_of(ConnectedReal, json.loads(kept.read_text()))
    assert len(result.scans) == 6
    assert all(scan.residual < 0.03 for scan in result.scans)
    assert {row.state for row in result.decisions} == {"clean", "paste", "removal"}
    assert (images / "connected_real_paste.png").read_bytes().startswith(b"\x89PNG")
