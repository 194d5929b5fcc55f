import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.shapes import (
    box,
    ellipsoid,
    grid,
    hard_edges,
    polygon,
    prism,
    revolve,
    scattered,
    tube,
)

RING = 0.5 * 24 * np.sin(2 * np.pi / 24)
"""Area of a regular polygon of 24 corners and radius 1."""


def volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def facing(mesh: Mesh) -> np.ndarray:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    cosine = (mesh.normals[mesh.faces] * (normal / np.maximum(size, 1e-12))[:, None]).sum(-1)
    return cosine[size[:, 0] > 1e-7]


def open_edges(mesh: Mesh) -> int:
    """Edges without a partner that runs the other way, vertices at one place being one."""
    _, place = np.unique(np.round(mesh.vertices, 3), axis=0, return_inverse=True)
    faces = place.reshape(-1)[mesh.faces]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    forth, count = np.unique(edges, axis=0, return_counts=True)
    back, count_back = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    if len(forth) == len(back) and (forth == back).all() and (count == count_back).all():
        return 0
    return len(forth)


PLAIN = Material()
ANGLE = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
CLOSED = {
    "box": (box(4.0, 2.0, 1.5), 12.0),
    "prism": (prism(ANGLE, 2.0, top=PLAIN), 10.0),
    "tube": (tube([(0, 0, 0), (0, 0, 1), (0, 0, 3)], 0.5, sides=24), 3 * 0.25 * RING),
    "cone": (tube([(0, 0, 0), (2, 0, 0)], [0.6, 0.3], sides=24), RING * 2 / 3 * 0.63),
    "ellipsoid": (ellipsoid((1, 2, 3), (1.0, 2.0, 0.5), rings=40), 4 / 3 * np.pi),
    "revolved": (revolve([(0, 2), (1, 2), (1, 0), (0, 0)]), 2 * RING),
}  # fmt: skip


@pytest.mark.parametrize("name", CLOSED)
def test_closed_shapes_have_their_volume_and_face_outward(name: str) -> None:
    mesh, expected = CLOSED[name]
    assert volume(mesh) == pytest.approx(expected, rel=0.02)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
    assert facing(mesh).min() > -1e-3


@pytest.mark.parametrize("name", ["box", "prism", "revolved"])
def test_closed_shapes_have_no_holes(name: str) -> None:
    assert open_edges(CLOSED[name][0]) == 0
    assert open_edges(polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)])) > 0


@given(st.lists(st.floats(0.3, 3.0), min_size=4, max_size=12))
def test_a_prism_over_any_star_has_its_area_times_its_height(radii: list[float]) -> None:
    angle = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    plan = np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    mesh = prism(plan, 2.5, top=PLAIN, bottom=-0.5)
    assert volume(mesh) == pytest.approx(3.0 * shapely.Polygon(plan).area, rel=1e-3)
    assert facing(mesh).min() > 0.99


def test_a_corner_that_is_none_does_no_harm() -> None:
    """Footprints with a point in the middle of an edge, the first or another one."""
    square = np.array([(-1.0, -1), (0, -1), (1, -1), (1, 1), (-1, 1)])
    for shift in range(5):
        mesh = prism(np.roll(square, shift, axis=0), 1.0, top=PLAIN)
        assert volume(mesh) == pytest.approx(4.0, rel=1e-4)
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)


@pytest.mark.parametrize(
    "path",
    [
        [(0, 0, 0), (0, 0, 3), (0.2, 0, 3.4), (0.6, 0, 3.6), (3, 0, 3.6)],
        [(0, 0, 0), (0, 0, 3), (0, 0.2, 3.4), (0, 0.6, 3.6), (0, 3, 3.6)],
        [(0, 0, 0), (2, 0, 0), (2.3, 0, 0.1), (2.4, 0, 0.4), (2.4, 0, 3)],
    ],
)
def test_a_bent_tube_is_as_thick_all_along(path: list[tuple[float, float, float]]) -> None:
    """An arm that leans over: no way of bending may pinch it."""
    mesh = tube(path, 0.05, sides=24)
    length = np.linalg.norm(np.diff(np.array(path, float), axis=0), axis=1).sum()
    assert volume(mesh) == pytest.approx(length * 0.05**2 * RING, rel=0.06)


def test_textures_keep_their_scale_on_flat_and_round_walls() -> None:
    """An edge is as long on the texture as in space."""
    for mesh in (
        polygon([(0, 0, 0), (3, 4, 0), (3, 4, 2), (0, 0, 2)]),
        prism([(0, 0), (3, 0), (4, 2), (0, 2)], 2.0, top=PLAIN),
        grid(np.stack(np.meshgrid([0.0, 1, 3], [0.0, 2, 5], [1.0], indexing="ij"), -1)[:, :, 0]),
    ):
        corners, spots = mesh.vertices[mesh.faces], mesh.uv[mesh.faces]
        for i, j in ((0, 1), (1, 2), (2, 0)):
            np.testing.assert_allclose(
                np.linalg.norm(spots[:, i] - spots[:, j], axis=1),
                np.linalg.norm(corners[:, i] - corners[:, j], axis=1),
                rtol=1e-4,
            )
    round_wall = tube([(0, 0, 0), (0, 0, 4)], 0.3, sides=48, capped=False)
    assert np.ptp(round_wall.uv[:, 0]) == pytest.approx(2 * np.pi * 0.3, rel=1e-3)
    assert np.ptp(round_wall.uv[:, 1]) == pytest.approx(4.0, rel=1e-3)


def test_a_grid_over_x_and_y_faces_up_and_closes_without_a_seam() -> None:
    x, y = np.meshgrid(np.arange(3.0), np.arange(4.0), indexing="ij")
    plain = grid(np.stack([x, y, 0.2 * x], axis=-1))
    assert facing(plain).min() > 0.999
    assert (plain.normals[:, 2] > 0.9).all()
    pipe = tube([(0, 0, 0), (0, 0, 1)], 1.0, sides=12, capped=False)
    normals = pipe.normals.reshape(2, 13, 3)
    np.testing.assert_allclose(normals[:, 0], normals[:, -1], atol=1e-5)
    np.testing.assert_allclose(
        normals[..., :2], pipe.vertices.reshape(2, 13, 3)[..., :2], atol=1e-5
    )


def test_hard_edges_are_hard_and_smooth_ones_smooth() -> None:
    """A box of shared corners gets flat faces; a fine ball keeps its own normals."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    plain = box(1, 1, 1)
    shared = Mesh(
        corners, np.zeros_like(corners), corners[:, :2], np.array(faces, np.int32),
        np.zeros(12, np.int32), plain.materials,
    )  # fmt: skip
    assert volume(shared) == pytest.approx(1.0)
    np.testing.assert_allclose(facing(hard_edges(shared)), 1.0, atol=1e-5)
    assert facing(hard_edges(shared, angle=2.0)).max() < 0.95
    ball = hard_edges(ellipsoid((0, 0, 0), (1, 1, 1), rings=24))
    outward = ball.vertices / np.linalg.norm(ball.vertices, axis=1, keepdims=True)
    assert (ball.normals * outward).sum(1).min() > 0.99


def test_copies_stand_where_they_are_told() -> None:
    bars = scattered([box(0.1, 0.1, 1.0)], [(0, 0, 0, 0), (2, 1, 0.5, 0.3), (4, 0, 0, 0)])
    low, high = bars.bounds
    np.testing.assert_allclose(low, [-0.05, -0.05, 0.0], atol=1e-6)
    np.testing.assert_allclose(high[[0, 2]], [4.05, 1.5], atol=1e-5)
    assert volume(bars) == pytest.approx(0.03, rel=1e-4)
