"""Ceilings against brute force: every sequence of primitives, in plain Python and shapely."""

from __future__ import annotations

import json
import math
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import shapely

from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.patch_ghosts import FULL_CAR, ghost_box
from avsec_gym.attacks.patch_placement import focal_times_baseline
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.geometry import ego_to_camera
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from studies.chapter5 import ghost_ceiling
from studies.chapter5.ghost_ceiling import (
    BINS,
    DISTANCES,
    WIDTHS,
    GhostCeilings,
    ghost_ceilings,
    ghost_places,
)
from studies.chapter5.ghost_ceiling_page import ceiling_page, main

CALIBRATION = kitti_rig().calibration
AXLE = 1.4227170936
"""Metres from the rear axle to the car's centre."""
SMALL = 1e-6


def scene(number: int, *poses: tuple[float, float]) -> Scene:
    location, rotation_y = ego_to_camera(np.array([[x, y, 0.0] for x, y in poses]), 1.65)
    count = len(poses)
    boxes = Boxes3D(
        location, np.tile(FULL_CAR, (count, 1)), rotation_y, np.ones(count), np.full(count, "Car")
    )
    return Scene(f"{number:06d}", boxes)


SCENES = [
    scene(1, (60.0, 0.0)),
    scene(2, (15.5, 3.4)),
    scene(3, (14.0, -3.0), (9.0, 4.5)),
    scene(4, (24.0, 0.5)),
    scene(5, (11.0, 2.6)),
]
PRIMITIVES = generate_primitives((6.0,))


@pytest.fixture(scope="module")
def found() -> GhostCeilings:
    planner = MotionPrimitivePlanner(primitives=PRIMITIVES)
    return ghost_ceilings(SCENES, seed=5, planner=planner)


def reaches(scene: Scene, intention: Intention, ghosts: list[Boxes3D]) -> bool:
    """Whether any sequence of primitives leads to the goal past everything that is believed."""
    believed = [*ghosts, *(scene.boxes[[row]] for row in range(len(scene.boxes)))]
    occupied = shapely.union_all([from_above(box) for box in believed])
    shapely.prepare(occupied)
    [goal] = scene.problem(intention).goals
    assert goal.region is not None
    assert goal.heading is not None
    assert goal.velocity is not None
    (right, left), slowest = goal.heading, goal.velocity[0]
    region = shapely.union_all([shape.polygon() for shape in goal.region])

    def drive(x: float, y: float, heading: float, step: int, followers: list[int]) -> bool:
        for p in followers:
            for j in range(1, int(PRIMITIVES.steps[p]) + 1):
                px, py, velocity, turn, _ = PRIMITIVES.states[p, j]
                x1 = x + math.cos(heading) * px - math.sin(heading) * py
                y1 = y + math.sin(heading) * px + math.cos(heading) * py
                centre = (
                    x1 + AXLE * math.cos(heading + turn),
                    y1 + AXLE * math.sin(heading + turn),
                )
                if step + j > goal.steps[1] or not free(*centre, heading + turn):
                    break
                arrived = goal.steps[0] <= step + j and region.contains(shapely.Point(centre))
                if arrived and right <= heading + turn <= left and slowest <= velocity:
                    return True
            else:
                follows = [*np.nonzero(PRIMITIVES.follows[p])[0]]
                if drive(x1, y1, heading + turn, step + int(PRIMITIVES.steps[p]), follows):
                    return True
        return False

    def free(x: float, y: float, heading: float) -> bool:
        car = shapely.box(-2.254, -0.805, 2.254, 0.805)
        car = shapely.affinity.rotate(car, heading, origin=(0, 0), use_radians=True)
        car = shapely.affinity.translate(car, x, y)
        return not car.intersects(occupied) or car.intersection(occupied).area <= SMALL

    return drive(-AXLE, 0.0, 0.0, 0, [*PRIMITIVES.starting_at(6.0)])


def from_above(box: Boxes3D) -> shapely.Polygon:
    (x, y, heading), length, width = box.poses[0], box.length[0], box.width[0]
    assert heading == pytest.approx(0, abs=1e-9)
    return shapely.box(x - length / 2, y - width / 2, x + length / 2, y + width / 2)


@pytest.mark.parametrize("intention", Intention)
@pytest.mark.parametrize("distances", [BINS[0], pytest.param((5.0, 12.0), marks=pytest.mark.slow)])
def test_the_ceiling_is_that_of_brute_force(
    found: GhostCeilings, intention: Intention, distances: tuple[float, float]
) -> None:
    for count, width in ((1, FULL_CAR[1]), (2, FULL_CAR[1]), (2, None)):
        safe = 0
        for each in SCENES:
            seed = ghost_ceiling._seed(5, each, intention, distances)
            places = islice(ghost_places(intention, distances, seed), count)
            safe += reaches(each, intention, [ghost_box(p, CALIBRATION, width) for p in places])
        (row,) = (
            row
            for row in found.rows
            if (row.intention, row.ghosts, row.width) == (intention, count, width)
            and (row.nearest, row.farthest) == distances
        )
        assert row.rates.safe_driving_rate == safe / len(SCENES)
        (truth,) = (row for row in found.truth if row.intention == intention)
        alone = sum(reaches(each, intention, []) for each in SCENES)
        assert truth.rates.safe_driving_rate == alone / len(SCENES)
        assert row.gain.value == pytest.approx(100 * (safe - alone) / len(SCENES))


def test_the_cases_are_of_both_kinds(found: GhostCeilings) -> None:
    straight = {row.rates.safe_driving_rate for row in found.rows if row.intention == "straight"}
    assert min(straight) < 0.5 < max(straight)


@pytest.mark.parametrize("intention", Intention)
@pytest.mark.parametrize("distances", DISTANCES)
def test_places_are_those_of_a_specific_patch(
    intention: Intention, distances: tuple[float, float]
) -> None:
    places = list(islice(ghost_places(intention, distances, 3), 300))
    depths = np.array([focal_times_baseline(CALIBRATION) / place.disparity for place in places])
    assert distances[0] <= depths.min() < depths.max() <= distances[1]
    middle = (distances[0] + distances[1]) / 2
    # Uniform in metres: the mean of 300 spreads by the range over sqrt(12 * 300).
    spread = (distances[1] - distances[0]) / np.sqrt(12 * 300)
    assert abs(depths.mean() - middle) < 4 * spread
    assert {place.intention(1242) for place in places} == {intention}
    assert all(place.is_inside(375, 1242) for place in places)
    rear = [ghost_box(place, CALIBRATION, 1.0) for place in places]
    ahead = np.array([ghost.poses[0, 0] - ghost.length[0] / 2 for ghost in rear])
    offset = CALIBRATION.projection(LEFT)[2, 3]
    np.testing.assert_allclose(ahead, depths - offset, atol=1e-6)


def test_two_ghosts_are_the_one_and_another_and_sizes_share_places() -> None:
    first, second = islice(ghost_places(Intention.LEFT, BINS[1], [0, 7]), 2)
    assert next(ghost_places(Intention.LEFT, BINS[1], [0, 7])) == first
    assert first != second
    small, full = (ghost_box(first, CALIBRATION, width) for width in (1.0, FULL_CAR[1]))
    assert from_above(full).buffer(1e-9).contains(from_above(small))


def test_the_result_is_read_back_and_its_page_names_every_kind(found: GhostCeilings) -> None:
    text = json.dumps(row_json(found), indent=1)
    again = row_of(GhostCeilings, json.loads(text))
    assert json.dumps(row_json(again), indent=1) == text
    page = ceiling_page(again)
    assert page == ceiling_page(found)
    assert page.count("| two full |") == page.count("| one as seen |") == len(Intention)
    (beside,) = (line for line in page.splitlines() if line.startswith("| straight |"))
    rates = [row.rates.safe_driving_rate for row in found.rows if row.intention == "straight"]
    assert f"| {100 * min(rates):.1f} (" in beside
    assert "| 54.7 |" in beside  # Table 5.4 of the thesis.
    assert len(found.rows) == 2 * len(WIDTHS) * len(DISTANCES) * len(Intention)
    for row in found.rows:
        if (row.ghosts, row.nearest, row.intention) == (2, 16.0, "left"):
            assert f"{100 * row.rates.safe_driving_rate:.1f} (" in page


def test_the_command_writes_result_page_and_picture(tmp_path: Path) -> None:
    (tmp_path / "static_label").mkdir()
    label = "Car 0.00 0 -1.57 600.00 170.00 650.00 210.00 1.50 1.60 4.00 0.00 1.65 20.00 -1.57\n"
    for name in ("000001", "000002"):
        (tmp_path / "static_label" / f"{name}.txt").write_text(label)
    places = {kind: tmp_path / f"found.{kind}" for kind in ("json", "md", "png")}
    options = ["--limit", "1", "--seed", "3", "--scenarios", str(tmp_path)]
    outputs = zip(("--json", "--markdown", "--figure"), places.values(), strict=True)
    assert main([*options, *(str(word) for pair in outputs for word in pair)]) == 0
    result = row_of(GhostCeilings, json.loads(places["json"].read_text()))
    assert (result.scenarios, result.seed) == (1, 3)
    assert places["md"].read_text() == ceiling_page(result)
    assert places["png"].read_bytes().startswith(b"\x89PNG")
    assert main(["--scenarios", str(tmp_path / "nowhere")]) == 1
