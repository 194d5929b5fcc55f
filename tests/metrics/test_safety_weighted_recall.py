"""Objects weigh what missing them would cost: worked out by hand, and by brute force."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, ego_to_camera
from avsec_gym.metrics.cluster_bootstrap import draw_resamples
from avsec_gym.metrics.contact_recall import contact_weights
from avsec_gym.metrics.safety_weighted_recall import safety_weighted_recall, time_to_contact
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.intention import Intention


def cars(*poses: tuple[float, float, float], score: float = 0.9, category: str = "Car") -> Boxes3D:
    """Of 4 x 1.8 m at x, y, heading in the ego frame."""
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    sizes = np.tile([1.5, 1.8, 4.0], (count, 1))
    scores, categories = np.full(count, score), np.full(count, category)
    return Boxes3D(location, sizes, rotation_y, scores, categories)


AT_ONCE, LATER, FAR = (3.0, 0.0, 0.0), (20.0, 0.0, 0.0), (60.0, 0.0, 0.0)
LATER_WEIGHT = 1 / (1 + 2.6)
"""The gap of 15.746 m less 0.5 m, at 6 m/s: 26 steps of 0.1 s."""


def test_what_is_near_sooner_weighs_more() -> None:
    truth = [cars(AT_ONCE, LATER, FAR)]

    def straight(*found: tuple[float, float, float]) -> float | None:
        return safety_weighted_recall(truth, [cars(*found)]).by_intention["straight"]

    assert straight(AT_ONCE, LATER, FAR) == straight(AT_ONCE, LATER) == pytest.approx(1)
    assert straight(AT_ONCE) == pytest.approx(1 / (1 + LATER_WEIGHT))
    assert straight(LATER) == pytest.approx(LATER_WEIGHT / (1 + LATER_WEIGHT))
    assert straight(FAR) == straight() == 0


def test_intentions_ask_for_what_is_in_their_way() -> None:
    """Beside the goal of the left lane; missed, it costs that intention alone."""
    beside = (14.0, 4.0, 0.0)
    found = safety_weighted_recall([cars(beside, LATER)], [cars(LATER)])
    assert found.by_intention["left"] == 0
    assert found.by_intention["straight"] == 1
    assert found.by_intention["right"] is None
    left = time_to_contact(cars(beside), Intention.LEFT)[0]
    assert found.recall.value == pytest.approx(LATER_WEIGHT / (LATER_WEIGHT + left))
    assert found.weighed == 2


def test_ghosts_unsure_boxes_and_other_classes() -> None:
    truth = cars(LATER)
    ghost = cars((8.0, 0.0, 0.0))
    everything = Boxes3D.concatenate([truth, ghost])
    assert safety_weighted_recall([truth], [everything]).recall.value == 1
    unsure = cars(LATER, score=0.2)
    assert safety_weighted_recall([truth], [unsure]).recall.value == 0
    assert safety_weighted_recall([truth], [unsure], threshold=0.1).recall.value == 1
    people = cars(LATER, category="Pedestrian")
    assert safety_weighted_recall([people], [people]).recall.value is None
    assert safety_weighted_recall([truth], [people]).recall.value == 0
    van = cars(LATER, category="Van")
    assert safety_weighted_recall([truth], [van]).recall.value == 1
    assert safety_weighted_recall([van], [van], category="Car").recall.value is None
    # A box that drifted aside by d overlaps its car by (1.8 - d) / (1.8 + d): 0.125 and 0.059.
    for drift, expected in ((1.4, 1.0), (1.6, 0.0)):
        moved = cars((20.0, drift, 0.0))
        assert safety_weighted_recall([truth], [moved]).recall.value == expected


def test_frames_are_resampled_with_all_their_intentions() -> None:
    random = np.random.default_rng(1)
    truth, seen = [], []
    for number in range(12):
        poses = np.column_stack(
            [random.uniform(6, 20, 3), [-4.0, 0.0, 4.0], random.uniform(-0.3, 0.3, 3)]
        )
        truth.append(cars(*map(tuple, poses)))
        seen.append(truth[-1][random.random(3) < (0.9 if number % 2 else 0.4)])
    found = safety_weighted_recall(truth, seen, resamples=300, seed=4)
    parts, wholes = np.zeros(12), np.zeros(12)
    for number, (real, boxes) in enumerate(zip(truth, seen, strict=True)):
        for way in Intention:
            problem = build_planning_scenario(real, intention=way)
            for weight, place in zip(contact_weights(problem), real.location, strict=True):
                wholes[number] += weight
                parts[number] += weight * (boxes.location == place).all(axis=1).any()
    assert found.recall.value == pytest.approx(parts.sum() / wholes.sum())
    shares = []
    for draw in draw_resamples(12, 300, 4):
        frames = np.repeat(np.arange(12), draw)
        shares.append(parts[frames].sum() / wholes[frames].sum())
    np.testing.assert_allclose(found.recall.interval, np.quantile(shares, [0.025, 0.975]))
    assert safety_weighted_recall(truth, seen).recall.interval is None


@pytest.mark.parametrize("road_type", RoadType)
@pytest.mark.parametrize("intention", Intention)
def test_far_objects_are_left_out_of_the_sum_and_weigh_nothing(
    road_type: RoadType, intention: Intention
) -> None:
    """The weights are those of all objects at once, however far they are."""
    random = np.random.default_rng(7)
    poses = np.column_stack(
        [random.uniform(-20, 60, 300), random.uniform(-20, 20, 300), random.uniform(-3, 3, 300)]
    )
    everything = cars(*map(tuple, poses))
    expected = contact_weights(
        build_planning_scenario(everything, road_type=road_type, intention=intention)
    )
    found = time_to_contact(everything, intention, road_type)
    np.testing.assert_array_equal(found, expected)
    assert 0 < (found > 0).sum() < 100


def test_frames_belong_together() -> None:
    with pytest.raises(ValueError, match="argument 2 is shorter"):
        safety_weighted_recall([cars(LATER)], [])


def test_of_a_single_frame_there_is_no_interval() -> None:
    frames = [cars(LATER)]
    assert safety_weighted_recall(frames, frames, resamples=10).recall.interval is None


def test_as_json() -> None:
    frames = [cars(LATER)] * 2
    found = safety_weighted_recall(frames, frames, resamples=10).to_json()
    assert found == {
        "recall": 1.0, "recall_interval": [1.0, 1.0], "frames": 2, "weighed": 2, "threshold": 0.3,
        "by_intention": {"left": None, "straight": 1.0, "right": None},
    }  # fmt: skip


def test_weights_may_be_ones_own() -> None:
    """Such as those of a planner: here a car beside must not be missed on the way to the left."""
    beside, far = (13.0, 3.5, 0.0), (40.0, 3.5, 0.0)

    def must_not_be_missed(real: Boxes3D, intention: Intention) -> Floats:
        near = real.poses[:, 0] < 20.0
        return near.astype(float) if intention == Intention.LEFT else np.zeros(len(real))

    truth = [cars(beside, far)] * 2
    found = safety_weighted_recall(truth, [cars(beside), cars(far)], weigh=must_not_be_missed)
    assert found.recall.value == 0.5
    assert found.by_intention == {"left": 0.5, "straight": None, "right": None}
    assert found.weighed == 2
