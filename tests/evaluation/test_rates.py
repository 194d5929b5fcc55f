"""The main job: rates of sets of scenes, and the acceptance figures on the real ones."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from avsec_gym.attacks.object_injection import inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.scenario_picture import draw_episode, save_picture
from avsec_gym.evaluation.files import episode_with_tree, write_pictures, write_records
from avsec_gym.evaluation.rates import (
    DETECTIONS,
    GROUND_TRUTH,
    Detected,
    DrivingSafety,
    RatesKey,
    driving_safety,
    threshold_sweep,
)
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.plan import Reason
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import WITHOUT_CARS, labelled_scenarios, procedural_scenes

REASONS = {str(reason) for reason in Reason}


@pytest.fixture(scope="module")
def scenes() -> SceneSet:
    return procedural_scenes(40, seed=1)


@pytest.fixture(scope="module")
def detected(scenes: SceneSet) -> Detected:
    """The truth, with a wall of ghosts before some, and nothing at all in others."""
    wall = np.array([[9.0, y, np.pi / 2] for y in (-5.7, -1.9, 1.9, 5.7)])
    boxes = {}
    for i, scene in enumerate(scenes.scenes):
        plain = replace(scene.boxes, moving=None)
        boxes[scene.id] = inject_ghosts(plain, wall) if i % 5 == 0 else plain
        if i % 5 == 1:
            boxes[scene.id] = Boxes3D.empty()
    del boxes[scenes.scenes[2].id]
    return Detected(boxes, missing=(scenes.scenes[2].id,))


@pytest.fixture(scope="module")
def result(scenes: SceneSet, detected: Detected) -> DrivingSafety:
    return driving_safety(scenes, detected=detected)


def test_every_scene_is_driven_with_every_intention_and_input(result: DrivingSafety) -> None:
    cells = {
        RatesKey("astar", str(intention), name)
        for intention in Intention
        for name in (GROUND_TRUTH, DETECTIONS)
    }
    assert set(result.records) == cells
    for cell, records in result.records.items():
        assert [r.scenario for r in records] == [s.id for s in result.scenes.scenes]
        assert {r.intention for r in records} == {cell.intention}
        assert all((r.reason in REASONS) == (not r.planned) for r in records)


def test_records_are_what_the_pipeline_says(
    result: DrivingSafety, detected: Detected, scenes: SceneSet
) -> None:
    for i in (0, 1, 2, 3, 17):
        scene = scenes.scenes[i]
        clean = run_episode(scene, Intention.LEFT).record
        attacked = run_episode(
            scene,
            Intention.LEFT,
            detected.boxes.get(scene.id, Boxes3D.empty()),
            motion=Motion.STATIC,
        ).record
        assert (
            result.records[RatesKey("astar", "left", GROUND_TRUTH)][i].to_json() == clean.to_json()
        )
        assert (
            result.records[RatesKey("astar", "left", DETECTIONS)][i].to_json() == attacked.to_json()
        )


def test_flips_follow_from_the_records(result: DrivingSafety) -> None:
    report = result.to_json()
    flips = {(row["intention"], row["scenario"]) for row in report["flips"]}
    expected = {
        (str(intention), one.scenario)
        for intention in Intention
        for one, two in zip(
            result.records[RatesKey("astar", str(intention), GROUND_TRUTH)],
            result.records[RatesKey("astar", str(intention), DETECTIONS)],
            strict=True,
        )
        if one.safe and not two.safe
    }
    assert flips == expected
    assert len(flips) > 5
    assert {row["outcome"] for row in report["flips"]} <= {"collision", "unplanned"}


def test_differences_follow_from_the_records(result: DrivingSafety) -> None:
    truth, detections = [], []
    rows = {row.intention: row.to_json() for row in result.differences()}
    assert list(rows) == ["left", "straight", "right", "all"]
    for intention in ("left", "straight", "right"):
        first = result.records[RatesKey("astar", intention, GROUND_TRUTH)]
        second = result.records[RatesKey("astar", intention, DETECTIONS)]
        truth, detections = truth + first, detections + second
        expected = paired_differences(first, second)
        assert expected is not None
        assert expected.to_json().items() <= rows[intention].items()
    pooled = rows["all"]
    assert pooled["drives"] == 120
    lost = sum(a.safe and not b.safe for a, b in zip(truth, detections, strict=True))
    assert pooled["became_unsafe"] == lost == len(result.to_json()["flips"])
    three = [rows[name] for name in ("left", "straight", "right")]
    mean = np.mean([row["safe_driving_rate"] for row in three])
    assert pooled["safe_driving_rate"] == pytest.approx(mean)
    # Holm's correction is for the three intentions; pooled episodes of one scenario have no test.
    assert pooled["mcnemar_p"] is pooled["mcnemar_p_holm"] is None
    least = min(three, key=lambda row: row["mcnemar_p"])
    assert least["mcnemar_p_holm"] == pytest.approx(min(3 * least["mcnemar_p"], 1.0))


def test_the_report_is_json(result: DrivingSafety, scenes: SceneSet) -> None:
    report = json.loads(json.dumps(result.to_json(), allow_nan=False))
    assert report["settings"]["motion"] == {"ground_truth": "truth", "detections": "static"}
    assert report["settings"]["frames_without_detections"] == [scenes.scenes[2].id]
    by_group = [row for row in report["rates_by_group"] if row["group"] == "street"]
    highway = [row for row in report["rates_by_group"] if row["group"] == "highway"]
    for total, street, other in zip(report["rates"], by_group, highway, strict=True):
        for name in ("scenarios", "planned", "collisions"):
            assert total[name] == street[name] + other[name]


def test_progress_is_told(scenes: SceneSet) -> None:
    told: list[tuple[int, int]] = []
    driving_safety(
        scenes.limited(3),
        intentions=[Intention.LEFT],
        planners=tuple(Algorithm),
        on_progress=lambda done, total: told.append((done, total)),
    )
    assert told == [(i, 6) for i in range(1, 7)]


def test_default_thresholds() -> None:
    boxes = procedural_scenes(1).scenes[0].boxes
    scores = np.linspace(0.1, 0.9, len(boxes))
    shares = Detected({"a": replace(boxes, score=scores)})
    assert shares.score_threshold == 0.3
    assert len(shares.kept()["a"]) == (scores >= 0.3).sum()
    unbounded = Detected({"a": replace(boxes, score=scores - 0.5)})
    assert unbounded.score_threshold == 0.0
    assert len(Detected({"a": shares.boxes["a"]}, threshold=2.0).kept()["a"]) == 0
    assert Detected({}).kept() == {}


def test_a_higher_threshold_leaves_less(scenes: SceneSet) -> None:
    """Scores by distance: at the highest threshold nothing is believed, all is planned."""
    boxes = {s.id: replace(s.boxes, score=s.boxes.location[:, 2] / 100) for s in scenes.scenes}
    rows = threshold_sweep(scenes, Detected(boxes), [0.0, 2.0], intentions=[Intention.RIGHT])
    assert [row["score_threshold"] for row in rows] == [0.0, 2.0]
    assert rows[1]["success_rate"] == 1.0
    assert rows[0]["collision_rate"] <= rows[1]["collision_rate"]


def test_records_as_a_table(result: DrivingSafety, tmp_path: Path) -> None:
    write_records(result, tmp_path / "records.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["records.csv"]
    with (tmp_path / "records.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 * 40
    unsafe = sum(row["outcome"] != "safe" for row in rows)
    assert unsafe == sum(not r.safe for records in result.records.values() for r in records)
    assert {row["input"] for row in rows} == {GROUND_TRUTH, DETECTIONS}
    assert {row["group"] for row in rows} == {"street", "highway"}


def test_pictures_show_what_became_unsafe(
    result: DrivingSafety, detected: Detected, tmp_path: Path
) -> None:
    assert write_pictures(result, detected, tmp_path / "none", 0) == []
    files = write_pictures(result, detected, tmp_path / "some", 3)
    flips = {f"{row['scenario']}_{row['intention']}_astar.png" for row in result.to_json()["flips"]}
    assert len(files) == 3
    assert {file.name for file in files} <= flips
    assert {file.name for file in (tmp_path / "some").iterdir()} == {file.name for file in files}
    for file in files:
        scene = next(each for each in result.scenes.scenes if file.name.startswith(each.id))
        intention = Intention(file.name.split("_")[-2])
        boxes = detected.kept().get(scene.id, Boxes3D.empty())
        motion = Motion(result.settings["motion"][DETECTIONS])
        pictures = []
        for name, believed in (("believed", boxes), ("truth", scene.boxes)):
            shown = episode_with_tree(scene, intention, believed, motion)
            save_picture(draw_episode(shown), tmp_path / f"{name}.png", overwrite=True)
            pictures.append(cv2.imread(str(tmp_path / f"{name}.png")))
        np.testing.assert_array_equal(cv2.imread(str(file)), pictures[0])
        assert (pictures[0] != pictures[1]).any()


THESIS = {
    ("astar", "left"): 0.897, ("astar", "straight"): 0.980, ("astar", "right"): 0.852,
    ("gbfs", "left"): 0.879, ("gbfs", "straight"): 0.980, ("gbfs", "right"): 0.823,
}  # fmt: skip


@pytest.fixture(scope="module")
def labelled(shared: Path) -> SceneSet:
    return labelled_scenarios(shared / "safety_scenarios")


@pytest.mark.slow
def test_the_600_scenarios_are_at_or_above_the_thesis(labelled: SceneSet) -> None:
    result = driving_safety(labelled, planners=tuple(Algorithm))
    rows = {(row["planner"], row["intention"]): row for row in result.to_json()["rates"]}
    assert set(rows) == set(THESIS)
    for key, least in THESIS.items():
        row = rows[key]
        assert row["scenarios"] == 600
        assert row["safe_driving_rate"] >= least, key
        # The planner knows the truth: what it plans is safe.
        assert row["collisions"] == 0
        assert sum(row["failures"].values()) == 600 - row["planned"]
        assert set(row["failures"]) <= REASONS
    for records in result.records.values():
        assert all((r.reason in REASONS) == (not r.planned) for r in records)
        # A plan is a certificate, and so is what both searches did not find.
    for intention in Intention:
        one, two = (
            [r.planned for r in result.records[RatesKey(name, str(intention), GROUND_TRUTH)]]
            for name in ("astar", "gbfs")
        )
        assert one == two
    without = [
        row
        for row in result.to_json()["rates_by_group"]
        if row["group"] == f"all but {WITHOUT_CARS}"
    ]
    assert {row["scenarios"] for row in without} == {556}


@pytest.mark.slow
def test_a_real_detector_on_the_600_scenarios(labelled: SceneSet, shared: Path) -> None:
    boxes, missing = DetectionFolder(shared / "detections/point_gnn").read(
        [scene.id for scene in labelled.scenes]
    )
    assert missing == []
    result = driving_safety(labelled, detected=Detected(boxes))
    report = result.to_json()
    assert report["settings"]["score_threshold"] == 0.0  # Point-GNN's scores exceed 1.
    rates = {(row["intention"], row["input"]): row for row in report["rates"]}
    for row in report["differences"][:3]:
        truth, detections = (rates[row["intention"], name] for name in (GROUND_TRUTH, DETECTIONS))
        low, high = row["safe_driving_rate_interval"]
        difference = detections["safe_driving_rate"] - truth["safe_driving_rate"]
        assert row["safe_driving_rate"] == pytest.approx(difference)
        assert low <= difference <= high < 0
        # The prototype had 87.0 / 96.5 / 85.0.
        assert 0.84 < detections["safe_driving_rate"] < 0.99
        assert 0 < detections["collision_rate"] < 0.1
        flips = [flip for flip in report["flips"] if flip["intention"] == row["intention"]]
        assert len(flips) == row["became_unsafe"]
        assert row["became_unsafe"] - row["became_safe"] == pytest.approx(-600 * difference)


def test_a_planner_that_does_not_know_what_moves_collides(labelled: SceneSet) -> None:
    static = driving_safety(labelled, truth_motion=Motion.STATIC)
    collisions = [static.rates(cell).collisions for cell in static.records]
    assert all(count > 0 for count in collisions)
    planner = MotionPrimitivePlanner()
    for cell, records in static.records.items():
        for scene, one in zip(labelled.scenes, records, strict=True):
            if one.collision:
                # Only what moves is hit.
                shown = run_episode(
                    scene, Intention(cell.intention), motion=Motion.STATIC, planner=planner
                )
                assert not shown.truth.static[one.collision_object or 0]


def test_the_main_job_begins_without_what_it_does_not_need() -> None:
    """`scipy.stats` alone takes as long to load as a thousand drives."""
    code = (
        "import sys, avsec_gym.evaluation.rates;"
        "print(*{'torch', 'matplotlib', 'scipy.stats', 'scipy.optimize'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
