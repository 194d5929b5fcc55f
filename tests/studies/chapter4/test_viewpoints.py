"""Surfaces by viewpoints: what is kept comes back, and rates are those of the distances."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED, Part
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.storage.json_lines import JsonLines
from studies.chapter4 import viewpoints
from studies.chapter4.viewpoint_rates import RATES, viewpoint_rates
from studies.chapter4.viewpoints import (
    APART,
    CLEAN,
    DELAUNAY,
    GHOST,
    OPTIMISED,
    OPTIMISED_PLACES,
    SIDES,
    SUCCESSIVE,
    KeptPlace,
    PlaceResult,
    RegionDistances,
    measured_place,
    measured_places,
    ways,
)
from studies.chapter4.viewpoints_page import main, viewpoints_page


def made_up(seed: int, part: Part, number: int) -> PlaceResult:
    """A place whose attack-free distances are 0 to 0.9 m, and whose ghost is 0.5 or 2 m away."""
    regions = []
    for view in (SUCCESSIVE, APART):
        for mesher, sides in ways(OPTIMISED_PLACES):
            own = part, f"{part} {number}", view
            clean = tuple(np.arange(10) / 10)
            regions.append(RegionDistances(*own, CLEAN, mesher, sides, clean))
            if part == JUDGED:
                near = (0.2, 2.0) if view == SUCCESSIVE or number % 2 else (0.2, 0.5)
                regions.append(RegionDistances(*own, GHOST, mesher, sides, near))
    attacks = ((SUCCESSIVE, GHOST), (APART, GHOST)) if part == JUDGED else ()
    return PlaceResult(tuple(regions), attacks, attacks[:1], {DELAUNAY: (0.5, 10)})


@pytest.fixture
def _made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewpoints, "measured_place", made_up)


@pytest.mark.usefixtures("_made_up")
def test_rates_are_those_of_the_distances(tmp_path: Path) -> None:
    kept = JsonLines(tmp_path / "samples.jsonl", KeptPlace)
    result = viewpoint_rates(measured_places(10, kept, 5), 5)
    assert (result.places, result.seed) == (10, 5)
    way = {
        (each.viewpoints, each.attack): each
        for each in result.ways
        if (each.mesher, each.sides) == (DELAUNAY, SIDES[0])
    }
    seen, apart = way[SUCCESSIVE, GHOST], way[APART, GHOST]
    assert [each.rate for each in seen.detection] == list(RATES)
    assert seen.detection[0].theta == pytest.approx(0.8)
    assert seen.detection[1].theta == pytest.approx(0.6)
    assert [each.detected.rate for each in seen.detection] == [1.0, 1.0]
    assert [each.detected.rate for each in apart.detection] == [0.5, 0.5]
    assert seen.detection[0].false_alarms.rate == pytest.approx(0.1)
    assert seen.clean_below.rate == pytest.approx(0.8)
    assert (seen.attacked_above.count, seen.attacked_above.of) == (10, 20)
    assert seen.median == pytest.approx(1.1)
    covered = {(each.viewpoints, each.attack): each.covered.rate for each in result.covers}
    assert covered[SUCCESSIVE, GHOST] == 1.0
    assert covered[APART, GHOST] == 0.0
    assert result.times[0].seconds == pytest.approx(0.05)
    page = viewpoints_page(result)
    assert "**three vehicles**: 50.0" in page
    assert "less than in the thesis, 70 %" in page


@pytest.mark.usefixtures("_made_up")
def test_what_is_kept_is_not_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "samples.jsonl"
    first = measured_places(2, JsonLines(path, KeptPlace), 5)

    def refuse(*_: object) -> PlaceResult:
        raise AssertionError("measured again")

    monkeypatch.setattr(viewpoints, "measured_place", refuse)
    again = measured_places(2, JsonLines(path, KeptPlace), 5)
    assert as_json(again) == as_json(first)
    with pytest.raises(AssertionError):
        measured_places(3, JsonLines(path, KeptPlace), 5)
    with pytest.raises(AssertionError):
        measured_places(2, JsonLines(path, KeptPlace), 6)


@pytest.mark.usefixtures("_made_up")
def test_the_command_writes_page_and_result(tmp_path: Path) -> None:
    page, result = tmp_path / "page.md", tmp_path / "result.json"
    samples = ["--samples", str(tmp_path / "samples.jsonl"), "--places", "2"]
    assert main([*samples, "--markdown", str(page), "--json", str(result)]) == 0
    assert page.read_text().startswith("# Surfaces, by where the vehicles look from")
    assert '"viewpoints"' in result.read_text()


def test_few_places_are_compared_by_optimised_meshes() -> None:
    assert (OPTIMISED, SIDES[0]) in list(ways(0))
    assert OPTIMISED not in {mesher for mesher, _ in ways(OPTIMISED_PLACES)}


@pytest.mark.slow
def test_a_place_is_measured_from_both_viewpoints() -> None:
    fitted, judged = (measured_place(77, part, OPTIMISED_PLACES) for part in (FITTED, JUDGED))
    assert not fitted.attacks
    assert {each.state for each in fitted.regions} == {CLEAN}
    assert {each.viewpoints for each in judged.regions} == {SUCCESSIVE, APART}
    for place in (fitted, judged):
        assert all(d >= 0 for each in place.regions for d in each.distances)
        assert all(len(each.distances) <= 3 for each in place.regions)
