"""Contested objects: missed alone, they make a drive unsafe."""

from __future__ import annotations

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.geometry import Floats, ego_to_camera
from avsec_gym.metrics.safety_weighted_recall import safety_weighted_recall
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from studies.chapter5.measures.contested_objects import contested_objects


def scene(*poses: list[float], category: str = "Car") -> Scene:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    size, categories = np.tile([1.5, 1.6, 4.0], (count, 1)), np.full(count, category)
    return Scene("made", Boxes3D(location, size, rotation_y, np.ones(count), categories))


BESIDE, FAR, BEHIND = [13.0, 3.5, 0.0], [40.0, 3.5, 0.0], [-12.0, 3.5, 0.0]


def test_the_rule_by_hand() -> None:
    several = scene(FAR, BESIDE, BEHIND)
    found = {way: contested_objects(several, way).tolist() for way in Intention}
    assert found == {
        Intention.LEFT: [False, True, False],
        Intention.STRAIGHT: [False, False, False],
        Intention.RIGHT: [False, False, False],
    }


def test_a_single_object_is_contested_where_its_scene_is() -> None:
    for pose in (BESIDE, FAR, [12.0, 0.2, 0.1], [9.0, -3.0, 0.0]):
        one = scene(pose)
        for way in Intention:
            assert contested_objects(one, way).tolist() == [is_contested(one, way)]


def test_of_two_in_one_place_each_may_be_missed() -> None:
    both = scene(BESIDE, BESIDE)
    assert is_contested(both, Intention.LEFT)
    assert not contested_objects(both, Intention.LEFT).any()


def test_where_all_that_is_seen_leaves_no_safe_way_nothing_is_contested() -> None:
    wall = scene(*([12.0, y, 0.0] for y in (-3.5, 0.0, 3.5)))
    assert not any(contested_objects(wall, way).any() for way in Intention)


def test_what_is_no_obstacle_is_never_contested() -> None:
    assert not contested_objects(scene(BESIDE, category="Pedestrian"), Intention.LEFT).any()
    assert contested_objects(scene(), Intention.LEFT).shape == (0,)


def test_they_are_weights_of_a_recall() -> None:
    """The share of those found that must not be missed."""

    def must_not_be_missed(real: Boxes3D, intention: Intention) -> Floats:
        return contested_objects(Scene("", real), intention).astype(float)

    beside, far = scene(BESIDE).boxes, scene(FAR).boxes
    truth = [scene(BESIDE, FAR).boxes] * 2
    found = safety_weighted_recall(truth, [beside, far], weigh=must_not_be_missed)
    assert found.recall.value == 0.5
    assert found.by_intention == {"left": 0.5, "straight": None, "right": None}
    assert found.weighed == 2
