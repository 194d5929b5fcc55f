"""Surfaces: heights of things whose shape is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh, highest_in_cells
from avsec_gym.validation.connected.surfaces.distance import distances_of_all, surface_distance
from avsec_gym.validation.connected.surfaces.grid import surface_grid
from avsec_gym.validation.connected.surfaces.mesh import SurfaceMesh


def _scattered(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-3.0, 3.0, (count, 2))


@settings(deadline=None)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2.0, 2.0))
def test_the_surface_of_points_of_a_plane_is_that_plane(a: float, b: float, c: float) -> None:
    places = _scattered(400)
    points = np.c_[places, places @ [a, b] + c]
    grid = surface_grid(delaunay_mesh(points), 4.0, 2.0)
    x, y = np.meshgrid(np.arange(40) / 10 - 1.95, np.arange(20) / 10 - 0.95, indexing="ij")
    assert grid == pytest.approx(a * x + b * y + c, abs=1e-9)


def test_the_surface_of_a_box_on_the_ground_is_its_roof_and_the_ground() -> None:
    side = np.arange(-3, 3.01, 0.05)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    on_roof = (np.abs(x) <= 1.0) & (np.abs(y) <= 0.5)
    roof = np.c_[x, y, np.where(on_roof, 1.5, 0.0)]
    edge = np.c_[np.full(20, 1.0), np.zeros(20), np.linspace(0, 1.5, 20)]
    grid = surface_grid(delaunay_mesh(np.r_[roof, edge]), 4.0, 2.0)
    # Cells whose neighbourhood lies on one level have that level.
    assert grid[12:28, 7:13] == pytest.approx(1.5)
    assert grid[:8] == pytest.approx(0.0)
    assert grid[32:] == pytest.approx(0.0)
    # The area above half its height is that of the box, but for the width of a cell at its edge.
    assert (grid > 0.75).sum() * 0.01 == pytest.approx(2.0, abs=0.35)


def test_of_surfaces_above_each_other_the_highest_counts() -> None:
    square = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    vertices = np.r_[np.c_[square, np.full(4, 0.2)], np.c_[square, np.full(4, 1.2)]]
    two = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = SurfaceMesh(vertices, np.r_[two + 4, two])
    assert surface_grid(mesh, 2.0, 2.0) == pytest.approx(1.2)
    assert np.isnan(surface_grid(mesh, 3.0, 2.0)).sum() == 10 * 20


def test_a_grid_is_that_of_brute_force() -> None:
    random = np.random.default_rng(3)
    vertices = random.uniform(-1.2, 1.2, (9, 3))
    triangles = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    grid = surface_grid(SurfaceMesh(vertices, triangles), 2.0, 1.0)
    for i, x in enumerate(np.arange(20) / 10 - 0.95):
        for j, y in enumerate(np.arange(10) / 10 - 0.45):
            heights = []
            for corners in vertices[triangles]:
                shares = np.linalg.solve(np.c_[corners[:, :2], np.ones(3)].T, [x, y, 1.0])
                if (shares >= 0).all():
                    heights.append(shares @ corners[:, 2])
            assert grid[i, j] == pytest.approx(max(heights, default=np.nan), nan_ok=True)


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.eye(3)[:2], np.c_[np.arange(9.0), np.arange(9.0), np.ones(9)]]
)
def test_what_spans_no_triangle_has_no_surface(points: np.ndarray) -> None:
    assert np.isnan(surface_grid(delaunay_mesh(points), 1.0, 1.0)).all()


def test_long_edges_span_what_was_not_seen() -> None:
    places = _scattered(500)
    places = places[np.abs(places[:, 0]) > 1.0]
    points = np.c_[places, np.zeros(len(places))]
    whole = surface_grid(delaunay_mesh(points), 4.0, 2.0)
    assert not np.isnan(whole).any()
    cut = surface_grid(delaunay_mesh(points, longest_edge=1.0), 4.0, 2.0)
    assert np.isnan(cut[12:28]).all()
    assert not np.isnan(cut[:6, 2:-2]).any()


def test_the_highest_point_of_a_cell_stays() -> None:
    points = np.array([[0.01, 0.02, 3.0], [0.05, 0.09, 1.0], [-0.01, 0.05, 2.0]])
    assert sorted(highest_in_cells(points, 0.1)[:, 2]) == [2.0, 3.0]


def test_equation_4_1_by_hand() -> None:
    first = np.array([[0.0, 0.1, 1.5], [np.nan, 0.0, 0.0]])
    second = np.array([[0.03, 0.0, 0.0], [1.0, np.nan, 0.5]])
    # Of the differences .03, .1, 1.5 and .5, three exceed .04.
    assert surface_distance(first, second, 0.04) == pytest.approx((0.1 + 1.5 + 0.5) / 3)
    assert surface_distance(first, second, 2.0) == 0.0
    assert np.isnan(surface_distance(first, np.full((2, 3), np.nan)))
    with pytest.raises(DataError):
        surface_distance(first, np.zeros((3, 2)))


def test_distances_of_all_leave_out_who_sent_nothing() -> None:
    distances = distances_of_all([np.zeros((2, 2)), None, np.ones((2, 2))])
    assert distances[0, 2] == distances[2, 0] == 1.0
    assert np.isnan(distances[1]).all()
    assert np.isnan(np.diag(distances)).all()
