import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.shapes import box, ellipsoid

RED, BLUE = Material(tint=(1.0, 0.0, 0.0)), Material(tint=(0.0, 0.0, 1.0))
places = st.floats(-50.0, 50.0)
sizes = st.floats(0.1, 20.0)


def volume(mesh: Mesh) -> float:
    """Signed: positive if the faces of a closed mesh turn counter-clockwise seen from outside."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def facing(mesh: Mesh) -> np.ndarray:
    """Cosine between each corner's normal and that of its face, shape (F, 3)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return (mesh.normals[mesh.faces] * normal[:, None]).sum(-1)


@given(places, places, places, st.floats(-4.0, 4.0))
def test_placing_turns_to_the_left_and_moves(x: float, y: float, z: float, yaw: float) -> None:
    mesh = box(4.0, 2.0, 1.0)
    placed = mesh.placed(x, y, z, yaw)
    flat = (mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]) * np.exp(1j * yaw) + complex(x, y)
    np.testing.assert_allclose(placed.vertices[:, 0], flat.real, atol=2e-5)
    np.testing.assert_allclose(placed.vertices[:, 1], flat.imag, atol=2e-5)
    np.testing.assert_allclose(placed.vertices[:, 2], mesh.vertices[:, 2] + z, atol=1e-5)
    np.testing.assert_allclose(facing(placed), 1.0, atol=1e-4)


@given(sizes, sizes, sizes)
def test_scaling_multiplies_the_volume_and_keeps_normals_upright(
    x: float, y: float, z: float
) -> None:
    tilted = box(1.0, 1.0, 1.0).turned([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    scaled = tilted.scaled(x, y, z)
    assert volume(scaled) == pytest.approx(x * y * z, rel=1e-4)
    np.testing.assert_allclose(facing(scaled), 1.0, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(scaled.normals, axis=1), 1.0, atol=1e-5)


def test_a_mirrored_mesh_is_not_inside_out() -> None:
    mesh = merge([box(4.0, 2.0, 1.0).placed(0, 5, 0), ellipsoid((1, 2, 3), (1, 2, 0.5))])
    mirrored = mesh.mirrored()
    assert volume(mirrored) == pytest.approx(volume(mesh), rel=1e-5)
    np.testing.assert_array_equal(mirrored.vertices[:, 1], -mesh.vertices[:, 1])
    np.testing.assert_allclose(facing(mirrored)[:, ::-1], facing(mesh), atol=1e-6)


@given(sizes, sizes, sizes, places, places)
def test_a_fitted_mesh_fills_its_box(
    length: float, width: float, height: float, x: float, y: float
) -> None:
    mesh = ellipsoid((x, y, 3.0), (1.0, 2.0, 0.5)).fitted(length, width, height)
    low, high = mesh.bounds
    np.testing.assert_allclose(low, [-length / 2, -width / 2, 0.0], rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(high, [length / 2, width / 2, height], rtol=1e-4, atol=1e-5)


def test_merging_keeps_faces_with_their_materials_and_unites_equal_ones() -> None:
    """A box of the same red as an older one, by value and not by identity."""
    two_kinds = box(1.0, 1.0, 1.0, RED, top=BLUE).placed(5.0, 0.0)
    same_red = box(1.0, 1.0, 1.0, Material(tint=(1.0, 0.0, 0.0))).placed(-5.0, 0.0)
    mesh = merge([box(2.0, 2.0, 2.0, BLUE), two_kinds, same_red])
    assert set(mesh.materials) == {RED, BLUE}
    assert len(mesh.materials) == 2
    assert volume(mesh) == pytest.approx(8 + 1 + 1)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    level = np.ptp(mesh.vertices[mesh.faces][..., 2], axis=1) == 0
    blue = np.array([mesh.materials[i] == BLUE for i in mesh.material])
    np.testing.assert_array_equal(
        blue, (np.abs(middle[:, 0]) < 2.0) | ((middle[:, 0] > 2.0) & level)
    )


def test_merging_marks_what_has_no_overlay() -> None:
    plain, painted = box(1.0, 1.0, 1.0), box(1.0, 1.0, 1.0)
    painted = Mesh(
        painted.vertices, painted.normals, painted.uv, painted.faces, painted.material,
        painted.materials, np.ones((len(painted.vertices), 2), np.float32),
    )  # fmt: skip
    assert merge([plain, plain]).overlay_uv is None
    overlay = merge([plain, painted]).overlay_uv
    assert overlay is not None
    assert np.isnan(overlay[: len(plain.vertices)]).all()
    assert (overlay[len(plain.vertices) :] == 1).all()


def test_exchanging_a_material_leaves_the_others() -> None:
    mesh = merge([box(1.0, 1.0, 1.0, RED), box(2.0, 1.0, 1.0, BLUE)])
    white = Material()
    assert mesh.with_material(white, 1).materials == (RED, white)
    assert mesh.materials == (RED, BLUE)
