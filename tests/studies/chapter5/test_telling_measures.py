"""A measure of what is in reach tells of safety where average precision tells of what is far."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.geometry import Floats
from avsec_gym.metrics.safety_weighted_recall import safety_weighted_recall
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.case_measures import (
    CARS_FOUND,
    CASE_MEASURES,
    CONTACT_AGREEMENT,
    CONTACT_RECALL,
    CONTESTED,
    PLANNING_KL,
    REACH_FOUND,
    SUPPORT,
    CaseMeasures,
    case_measures,
)
from studies.chapter5.measures.contested_objects import contested_objects
from studies.chapter5.telling_figure import draw_telling
from studies.chapter5.telling_flips import FlipRow, flip_rows
from studies.chapter5.telling_measures import (
    MEASURES,
    PRECISION,
    MeasureRow,
    compared_attacks,
    corrected,
    telling_rows,
)
from studies.chapter5.telling_page import TellingMeasures, page

CLEAN = Condition("dsgn")
ATTACKS = tuple(Condition("dsgn", "thesis_pgd-1", float(n)) for n in (1, 2, 3, 4))
COUNT = 10
NAMES = [f"{number:06d}" for number in range(COUNT)]
NEAR_LOST, FAR_LOST = (1, 2, 3, 4), (8, 5, 3, 0)


def cases_of(outcomes: Outcomes, conditions: tuple[Condition, ...]) -> CaseMeasures:
    scenes = [
        Scene(name, boxes, "street", number=number)
        for number, (name, boxes) in enumerate(outcomes.labels.items())
    ]
    return case_measures(outcomes, scenes, Motion.STATIC, conditions, 0.3)


_KNOWN: dict[float, tuple[Outcomes, CaseMeasures]] = {}
"""By drift: measuring takes seconds."""


def measured(made: ModuleType, drift: float = 0.0) -> tuple[Outcomes, CaseMeasures]:
    if drift not in _KNOWN:
        outcomes = lost_cars(made, drift)
        _KNOWN[drift] = outcomes, cases_of(outcomes, (CLEAN, *compared_attacks(outcomes)))
    return _KNOWN[drift]


def lost_cars(made: ModuleType, drift: float = 0.0) -> Outcomes:
    """A car in reach and one beyond; episodes are unsafe where the near one is lost."""
    near, far = made.car(z=12.0, score=0.9), made.car(z=35.0, score=0.9)
    seen_near = made.car(x=drift, z=12.0, score=0.9)
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.seen[CLEAN.setting, 0.0] = {name: made.boxes(seen_near, far) for name in NAMES}
    for attack, lost, lost_far in zip(ATTACKS, NEAR_LOST, FAR_LOST, strict=True):
        results.add(attack, NAMES, unsafe=NAMES[:lost])
        results.seen[attack.setting, attack.strength] = {
            name: made.boxes(
                *([seen_near] if number >= lost else []),
                *([far] if number < len(NAMES) - lost_far else []),
            )
            for number, name in enumerate(NAMES)
        }
    return Outcomes(results, {name: made.boxes(near, far) for name in NAMES})


def over_attacks(outcomes: Outcomes, cases: CaseMeasures) -> dict[tuple[str, str, str], MeasureRow]:
    rows = telling_rows(outcomes, cases)
    return {(row.measure, row.detector, row.family): row for row in rows}


def in_drives(outcomes: Outcomes, cases: CaseMeasures) -> dict[str, FlipRow]:
    rows = flip_rows(outcomes, cases)
    return {row.measure: row for row in rows if (row.detector, row.family) == ("dsgn", "all")}


@pytest.mark.slow
def test_cars_in_reach_tell_what_all_cars_do_not(made: ModuleType) -> None:
    rows = over_attacks(*measured(made))
    assert {measure for measure, *_ in rows} == set(MEASURES)
    reach, every = rows[REACH_FOUND, "dsgn", "all"], rows[CARS_FOUND, "dsgn", "all"]
    assert reach.attacks == 4
    assert reach.rho == pytest.approx(1)
    both_lost = np.add(NEAR_LOST, FAR_LOST)
    assert every.rho == pytest.approx(spearmanr(both_lost, NEAR_LOST).statistic)
    assert rows[PRECISION, "both", "all"].more.value == 0
    assert reach.more.value == pytest.approx(1 - rows[PRECISION, "dsgn", "all"].rho)
    low, high = reach.more.interval
    assert low <= reach.more.value <= high
    for measure in (CONTACT_RECALL, CONTESTED, PLANNING_KL):
        assert rows[measure, "dsgn", "all"].rho == pytest.approx(1)
    assert rows[REACH_FOUND, "both", "perturbations"].attacks == 4
    assert rows[REACH_FOUND, "both", "perturbations"].rho == pytest.approx(1)
    assert rows[REACH_FOUND, "dsgn", "patches"].attacks == 0
    assert rows[REACH_FOUND, "dsgn", "patches"].rho is None


@pytest.mark.slow
def test_a_box_beside_its_car_counts_as_found_but_not_as_precise(made: ModuleType) -> None:
    drifted = over_attacks(*measured(made, drift=0.8))
    assert drifted[REACH_FOUND, "dsgn", "all"].rho == pytest.approx(1)
    assert drifted[PRECISION, "dsgn", "all"].rho != pytest.approx(1)


@pytest.mark.slow
def test_drives_that_turn_are_told_by_what_is_lost_in_reach(made: ModuleType) -> None:
    rows = in_drives(*measured(made))
    reach, every = rows[REACH_FOUND], rows[CARS_FOUND]
    assert (reach.episodes, reach.became_unsafe, reach.scenes) == (120, 3 * sum(NEAR_LOST), 4)
    assert reach.area == 1
    # A hit loses one car; so do those that lose the far one, which ties, and no other.
    pairs = [
        (near * (COUNT - near), near * far) for near, far in zip(NEAR_LOST, FAR_LOST, strict=True)
    ]
    expected = sum(all_pairs - 0.5 * ties for all_pairs, ties in pairs) / sum(p for p, _ in pairs)
    assert every.area == pytest.approx(expected)
    low, high = every.interval
    assert low < every.area < high
    # Of one car of two lost, precision loses as much wherever it stood.
    assert rows[PRECISION].area == pytest.approx(expected)
    assert reach.more.value == pytest.approx(1 - expected)
    assert rows[PLANNING_KL].area > every.area


@pytest.mark.slow
def test_ghosts_are_told_by_measures_that_know_of_them(made: ModuleType) -> None:
    real = made.car(x=14.0, z=40.0, score=0.9)
    ghost = made.car(z=11.0, score=0.9)
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.seen[CLEAN.setting, 0.0] = dict.fromkeys(NAMES, real)
    for attack, seen in zip(ATTACKS, (1, 2, 3, 4), strict=True):
        results.add(attack, NAMES, unsafe=NAMES[:seen])
        results.seen[attack.setting, attack.strength] = {
            name: made.boxes(real, *([ghost] if number < seen else []))
            for number, name in enumerate(NAMES)
        }
    outcomes = Outcomes(results, dict.fromkeys(NAMES, real))
    rows = in_drives(outcomes, cases_of(outcomes, (CLEAN, *ATTACKS)))
    assert rows[PLANNING_KL].area == rows[SUPPORT].area == 1
    for blind in (CARS_FOUND, REACH_FOUND, CONTACT_RECALL, CONTESTED):
        assert rows[blind].area == 0.5


@pytest.mark.parametrize(
    ("seen", "expected"),
    [
        ("all", {CARS_FOUND: 1, REACH_FOUND: 1, CONTACT_RECALL: 1, CONTESTED: 1, SUPPORT: 1}),
        ("none", {CARS_FOUND: 0, REACH_FOUND: 0, CONTACT_RECALL: 0, CONTESTED: 0, SUPPORT: 0}),
        ("far", {CARS_FOUND: 0.5, REACH_FOUND: 0, CONTACT_RECALL: 0, CONTESTED: 0}),
    ],
)
def test_a_case_by_hand(made: ModuleType, seen: str, expected: dict[str, float]) -> None:
    near, far = made.car(z=12.0, score=0.9), made.car(z=35.0, score=0.9)
    # Of a low score: not planned on.
    unsure = made.car(z=12.0, score=0.1)
    boxes: dict[str, Boxes3D] = {
        "all": made.boxes(near, far), "none": unsure, "far": made.boxes(far, unsure)
    }  # fmt: skip
    results = made.MadeResults()
    results.add(CLEAN, NAMES[:1])
    results.seen[CLEAN.setting, 0.0] = {NAMES[0]: boxes[seen]}
    outcomes = Outcomes(results, {NAMES[0]: made.boxes(near, far)})
    found = cases_of(outcomes, (CLEAN,))[CLEAN]
    assert set(found) == set(CASE_MEASURES)
    straight = {name: values[0, 1] for name, values in found.items()}
    for name, share in expected.items():
        part, whole = straight[name]
        assert part / whole == pytest.approx(share), name
    divergence = -straight[PLANNING_KL][0]
    assert divergence == 0 if seen == "all" else divergence > 1
    assert straight[CONTACT_AGREEMENT][1] == straight[CONTACT_RECALL][1]


def test_differences_from_average_precision_are_corrected_for_all_rows(made: ModuleType) -> None:
    outcomes, cases = measured(made)
    for rows in (telling_rows(outcomes, cases), flip_rows(outcomes, cases)):
        compared = [row for row in rows if row.more.value is not None and row.measure != PRECISION]
        assert compared
        assert {row.p_holm is None for row in compared} == {False}
        assert all(row.p_holm is None for row in rows if row not in compared)
        assert all(row.p_holm == 1 for row in compared if row.more.value == 0)
    # Holm's by its definition, step by step.
    p = [0.001, np.nan, 0.04, 0.02]
    assert corrected(p) == [pytest.approx(0.003), None, pytest.approx(0.04), pytest.approx(0.04)]


def test_found_by_time_to_contact_is_the_recall_that_the_command_shows(made: ModuleType) -> None:
    outcomes, cases = measured(made)
    for condition in (CLEAN, *ATTACKS):
        labels, seen = [*outcomes.labels.values()], outcomes.detections(condition)
        found = safety_weighted_recall(labels, seen)
        part, whole = cases[condition][CONTACT_RECALL].sum(axis=(0, 1))
        assert found.recall.value == pytest.approx(part / whole)

        def must_not_be_missed(real: Boxes3D, intention: Intention) -> Floats:
            scene = Scene("", real, "street")
            return contested_objects(scene, intention, motion=Motion.STATIC).astype(float)

        contested = safety_weighted_recall(labels, seen, weigh=must_not_be_missed)
        part, whole = cases[condition][CONTESTED].sum(axis=(0, 1))
        assert contested.recall.value == pytest.approx(part / whole)


def test_motion_by_a_classifier_is_measured_with_the_flags_that_it_gave(made: ModuleType) -> None:
    """A car that is taken to drive on is not in the way."""
    near = made.car(z=12.0, score=0.9)
    results = made.MadeResults()
    results.add(CLEAN, NAMES[:2])
    results.seen[CLEAN.setting, 0.0] = {
        name: replace(near, moving=np.array([moves]))
        for name, moves in zip(NAMES, (False, True), strict=False)
    }
    outcomes = Outcomes(results, dict.fromkeys(NAMES[:2], near))
    scenes = [Scene(name, near, "street") for name in NAMES[:2]]
    found = case_measures(outcomes, scenes, Motion.CLASSIFIER, (CLEAN,), 0.3)[CLEAN]
    divergence = -found[PLANNING_KL][:, 1, 0]
    assert divergence[0] == 0
    assert divergence[1] > 0.1


def test_page_and_picture_are_made_of_the_rows(made: ModuleType, tmp_path: Path) -> None:
    outcomes, cases = measured(made)
    result = TellingMeasures.of(
        len(outcomes.scenarios), telling_rows(outcomes, cases), flip_rows(outcomes, cases)
    )
    found = row_of(TellingMeasures, json.loads(json.dumps(row_json(result), allow_nan=False)))
    assert found.measures[0] == result.measures[0]
    text = page(found, "command")
    assert text == page(result, "command")
    assert "## The measure that works best" in text
    assert "works best: ρ 1.00" in text
    assert "| p, corrected |" in text
    assert "not corrected" not in text
    earlier = TellingMeasures(
        result.scenarios,
        [replace(row, p_holm=None) for row in result.measures],
        [replace(row, p_holm=None) for row in result.flips],
    )
    assert "works best" not in page(earlier, "command")
    assert "not corrected for the number of rows" in page(earlier, "command")
    assert "| cars in reach found | DSGN | all | 4 | 1.00 (" in text
    assert "| DSGN | perturbations | 30 in 4 scenes, 120 | 1.00 (" in text
    path = tmp_path / "telling.png"
    draw_telling(found.measures, found.flips, path)
    assert path.read_bytes().startswith(b"\x89PNG")
