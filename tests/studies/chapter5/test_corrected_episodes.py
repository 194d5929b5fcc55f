"""What an error costs comes back when that error is corrected, and by no other correction."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
import shapely.affinity

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
from studies.chapter5.corrected_episodes import (
    AS_FOUND,
    CORRECTED,
    EVERYTHING,
    GHOSTS_IN,
    corrected_rows,
)
from studies.chapter5.costly_errors import CostlyErrors, page
from studies.chapter5.ghost_lanes import GhostLane, ghost_lanes
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
    assert "| ghosts, own lane corrected | ghosts, goal lane corrected |" in text
    assert f"for all {len(CORRECTED) - 1} gains." in text
    assert "\\* |" not in text
    sure = [replace(row, p_holm=0.001) for row in errors if row.corrected == "misses"]
    marked = page(CostlyErrors(2, headroom, [errors[0], *sure]), "command")
    assert "\\* |" in marked
    assert "Ghosts of one lane" not in marked


def ghost_at(x: float) -> Boxes3D:
    """A ghost as wide as a lane, its middle so far to the right of the camera."""
    return replace(GHOST, location=GHOST.location + np.array([x, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("x", "lanes"),
    [
        (0.0, ("own lane", "own lane", "own lane")),
        (-3.5, ("goal lane", "elsewhere", "elsewhere")),
        (3.5, ("elsewhere", "elsewhere", "goal lane")),
        (-9.0, ("elsewhere", "elsewhere", "elsewhere")),
        (-1.8, ("own lane", "own lane", "own lane")),
    ],
)
def test_ghosts_are_dropped_lane_by_lane(
    made: ModuleType, x: float, lanes: tuple[str, str, str]
) -> None:
    """As many episodes become safe as there are intentions in whose lane it stands."""
    nothing, ghost = made.car()[:0], ghost_at(x)
    safe = safe_by_kind(made, nothing, ghost)
    scene = Scene(NAMES[0], nothing, "street")
    for lane in GhostLane:
        episodes = [
            run_episode(
                scene,
                way,
                nothing if lanes[number] == lane else ghost,
                motion=Motion.STATIC,
            ).record.safe
            for number, way in enumerate(Intention)
        ]
        assert safe[GHOSTS_IN[lane]] == pytest.approx(np.mean(episodes)), lane


def test_lanes_agree_with_polygons() -> None:
    random = np.random.default_rng(4)
    count = 400
    location = np.column_stack(
        [random.uniform(-8, 8, count), np.full(count, 1.65), random.uniform(5, 30, count)]
    )
    size = np.column_stack(
        [np.full(count, 1.5), random.uniform(0.5, 3, count), random.uniform(0.5, 6, count)]
    )
    boxes = Boxes3D(
        location, size, random.uniform(-np.pi, np.pi, count), np.ones(count), ["Car"] * count
    )
    feet = [
        shapely.affinity.translate(
            shapely.affinity.rotate(
                shapely.box(-length / 2, -width / 2, length / 2, width / 2),
                heading,
                origin=(0, 0),
                use_radians=True,
            ),
            x,
            y,
        )
        for (x, y, heading), length, width in zip(
            boxes.poses, boxes.length, boxes.width, strict=True
        )
    ]
    strips = {
        Intention.LEFT: shapely.box(-50, 1.75, 50, 5.25),
        Intention.STRAIGHT: shapely.box(-50, -1.75, 50, 1.75),
        Intention.RIGHT: shapely.box(-50, -5.25, 50, -1.75),
    }
    for way in Intention:
        expected = [
            GhostLane.OWN
            if foot.intersects(strips[Intention.STRAIGHT])
            else GhostLane.GOAL
            if foot.intersects(strips[way])
            else GhostLane.ELSEWHERE
            for foot in feet
        ]
        assert ghost_lanes(boxes, way) == expected
        assert {*expected} == {*GhostLane} - ({GhostLane.GOAL} if way == "straight" else set())


def test_the_joint_patch_is_corrected_too_and_its_gain_is_sure_where_many_scenarios_gain(
    made: ModuleType,
) -> None:
    joint = Condition("dsgn", "joint-random")
    results, names = made.MadeResults(), made.names(12)
    results.add(CLEAN, names)
    results.add(joint, names, extra=GHOST)
    empty = made.car()[:0]
    results.seen[CLEAN.setting, 0.0] = dict.fromkeys(names, empty)
    results.seen[joint.setting, 0.0] = dict.fromkeys(names, GHOST)
    outcomes = Outcomes(results, dict.fromkeys(names, empty))
    scenes = SimpleNamespace(
        scenes=SimpleNamespace(labelled=[Scene(name, empty, "street") for name in names])
    )
    rows = corrected_rows(outcomes, scenes, Motion.STATIC, 0.3)  # type: ignore[arg-type]
    p = {(row.condition, row.corrected): row.p_holm for row in rows}
    assert p[joint, AS_FOUND] is None
    # All twelve gain, of fourteen corrections.
    assert p[joint, GHOSTS_IN[GhostLane.OWN]] == pytest.approx(14 * 2 / 2**12)
    assert p[joint, GHOSTS_IN[GhostLane.ELSEWHERE]] == p[CLEAN, "ghosts"] == 1


def test_motion_that_was_classified_stays_as_it_was_found(made: ModuleType) -> None:
    """A drifted box is moved to its car with its own flag; what was missed has the label's."""
    near, far = made.car(z=11.0), made.car(x=3.5, z=14.0)
    truth = replace(made.boxes(near, far), moving=np.array([True, True]))
    seen = replace(made.car(x=1.2, z=11.0), moving=np.array([False]))
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.seen[CLEAN.setting, 0.0] = dict.fromkeys(NAMES, seen)
    outcomes = Outcomes(results, dict.fromkeys(NAMES, truth))
    scenes = scenes_with(truth)
    rows = corrected_rows(outcomes, scenes, Motion.CLASSIFIER, 0.3)
    safe = {row.corrected: row.rates.safe_driving_rate for row in rows}

    def driven_on(believed: Boxes3D) -> float:
        return float(
            np.mean(
                [
                    run_episode(scene, way, believed, motion=Motion.CLASSIFIER).record.safe
                    for scene in scenes.scenes.labelled
                    for way in Intention
                ]
            )
        )

    stands = replace(near, moving=np.array([False]))
    drives_on = replace(far, moving=np.array([True]))
    assert safe["places"] == driven_on(stands)
    assert safe["misses"] == driven_on(Boxes3D.concatenate([seen, drives_on]))
    assert safe[EVERYTHING] == driven_on(truth)
