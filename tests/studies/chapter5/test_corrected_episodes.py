"""What an error costs comes back when that error is corrected, and by no other correction."""

from __future__ import annotations

from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.patch_ghosts import ghost_box
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import PLACEMENTS
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import run_episode
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.corrected_episodes import AS_FOUND, CORRECTED, EVERYTHING, corrected_rows
from studies.chapter5.costly_errors import CostlyErrors, page
from studies.chapter5.headroom import NOTHING, TRUTH, headroom_rows

CLEAN = Condition("dsgn")
NAMES = ["000001", "000002"]


GHOST = Boxes3D([[0.0, 1.65, 9.0]], [[1.5, 3.4, 6.0]], [-1.57], [0.9], ["Car"])
"""In the lane, so near that there is no way around it."""


def scenes_with(boxes: Boxes3D) -> Any:
    every = tuple(Scene(name, boxes, "street", number=n) for n, name in enumerate(NAMES))
    images = dict.fromkeys((2, 3), np.zeros((375, 1242, 3), np.uint8))
    return SimpleNamespace(
        scenes=SimpleNamespace(labelled=every),
        frame=lambda scene: SensorFrame(scene.id, kitti_rig().calibration, images),
    )


def safe_by_kind(made: ModuleType, truth: Boxes3D, seen: Boxes3D) -> dict[str, float]:
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.seen[CLEAN.setting, 0.0] = dict.fromkeys(NAMES, seen)
    outcomes = Outcomes(results, dict.fromkeys(NAMES, truth))
    rows = corrected_rows(outcomes, scenes_with(truth), Motion.STATIC, 0.3)
    assert [row.corrected for row in rows] == list(CORRECTED)
    safe = {row.corrected: row.rates.safe_driving_rate for row in rows}
    for row in rows:
        assert row.gain.value == pytest.approx(100 * (safe[row.corrected] - safe[AS_FOUND]))
    return safe


def driven(truth: Boxes3D, believed: Boxes3D) -> float:
    scene = Scene(NAMES[0], truth, "street")
    episodes = [run_episode(scene, way, believed, motion=Motion.STATIC).record for way in Intention]
    return sum(record.safe for record in episodes) / len(episodes)


def test_a_ghost_costs_safety_until_it_is_dropped(made: ModuleType) -> None:
    nothing = made.car()[:0]
    safe = safe_by_kind(made, nothing, made.boxes(GHOST))
    assert safe[AS_FOUND] == safe["misses"] == safe["places"] == driven(nothing, GHOST) < 1
    assert safe["ghosts"] == safe[EVERYTHING] == 1


def test_a_miss_costs_safety_until_it_is_added(made: ModuleType) -> None:
    car = made.car(z=11.0)
    safe = safe_by_kind(made, car, made.boxes())
    assert safe[AS_FOUND] == safe["ghosts"] == safe["places"] == driven(car, made.boxes())
    assert safe["misses"] == safe[EVERYTHING] == driven(car, car) > safe[AS_FOUND]


def test_a_box_beside_its_object_costs_safety_until_it_is_moved(made: ModuleType) -> None:
    car, drifted = made.car(z=11.0), made.car(x=1.2, z=11.0)
    safe = safe_by_kind(made, car, drifted)
    assert safe[AS_FOUND] == safe["ghosts"] == safe["misses"] == driven(car, drifted)
    assert safe["places"] == safe[EVERYTHING] == driven(car, car) != safe[AS_FOUND]


def test_boxes_that_are_not_planned_on_neither_help_nor_harm(made: ModuleType) -> None:
    car, unsure = made.car(z=11.0), made.car(z=11.0, score=0.2)
    assert safe_by_kind(made, car, unsure) == safe_by_kind(made, car, made.boxes())


def test_cars_without_a_detector(made: ModuleType) -> None:
    car = made.car(z=11.0)
    progress: list[tuple[int, int]] = []
    scenes = scenes_with(car)
    rows = headroom_rows(scenes, NAMES, Motion.STATIC, 5, lambda *done: progress.append(done))
    safe = {row.seen: row.rates.safe_driving_rate for row in rows}
    assert safe[TRUTH] == driven(car, car)
    assert safe[NOTHING] == driven(car, made.boxes())
    for placement in PLACEMENTS:
        patch, episodes = PatchAttack("grey", placement), []
        for scene in scenes.scenes.labelled:
            for number, way in enumerate(Intention):
                frame, aimed = scenes.frame(scene), Victim(None, car, way)
                own = (5, scene.number) if placement == "random" else (5, scene.number, number)
                ghost = ghost_box(patch.placed(frame, aimed, own), frame.calibration)
                believed = Boxes3D.concatenate([car, ghost])
                episodes.append(run_episode(scene, way, believed, motion=Motion.STATIC).record.safe)
        assert safe[placement] == np.mean(episodes)
    assert progress == [(1, 2), (2, 2)]


def test_the_page_names_all(made: ModuleType) -> None:
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    outcomes, scenes = made.outcomes(results, NAMES), scenes_with(made.car())
    errors = corrected_rows(outcomes, scenes, Motion.STATIC, 0.3)
    headroom = headroom_rows(scenes, NAMES, Motion.STATIC, 0)
    text = page(CostlyErrors(2, headroom, errors), "command")
    assert "the truth and a random patch’s ghost" in text
    assert "| DSGN | unattacked | " in text
