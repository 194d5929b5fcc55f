"""A measure of what is in reach tells of safety where average precision tells of what is far."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.json_rows import row_json, row_of
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
from studies.chapter5.telling_figure import draw_telling
from studies.chapter5.telling_flips import FlipRow, flip_rows
from studies.chapter5.telling_measures import (
    MEASURES,
    PRECISION,
    MeasureRow,
    compared_attacks,
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


def test_page_and_picture_are_made_of_the_rows(made: ModuleType, tmp_path: Path) -> None:
    outcomes, cases = measured(made)
    result = TellingMeasures(
        len(outcomes.scenarios), telling_rows(outcomes, cases), flip_rows(outcomes, cases)
    )
    found = row_of(TellingMeasures, json.loads(json.dumps(row_json(result), allow_nan=False)))
    assert found.measures[0] == result.measures[0]
    text = page(found, "command")
    assert "| cars in reach found | DSGN | all | 4 | 1.00 (" in text
    assert "| DSGN | perturbations | 30 in 4 scenes, 120 | 1.00 (" in text
    path = tmp_path / "telling.png"
    draw_telling(found.measures, found.flips, path)
    assert path.read_bytes().startswith(b"\x89PNG")
