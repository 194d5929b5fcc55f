import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import rectangle_polygons
from avsec_gym.road_type import RoadType
from avsec_gym.world.layouts import SceneLayout, generate_layout, generate_layouts, layout_by_id
from avsec_gym.world.layouts.dimensions import CATEGORIES, CategoryMix, draw_dimensions
from avsec_gym.world.layouts.road import LayoutRoad, place_row
from avsec_gym.world.layouts.view import covered_shares, project_boxes, without_overlaps

OBSTACLES = ("Car", "Van", "Truck", "Misc")
COLUMNS = (
    "location", "dimensions", "rotation_y", "box2d", "truncation", "occlusion", "alpha", "moving",
)  # fmt: skip


@pytest.fixture(scope="module")
def layouts() -> list[SceneLayout]:
    return generate_layouts(1500)


def digest(layouts: list[SceneLayout]) -> str:
    code = hashlib.sha256()
    for layout in layouts:
        code.update(layout.id.encode())
        code.update("".join(layout.boxes.category).encode())
        for name in COLUMNS:
            code.update(np.ascontiguousarray(getattr(layout.boxes, name)).tobytes())
    return code.hexdigest()


def test_another_process_makes_the_same_layouts() -> None:
    program = (
        "from tests.world.test_layouts import digest;"
        "from avsec_gym.world.layouts import generate_layouts;"
        "print(digest(generate_layouts(20, seed=7)))"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parents[2],
        ).stdout.strip()
        for _ in range(2)
    }
    assert outputs == {digest(generate_layouts(20, seed=7))}


def test_a_layout_does_not_depend_on_how_many_are_made(layouts: list[SceneLayout]) -> None:
    assert digest(generate_layouts(5)) == digest(layouts[:5])
    assert digest([generate_layout(1234)]) == digest([layouts[1234]])
    assert digest(generate_layouts(5, seed=1)) != digest(layouts[:5])


def test_ids_are_unique_and_lead_back_to_the_layout(layouts: list[SceneLayout]) -> None:
    assert len({layout.id for layout in layouts}) == len(layouts)
    for layout in [*layouts[:20], *generate_layouts(5, seed=3, road_type=RoadType.HIGHWAY)]:
        assert layout.id.startswith(f"{layout.road_type.value}-")
        assert digest([layout_by_id(layout.id)]) == digest([layout])


def test_a_road_type_asked_for_is_the_one_drawn_where_they_agree(
    layouts: list[SceneLayout],
) -> None:
    for index, layout in enumerate(layouts[:20]):
        assert digest([generate_layout(index, layout.road_type)]) == digest([layout])
    assert {each.road_type for each in generate_layouts(20, 0, RoadType.HIGHWAY)} == {
        RoadType.HIGHWAY
    }


@pytest.mark.parametrize("wrong", ["street", "street-12", "road-000001", "street-000001-x"])
def test_other_ids_are_refused(wrong: str) -> None:
    with pytest.raises(ConfigurationError, match="ids look like"):
        layout_by_id(wrong)


def test_negative_seeds_and_counts_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="0 or more"):
        generate_layout(-1)
    for count in (-1, 10**12):
        with pytest.raises(ConfigurationError, match=r"count takes .* from 0 to 100,000, got"):
            generate_layouts(count)


def test_nothing_overlaps_and_the_ego_vehicle_stands_free(layouts: list[SceneLayout]) -> None:
    ego = shapely.box(-2.254, -0.805, 2.254, 0.805)
    for layout in layouts:
        boxes = layout.boxes
        shapes = [*rectangle_polygons(boxes.poses, boxes.length, boxes.width), ego]
        tree = shapely.STRtree(shapes)
        first, second = tree.query(shapes, predicate="intersects")
        assert (first == second).all(), layout.id


def test_all_is_in_view_and_every_column_is_filled(layouts: list[SceneLayout]) -> None:
    for layout in layouts:
        boxes = layout.boxes
        assert all(getattr(boxes, name) is not None for name in COLUMNS)
        assert (boxes.box2d[:, :2] >= 0).all()
        assert (boxes.box2d[:, 2:] <= [1241, 374]).all()
        assert (boxes.box2d[:, 2:] - boxes.box2d[:, :2] > 5).all()
        assert ((boxes.truncation >= 0) & (boxes.truncation < 1)).all()
        assert np.isin(boxes.occlusion, [0, 1, 2, 3]).all()
        assert (boxes.location[:, 2] < 90).all()


def test_all_stand_on_one_ground_plane_under_the_camera(layouts: list[SceneLayout]) -> None:
    for layout in layouts:
        x, y, z = layout.boxes.location.T
        height, roll, pitch = layout.ground
        assert 1.4 < height < 1.9
        np.testing.assert_allclose(y, height + roll * x + pitch * z, atol=1e-9)


def test_what_stands_and_what_moves(layouts: list[SceneLayout]) -> None:
    """Parked rows never move; oncoming vehicles drive against the road, the others along it."""
    moving_headings = []
    for layout in layouts:
        boxes = layout.boxes
        vehicle = np.isin(boxes.category, OBSTACLES)
        x, y, heading = boxes.poses[vehicle & boxes.moving].T
        along = layout.road.heading + layout.road.curvature * x
        moving_headings.append(np.stack([y, np.cos(heading - along)], axis=-1))
    left, direction = np.concatenate(moving_headings).T
    assert (np.abs(direction) > 0.8).all()
    assert 0.2 < (direction < 0).mean() < 0.7
    assert np.median(left[direction < 0]) > 5 > np.median(left[direction > 0])
    with_movers = [
        (layout.boxes.moving & np.isin(layout.boxes.category, OBSTACLES)).any()
        for layout in layouts
        if layout.road_type is RoadType.STREET
    ]
    assert 0.10 < np.mean(with_movers) < 0.21  # 69 of 432 labelled scenarios are dynamic


def test_statistics_are_near_those_of_kitti(layouts: list[SceneLayout]) -> None:
    """Loose bounds around KITTI's means, to detect a slip; docs/layouts.md has the distances."""
    category = np.concatenate([layout.boxes.category for layout in layouts])
    location = np.concatenate([layout.boxes.location for layout in layouts])
    dimensions = np.concatenate([layout.boxes.dimensions for layout in layouts])
    truncation = np.concatenate([layout.boxes.truncation for layout in layouts])
    occlusion = np.concatenate([layout.boxes.occlusion for layout in layouts])
    yaw = np.concatenate([layout.boxes.rotation_y for layout in layouts])
    cars = category == "Car"
    assert 3.2 < cars.sum() / len(layouts) < 4.4
    assert 0.6 < np.isin(category, ["Pedestrian", "Cyclist"]).sum() / len(layouts) < 1.1
    np.testing.assert_allclose(dimensions[cars].mean(0), [1.53, 1.63, 3.88], atol=0.06)
    assert 25 < location[cars, 2].mean() < 32
    assert -4.5 < location[cars, 0].mean() < -1
    assert 0.09 < (truncation[cars] > 0).mean() < 0.19
    assert 0.38 < (occlusion[cars] == 0).mean() < 0.56
    assert 0.68 < (np.abs(np.sin(yaw[cars])) > 0.85).mean() < 0.88
    highway = [layout.road_type is RoadType.HIGHWAY for layout in layouts]
    assert abs(np.mean(highway) - 168 / 600) < 0.04


def test_a_full_row_stands_in_line_with_its_gap() -> None:
    row = place_row(
        np.random.default_rng(0), CategoryMix(Car=1), start=0.0, end=60.0, left=-3.0,
        gap=0.5, fullness=1.0, lull=30.0, jitter=0.0,
    )  # fmt: skip
    free = np.diff(row.along) - 0.5 * (row.dimensions[1:, 2] + row.dimensions[:-1, 2])
    assert len(row.along) > 8
    assert (free >= 0.5 - 1e-9).all()
    assert free.max() < 6
    assert (row.left == -3.0).all()
    assert not row.moving.any()


def test_a_curved_road_is_an_arc() -> None:
    road = LayoutRoad(heading=0.0, curvature=0.01, lane_offsets=(0.0,))
    quarter = road.poses(np.array([50 * np.pi]), np.array([0.0]), np.array([0.0]))
    np.testing.assert_allclose(quarter, [[100.0, 100.0, np.pi / 2]], atol=1e-9)
    centre = road.poses(np.array([0.0, 77.0]), np.array([100.0, 100.0]), np.zeros(2))
    np.testing.assert_allclose(centre[:, :2], [[0, 100], [0, 100]], atol=1e-9)


def test_projection_of_a_box_ahead_and_of_one_cut_by_the_border() -> None:
    size = np.array([[1.5, 2.0, 4.0]])
    ahead = project_boxes(np.array([[0.0, 1.65, 12.0]]), size, np.array([-np.pi / 2]))
    half = 721.5377 / 10.0
    np.testing.assert_allclose(ahead.box2d[0, [0, 2]], [609.5593 - half, 609.5593 + half])
    assert ahead.truncation[0] == 0
    behind = project_boxes(np.array([[0.0, 1.65, -12.0]]), size, np.array([0.0]))
    assert behind.truncation[0] == 1
    beside = project_boxes(np.array([[-2.5, 1.65, 2.0]]), size, np.array([-np.pi / 2]))
    assert 0.5 < beside.truncation[0] < 1


def test_cover_and_overlap_of_simple_shapes() -> None:
    boxes = np.array([[0.0, 0, 10, 10], [5, 0, 15, 10], [100, 0, 110, 10]])
    np.testing.assert_allclose(covered_shares(boxes), [0, 0.5, 0])
    poses = np.array([[0.0, 0, 0], [3.0, 0, 0], [6.0, 0, np.pi / 4], [20.0, 0, 0]])
    stays = without_overlaps(poses, np.full(4, 4.0), np.full(4, 2.0))
    assert stays.tolist() == [True, False, True, True]


def test_sizes_stay_within_what_kitti_knows() -> None:
    rng = np.random.default_rng(0)
    codes = np.repeat(np.arange(len(CATEGORIES)), 2000)
    sizes = draw_dimensions(rng, codes)
    assert (sizes > 0.25).all()
    medians = np.array([np.median(sizes[codes == code, 2]) for code in range(len(CATEGORIES))])
    np.testing.assert_allclose(medians, [3.88, 4.98, 10.8, 2.5, 0.86, 1.76], rtol=0.1)
