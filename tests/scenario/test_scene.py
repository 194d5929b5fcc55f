"""Scenes: what is real, what is believed, and which of it moves."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from avsec_gym.attacks.object_injection import inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import ego_to_camera
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene


def boxes(poses: list[list[float]], moving: list[bool] | None, **fields: object) -> Boxes3D:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    columns = {
        "dimensions": np.tile([1.5, 1.6, 4.0], (count, 1)),
        "score": np.ones(count),
        "category": np.full(count, "Car"),
        "moving": None if moving is None else np.array(moving, bool),
    }
    return Boxes3D(location, rotation_y=rotation_y, **(columns | fields))  # type: ignore[arg-type]


TWO = boxes([[20, 0, 0], [30, 3.5, np.pi]], [True, False])


@pytest.mark.parametrize(
    ("road_type", "low", "high"), [(RoadType.STREET, 6, 8), (RoadType.HIGHWAY, 11, 13)]
)
def test_speeds_lie_in_the_road_types_range(road_type: RoadType, low: int, high: int) -> None:
    many = boxes([[10 * i, 0, 0] for i in range(1000)], [i % 2 == 0 for i in range(1000)])
    speeds = Scene("a", many, road_type, seed=3, number=4).speeds
    assert (speeds[1::2] == 0).all()
    movers = speeds[::2]
    assert low <= movers.min() < low + 0.05
    assert high - 0.05 < movers.max() <= high
    assert abs(movers.mean() - (low + high) / 2) < 0.1


def test_speeds_belong_to_the_object_the_scene_and_the_seed() -> None:
    speeds = Scene("a", boxes([[20, 0, 0]] * 3, [True] * 3), number=7).speeds
    assert len(set(speeds)) == 3
    # Whether the first moves changes nothing for the others.
    other = Scene("a", boxes([[20, 0, 0]] * 3, [False, True, True]), number=7).speeds
    np.testing.assert_array_equal(other, [0.0, *speeds[1:]])
    assert Scene("a", TWO, number=8).speeds[0] != speeds[0]
    assert Scene("a", TWO, number=7, seed=1).speeds[0] != speeds[0]
    assert Scene("b", TWO, number=7).speeds[0] == speeds[0]


def test_another_process_draws_the_same_speeds() -> None:
    program = (
        "import numpy as np; from avsec_gym.scenario.builder import draw_speeds;"
        "print([float(v).hex() for v in draw_speeds(np.ones(5, bool), 'highway', 2, 107)])"
    )
    output = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout
    many = boxes([[20, 0, 0]] * 5, [True] * 5)
    here = Scene("a", many, RoadType.HIGHWAY, seed=2, number=107).speeds
    assert output.strip() == str([float(v).hex() for v in here])


def test_without_flags_everything_stands() -> None:
    scene = Scene("a", boxes([[20, 0, 0]], None))
    assert (scene.speeds == 0).all()
    assert scene.truth().static.all()


def test_start_speeds() -> None:
    assert Scene("a", TWO).start_speed == 6.0
    assert Scene("a", TWO, RoadType.HIGHWAY).start_speed == 11.0
    drawn = [Scene("a", TWO, number=i, draw_start_speed=True).start_speed for i in range(300)]
    assert 22 / 3.6 <= min(drawn) < 23 / 3.6
    assert 28 / 3.6 < max(drawn) <= 29 / 3.6
    again = Scene("a", TWO, number=5, draw_start_speed=True)
    assert again.start_speed == drawn[5]
    assert again.problem(Intention.LEFT).start.velocity == drawn[5]


def test_the_truth_moves_along_its_headings() -> None:
    scene = Scene("a", boxes([[20, 0, 0], [30, 3.5, np.pi]], [True, True]))
    truth = scene.truth()
    one, two = truth.polygons(10)
    assert one.centroid.x == pytest.approx(20 + scene.speeds[0])
    assert two.centroid.x == pytest.approx(30 - scene.speeds[1])
    assert (one.centroid.y, two.centroid.y) == (pytest.approx(0), pytest.approx(3.5))


def test_only_vehicles_become_obstacles() -> None:
    kinds = ["Car", "Van", "Truck", "Misc", "Pedestrian", "Cyclist", "Tram", "Person_sitting"]
    scene = Scene("a", boxes([[20, i, 0] for i in range(8)], None, category=np.array(kinds)))
    assert len(scene.truth()) == 4
    assert len(scene.problem(Intention.LEFT).obstacles) == 4


def test_the_planner_is_told_of_motion_only_if_asked() -> None:
    scene = Scene("a", TWO)
    assert scene.problem(Intention.LEFT).obstacles.static.tolist() == [False, True]
    static = scene.problem(Intention.LEFT, motion=Motion.STATIC)
    assert static.obstacles.static.all()
    # Whatever is believed, the truth moves.
    assert scene.truth().static.tolist() == [False, True]


def test_a_detected_object_moves_like_the_one_that_it_overlaps_most() -> None:
    real = boxes([[20, 0, 0], [23, 0, 0], [40, 0, 0]], [True, True, False])
    scene = Scene("a", real)
    detected = boxes([[22.5, 0.1, 0.1], [20.1, 0, 0], [40, 0.2, 0], [60, 0, 0]], None)
    first, second, _ = scene.speeds
    assert scene.speeds_of(detected).tolist() == [second, first, 0.0, 0.0]
    problem = scene.problem(Intention.STRAIGHT, detected, Motion.TRUTH)
    assert problem.obstacles.static.tolist() == [False, False, True, True]
    # It goes along its own, detected heading.
    away = problem.obstacles.polygons(10)[0].centroid
    assert (away.x, away.y) == (
        pytest.approx(22.5 + second * np.cos(0.1)),
        pytest.approx(0.1 + second * np.sin(0.1)),
    )


def test_a_box_that_faces_the_wrong_way_still_moves_the_right_way() -> None:
    """Detectors know headings up to half a turn."""
    scene = Scene("a", boxes([[20, 0, 0]], [True]))
    problem = scene.problem(Intention.STRAIGHT, boxes([[20, 0, np.pi]], None), Motion.TRUTH)
    moved = problem.obstacles.polygons(10)[0].centroid.x - 20
    assert moved == pytest.approx(scene.speeds[0])


def test_the_best_overlap_is_one_of_area_not_of_distance() -> None:
    """A long truck contains the small box whose centre lies nearer to another one's."""
    sizes = np.array([[3.0, 2.5, 16.0], [1.5, 0.4, 0.4]])
    real = boxes([[20, 0, 0], [25, 1.6, 0]], [True, False], dimensions=sizes)
    detected = boxes([[25, 0.6, 0]], None)
    assert Scene("a", real).speeds_of(detected)[0] > 0


def test_ghosts_stand_wherever_they_are() -> None:
    """A ghost on top of a moving car does not take over its speed."""
    scene = Scene("a", TWO)
    attacked = inject_ghosts(scene.boxes, np.array([[20.5, 0.0, 0.0]]))
    assert scene.speeds_of(attacked).tolist() == [scene.speeds[0], 0.0, 0.0]


def test_nothing_detected_and_nothing_there() -> None:
    empty = Scene("a", Boxes3D.empty())
    assert empty.speeds_of(TWO).tolist() == [0.0, 0.0]
    assert Scene("a", TWO).speeds_of(Boxes3D.empty()).shape == (0,)
    assert len(empty.truth()) == 0


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="0 or more"):
        Scene("a", TWO, seed=-1)
