"""The mesh in the manner of Point2Mesh: its topology, its prior, and a box that it finds."""

import numpy as np
import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.surfaces.deformed_mesh import DeformedMesh
from avsec_gym.validation.connected.surfaces.grid import surface_grid
from avsec_gym.validation.connected.surfaces.self_prior import SelfPrior
from avsec_gym.validation.connected.surfaces.triangle_topology import (
    around_points,
    edges_of,
    sphere,
    subdivided,
)


@pytest.mark.parametrize("subdivisions", [0, 1, 3])
def test_a_sphere_is_closed_and_round(subdivisions: int) -> None:
    vertices, triangles = sphere(subdivisions)
    edges = edges_of(triangles)
    assert len(triangles) == 20 * 4**subdivisions
    # Euler's formula of closed surfaces without holes.
    assert len(vertices) - len(edges.ends) + len(triangles) == 2
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(1.0)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    assert (outward > 0).all()


def test_an_edge_has_the_other_edges_of_its_two_triangles() -> None:
    _, triangles = sphere(1)
    edges = edges_of(triangles)
    for edge in range(len(edges.ends)):
        both = [each for each in triangles if set(edges.ends[edge]) <= set(each)]
        assert len(both) == 2
        for each, two in zip(both, edges.neighbours[edge].reshape(2, 2), strict=True):
            around = set(map(tuple, edges.ends[[edge, *two]]))
            assert len(around) == 3
            assert set().union(*around) == set(each)


def test_a_divided_mesh_has_the_same_surface() -> None:
    vertices, triangles = sphere(0)
    finer, divided = subdivided(vertices, triangles)

    def area(places: np.ndarray, corners: np.ndarray) -> float:
        a, b, c = (places[corners[:, k]] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    assert area(finer, divided) == pytest.approx(area(vertices, triangles))


def test_the_first_mesh_lies_on_the_convex_hull() -> None:
    corners = np.array([[x, y, z] for x in (0, 4) for y in (-1, 1) for z in (0, 1.5)], float)
    vertices, _ = around_points(corners, 2)
    faces = np.abs(np.c_[vertices, 4 - vertices[:, 0], 1 - vertices[:, 1], 1 + vertices[:, 1],
                         1.5 - vertices[:, 2]])[:, [0, 2, 3, 4, 5, 6]]  # fmt: skip
    assert faces.min(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_the_prior_does_not_depend_on_which_triangle_of_an_edge_is_first() -> None:
    vertices, triangles = sphere(1)
    edges = edges_of(triangles)
    torch.manual_seed(0)
    prior = SelfPrior(edges, len(vertices))
    said = prior()
    prior.neighbours = prior.neighbours[:, [2, 3, 0, 1]]
    assert torch.allclose(prior(), said, atol=1e-6)
    assert said.shape == (len(vertices), 3)


def _box_on_ground(count: int = 2500) -> np.ndarray:
    """Points on the roof and sides of a box of 4 x 1.8 x 1.5 m, and on the ground about it."""
    random = np.random.default_rng(0)
    half = np.array([2.0, 0.9, 0.75])
    box = random.uniform(-half, half, (count, 3))
    side = random.integers(0, 5, count)
    for number, (axis, sign) in enumerate([(0, 1), (0, -1), (1, 1), (1, -1), (2, 1)]):
        box[side == number, axis] = sign * half[axis]
    ground = random.uniform([-2.5, -1.4, 0], [2.5, 1.4, 1e-3], (800, 3))
    is_free = (np.abs(ground[:, 0]) > 2) | (np.abs(ground[:, 1]) > 0.9)
    return np.concatenate([box + np.array([0, 0, 0.75]), ground[is_free]])


def test_the_surface_of_a_box_is_found_and_better_than_where_it_began() -> None:
    points = _box_on_ground()
    roof, ends = (slice(8, -8), slice(8, -8)), (slice(None), slice(4, -4))
    grids = [surface_grid(DeformedMesh(iterations=n)(points), 5.0, 2.8) for n in (1, 60)]
    # The hull slopes from the roof to the ground's edge; the deformed surface falls at the box's.
    beside = [np.nanmean(np.abs(grid[ends][[1, 2, -3, -2]])) for grid in grids]
    assert beside[1] < 0.6 * beside[0]
    assert np.nanmedian(np.abs(grids[1][roof] - 1.5)) < 0.06


def test_the_same_points_have_the_same_mesh_and_no_randomness_is_used_up() -> None:
    points = _box_on_ground(300)
    torch.manual_seed(5)
    before = torch.random.get_rng_state()
    first, second = (DeformedMesh(iterations=3)(points) for _ in range(2))
    assert (first.vertices == second.vertices).all()
    assert (torch.random.get_rng_state() == before).all()


def test_flat_or_few_points_have_no_such_mesh() -> None:
    flat = np.c_[np.random.default_rng(0).uniform(-1, 1, (50, 2)), np.zeros(50)]
    assert len(DeformedMesh()(flat).triangles) == 0
    assert len(DeformedMesh()(flat[:5]).triangles) == 0
    for wrong in ({"levels": ()}, {"levels": (3, 2)}, {"iterations": 0}):
        with pytest.raises(ConfigurationError):
            DeformedMesh(**wrong)  # type: ignore[arg-type]
