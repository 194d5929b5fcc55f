"""The section of a run in which it is known what every method finds."""

from __future__ import annotations

import json

import pytest

from avsec_gym.drawing.page_figure import Figure
from avsec_gym.experiments.chapter4.in_words import connected_sentences
from avsec_gym.experiments.chapter4.section import connected_section
from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, BY_RAYS, FIVE
from avsec_gym.experiments.chapter4.summary import ConnectedSummary, connected_summary
from avsec_gym.experiments.json_rows import as_json, row_of
from tests.experiments.chapter4.known_run import Kept, known_rows

PLACES = 20


@pytest.fixture(scope="module")
def summary() -> ConnectedSummary:
    found = connected_summary(Kept(known_rows(PLACES)))  # type: ignore[arg-type]
    assert found is not None
    json.dumps(as_json(found), allow_nan=False)
    return found


def test_attacks_are_counted_end_to_end(summary: ConnectedSummary) -> None:
    rays, surfaces = (
        next(row for row in summary.attacks if (row.kind, row.method) == ("ghost", method))
        for method in ("rays", "surfaces")
    )
    # At a fifth of the places there was nothing to attack; the others end in four ways.
    assert rays.covered.of == 4 * PLACES / 5
    # One is decidable though no region is about it, another is not though a region is.
    assert (rays.covered.rate, rays.decidable.rate) == (3 / 4, 3 / 4)
    assert rays.decidable_by_rays.rate == 1 / 4
    assert (rays.detected.rate, rays.of_decidable.rate, rays.of_regions.rate) == (2 / 4, 2 / 3, 1)
    assert (surfaces.detected.rate, surfaces.of_decidable.rate) == (1 / 4, 1 / 3)
    assert surfaces.of_regions.rate == 1 / 2


def test_names_are_counted_by_witnesses(summary: ConnectedSummary) -> None:
    rows = {
        (row.namer, row.witnesses): (row.victim.of, row.victim.count, row.another.count)
        for row in summary.namings
        if (row.kind, row.by) == ("ghost", BY_GEOMETRY)
    }
    each = PLACES // 5
    assert rows["rays", 0] == (4 * each, 3 * each, 0)
    assert rows["rays", 1] == (2 * each, 2 * each, 0)
    assert rows["rays", 3] == (each, each, 0)
    assert rows["learned", 3] == (each, 0, each)
    # What the thesis names alone may be named no longer once two others have to accuse.
    assert (rows["thesis", 1], rows["surfaces", 1]) == ((2 * each, each, 0), (2 * each, 0, 0))
    by_rays = {
        row.witnesses: (row.victim.of, row.victim.count)
        for row in summary.namings
        if (row.kind, row.by, row.namer) == ("ghost", BY_RAYS, "rays")
    }
    assert by_rays == {1: (each, each), 3: (each, each)}
    cannot_tell = next(row for row in summary.namings if row.namer == "surfaces").cannot_tell
    assert cannot_tell.count == 2 * each


def test_honest_vehicles_named_anywhere_are_counted(summary: ConnectedSummary) -> None:
    rows = {(row.state, row.namer): row.instants for row in summary.honest}
    assert (rows["clean", "rays"].count, rows["clean", "rays"].of) == (1, PLACES)
    assert (rows["ghost", "thesis"].count, rows["ghost", "thesis"].of) == (4, 4 * PLACES / 5)
    assert rows["ghost", "rays"].count == rows["clean", "thesis"].count == 0


def test_attacks_are_counted_by_distance_and_category(summary: ConnectedSummary) -> None:
    near, middle, far, farthest = (row for row in summary.by_distance if row.kind == "ghost")
    assert [row.covered.of for row in (near, middle, far, farthest)] == [0, 8, 4, 4]
    assert (middle.covered.rate, middle.decidable.rate, middle.detected["rays"].of) == (0.5, 0.5, 0)
    assert (far.detected["rays"].rate, far.detected["surfaces"].rate) == (1.0, 0.0)
    cars, people = summary.removed
    assert (cars.category, cars.covered.of, cars.covered.rate) == ("Car", 12, 1.0)
    assert (people.category, people.covered.rate, people.decidable.rate) == ("Pedestrian", 0, 1)
    assert cars.detected.rate == 2 / 3


def test_probabilities_are_held_against_what_was_attacked(summary: ConnectedSummary) -> None:
    rows = {row.low: row for row in summary.reliability if row.method == "rays"}
    assert (rows[0.0].attacked.of, rows[0.1].attacked.of) == (PLACES, 4 * PLACES)
    assert rows[0.1].mean == pytest.approx(0.25)
    assert rows[0.01].mean is None
    # A ghost and a removal at each fifth place.
    assert (rows[0.9].attacked.rate, rows[0.9].attacked.of) == (1.0, 2 * PLACES / 5)


def test_times_and_bytes_of_all_vehicles(summary: ConnectedSummary) -> None:
    rows = {(row.state, row.method): row for row in summary.after_proposals}
    assert rows["clean", "rays"].largest == pytest.approx(0.2)
    assert rows["clean", "rays"].median == pytest.approx(0.105)
    assert (rows["ghost", "rays"].median, rows["ghost", "rays"].instants) == (0.03, 16)
    # Of attacked ones, only those about the attack are known.
    each = rows["clean", "rays"]
    assert each.regions is not None
    assert each.of_region == pytest.approx(0.105 / each.regions, rel=0.1)
    assert rows["ghost", "rays"].of_region is None
    kinds = {(row.sender, row.kind): (row.mean, row.most) for row in summary.sent_kinds}
    assert kinds["vehicle", "proposals"] == (20.0, 30)
    assert kinds["base station", "regions"] == (500.0, 500)


def test_areas_and_rates_of_known_scores(summary: ConnectedSummary) -> None:
    rows = {(row.kind, row.method): row for row in summary.roc}
    assert rows["removal", "rays"].area.value == 1.0
    # Half of the attacks are above all regions, half below.
    assert rows["ghost", "surfaces"].area.value == 0.5
    assert rows["ghost", "surfaces"].true_positives["0.01"].rate == 0.5
    assert rows["ghost", "surfaces"].regions == 9 * PLACES
    # By the counts of rays only the highest of all attacks is decidable.
    assert rows["ghost", "surfaces"].attacks_by_rays == PLACES / 5
    assert rows["ghost", "surfaces"].area_by_rays.value == 1.0


def test_thresholds_keep_what_they_designate(summary: ConnectedSummary) -> None:
    for row in summary.detection:
        if row.of == "regions":
            assert row.false_alarms.rate is not None
            assert row.false_alarms.rate <= row.rate
    # A third of the pairs is 1.5 m apart, which no region's score is.
    of_pairs = {
        row.rate: row for row in summary.detection if (row.of, row.kind) == ("pairs", "ghost")
    }
    assert of_pairs[0.3].detected.rate == 0.5
    assert of_pairs[0.3].false_alarms.rate == 0.0
    assert of_pairs[0.4].false_alarms.rate == pytest.approx(6 / 9)


def test_a_frame_has_more_false_alarms_than_a_region(summary: ConnectedSummary) -> None:
    row = next(row for row in summary.false_alarms if row.rate == 0.1)
    assert row.regions.rate == 0.0
    assert row.decidable.rate == 0.9
    assert {row.most for row in summary.sent} == {3000, 300, 3180}
    assert [(each.step, each.where, each.seconds) for each in summary.times] == [
        ("claim", "vehicle", 0.05)
    ]


def test_figures_are_read_back_from_their_json(summary: ConnectedSummary) -> None:
    figures = json.loads(json.dumps(as_json(summary)))
    assert row_of(ConnectedSummary, figures) == summary


def test_distances_beside_the_bound_of_the_thesis(summary: ConnectedSummary) -> None:
    [row] = summary.distances
    assert row.below["clean"].rate == pytest.approx(2 / 3)
    assert row.below["ghost"].rate == 0.0
    assert (row.compared["clean"].rate, row.compared["ghost"].rate) == (0.5, 0.5)
    for shares in row.bins.values():
        assert sum(shares) == pytest.approx(1.0)
    assert row.bins["clean"][30] == pytest.approx(1 / 3)


def test_the_section_is_whole(summary: ConnectedSummary) -> None:
    section = connected_section(summary)
    # Two attacks under the one condition that there is; the factors have panels of their own.
    figures = [part for part in section.parts if isinstance(part, Figure)]
    assert [len(figure.drawings) for figure in figures] == [2, 2, 2, 4]
    assert figures[3].drawings[1].count('class="reach"') == 3
    for table in section.tables:
        assert table.rows
        assert {len(line) for line in table.rows} == {len(table.columns)}
    said = " ".join(connected_sentences(summary))
    assert "Of all 16 ghosts with these errors, 75.0 %" in said
    assert (
        "0.0 % [0.0, 16.1] of the judged attack-free regions exceed the threshold of rays" in said
    )
    assert "rays detect 100.0 % [51.0, 100.0], AUC 1.000, of 4 ghosts" in said
    assert "and 100.0 % [67.6, 100.0], AUC 1.000, of the 8 of which clean scans" in said
    assert "(thesis: 70 %)" in said


def test_names_of_five_vehicles_are_stated() -> None:
    found = connected_summary(Kept(known_rows(PLACES, FIVE)))  # type: ignore[arg-type]
    assert found is not None
    ghosts, removals = connected_sentences(found)
    assert "rays name the victim of 100.0 % [51.0, 100.0]" in ghosts
    assert "of 4 ghosts of which 3 witnesses or more have 5 rays" in ghosts
    assert "of the 4 of which so many clean scans" in ghosts
    assert "of 4 removals of which 3 witnesses" in removals


def test_without_judged_instants_nothing_is_shown() -> None:
    rows = [row for row in known_rows(3) if row.setting.startswith("fitted")]
    assert connected_summary(Kept(rows)) is None  # type: ignore[arg-type]
