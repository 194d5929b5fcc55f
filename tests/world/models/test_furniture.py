"""Street furniture: sizes, orientation, budgets."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np
import pytest

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.furniture import barriers, crossings, fences
from avsec_gym.world.models.furniture.catalogue import FURNITURE
from avsec_gym.world.models.furniture.sweep import along, lengths
from avsec_gym.world.models.furniture.traffic_lights import LIT, standing_light
from avsec_gym.world.models.furniture.traffic_signs import SIGNS, sign_plate, traffic_sign
from avsec_gym.world.textures.library import FAMILIES
from avsec_gym.world.textures.sign_faces import SIGN_FACES, sign_texture

HEIGHTS = {
    "lamp_mast": (5.5, 9.5),
    "lamp_post_top": (4.2, 5.6),
    "lamp_globe": (3.9, 4.9),
    "lamp_lantern": (3.6, 4.5),
    "traffic_light": (3.2, 4.0),
    "delineator": (1.0, 1.1),
    "traffic_cone": (0.7, 0.8),
    "site_barrier": (1.0, 1.4),
    "warning_beacon": (1.2, 1.5),
    "site_fence": (1.9, 2.2),
    "wheelie_bin": (1.0, 1.1),
    "bin_row": (1.0, 1.1),
    "litter_bin": (1.0, 1.2),
    "bench": (0.75, 0.95),
    "bench_block": (0.4, 0.5),
    "post_box": (1.3, 1.5),
    "bicycle_stand": (0.7, 0.9),
    "junction_box": (0.85, 1.45),
    "advertising_pillar": (3.0, 3.6),
    "poster_stand": (2.2, 2.6),
    "pavement_board": (0.9, 1.2),
    "poster_on_pole": (2.4, 2.8),
    "billboard": (3.2, 3.7),
    "bus_shelter": (2.4, 2.7),
    "cafe_table": (0.7, 1.0),
    "parasol": (2.4, 2.8),
    "parasol_closed": (2.4, 2.8),
    "planter": (0.6, 1.6),
    "flower_box": (0.3, 0.6),
    "flag_pole": (6.8, 7.2),
    "telephone_mast": (6.8, 8.2),
    **{f"bollard_{kind}": (0.5, 1.05) for kind in ("iron", "steel", "banded", "stone")},
    **dict.fromkeys(SIGNS, (2.2, 3.8)),
    **{f"sign_{name}": (1.1, 1.3) for name in ("keep_right", "straight_or_right")},
    "sign_town": (2.0, 2.3),
    "sign_direction": (2.0, 2.2),
    "sign_bend_arrows": (1.3, 1.5),
    "sign_exit": (1.6, 1.8),
}
"""Lowest and highest top, metres."""

ALONG: dict[str, tuple[Callable[..., Mesh], float, float]] = {
    "guard_rail": (barriers.guard_rail, 0.45, 12),
    "noise_barrier": (barriers.noise_barrier, 0.25, 12),
    "bar_fence": (fences.bar_fence, 0.1, 70),
}
"""How far a thing may be from its path, metres, and its triangles per metre."""


def bend() -> np.ndarray:
    """A quarter of a circle of 40 m radius that climbs 2 m."""
    angle = np.linspace(0.0, 0.5 * np.pi, 33)
    return np.stack([40 * np.sin(angle), 40 * (1 - np.cos(angle)), angle * 4 / np.pi], axis=1)


def assert_sound(mesh: Mesh) -> None:
    """Finite, unit normals on the side from which faces run counter-clockwise."""
    corners = mesh.vertices[mesh.faces].astype(float)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.uv).all()
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
    assert (np.linalg.norm(facing, axis=1) > 0).all()
    assert ((facing * mesh.normals[mesh.faces].mean(axis=1)).sum(axis=1) > 0).all()
    assert mesh.material.max() < len(mesh.materials)


def volume(mesh: Mesh) -> float:
    """Enclosed by closed parts, negative where they are inside out; leaves and cloth are open."""
    solid = np.array([material.translucent == 0 for material in mesh.materials])[mesh.material]
    a, b, c = (mesh.vertices[mesh.faces[solid, i]].astype(float) for i in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


@pytest.mark.parametrize("name", FURNITURE)
def test_one_piece(name: str) -> None:
    for seed in range(4):
        mesh = FURNITURE[name](np.random.default_rng(seed))
        assert_sound(mesh)
        low, high = mesh.bounds
        assert -0.6 <= low[2] <= 0.05
        least, most = HEIGHTS[name]
        assert least <= high[2] <= most
        # It stands on its origin.
        foot = mesh.vertices[mesh.vertices[:, 2] < 0.15]
        assert (foot[:, :2].min(axis=0) < 0.05).all()
        assert (foot[:, :2].max(axis=0) > -0.05).all()
        assert volume(mesh) > 0
        assert len(mesh.faces) <= 500


@pytest.mark.parametrize("name", FURNITURE)
def test_one_seed_makes_one_thing(name: str) -> None:
    first, second = (FURNITURE[name](np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(first.vertices, second.vertices)
    assert first.materials == second.materials


@pytest.mark.parametrize("name", SIGN_FACES)
def test_sign_reads_from_the_front(name: str) -> None:
    plate = sign_plate(name, two_sided=True)
    face = SIGN_FACES[name]
    picture = [m.texture for m in plate.materials].index(f"sign_{name}")
    corners = np.unique(plate.faces[plate.material == picture])
    for side in (-1.0, 1.0):
        seen = corners[plate.normals[corners, 0] * side > 0.9]
        # Who looks at the front (-x) has -y at the right; who looks at the back, +y.
        right, up = plate.vertices[seen, 1] * side, plate.vertices[seen, 2]
        np.testing.assert_allclose(plate.uv[seen, 0], right + 0.5 * face.width, atol=1e-3)
        np.testing.assert_allclose(plate.uv[seen, 1], 0.5 * face.height - up, atol=1e-3)
    assert plate.materials[picture].infrared == 1.0


def test_sign_on_pole_faces_oncoming_traffic() -> None:
    mesh = traffic_sign("stop", "one_way")
    for name in ("stop", "one_way"):
        picture = [m.texture for m in mesh.materials].index(f"sign_{name}")
        front = mesh.faces[mesh.material == picture]
        assert (mesh.normals[front][..., 0] < -0.99).all()
        assert mesh.vertices[front][..., 0].max() < -0.03  # before the pole
    stop, one_way = (
        mesh.vertices[mesh.faces[mesh.material == [m.texture for m in mesh.materials].index(t)]]
        for t in ("sign_stop", "sign_one_way")
    )
    assert stop[..., 2].min() > one_way[..., 2].max()


def test_sign_pictures_are_not_mirrored() -> None:
    # The letter P is heavier at its left, the arrow of "keep right" points down to the right.
    draw = lambda name: sign_texture(SIGN_FACES[name]).make(0, np.random.default_rng(0))  # noqa: E731
    white = draw("parking")[10:-10, 10:-10].min(axis=2) > 150
    assert white[:, : white.shape[1] // 2].sum() > white[:, white.shape[1] // 2 :].sum()
    assert white[: len(white) // 2].sum() > white[len(white) // 2 :].sum()
    arrow = draw("keep_right")[20:-20, 20:-20].min(axis=2) > 150
    row, column = np.argwhere(arrow).mean(axis=0) - 0.5 * np.array(arrow.shape)
    assert row > 2
    assert column > 2


def test_traffic_light_has_one_lamp_lit() -> None:
    heights = {}
    for state in LIT:
        mesh = standing_light(state)
        lit = [i for i, material in enumerate(mesh.materials) if material.glow > 0]
        assert len(lit) == 1
        corners = mesh.faces[mesh.material == lit[0]]
        assert (mesh.normals[corners][..., 0] < -0.99).all()
        heights[state] = mesh.vertices[corners][..., 2].mean()
    assert heights["red"] > heights["amber"] > heights["green"]


@pytest.mark.parametrize("name", ALONG)
def test_follows_its_path(name: str) -> None:
    make, reach, triangles = ALONG[name]
    path = bend()
    mesh = make(path)
    assert_sound(mesh)
    points = mesh.vertices.astype(float)
    angle = np.arctan2(points[:, 0], 40 - points[:, 1])
    assert angle.min() > -0.01
    assert angle.max() < 0.5 * np.pi + 0.01
    radius = np.hypot(points[:, 0], points[:, 1] - 40)
    assert np.abs(radius - 40).max() < reach
    assert (points[:, 2] - angle * 4 / np.pi).min() > -0.6 - 0.1
    assert len(mesh.faces) <= triangles * lengths(path)[-1]


def test_guard_rail_faces_the_left_and_sinks_at_its_ends() -> None:
    mesh = barriers.guard_rail([(0, 0, 0), (60, 0, 0)])
    middle = mesh.vertices[np.abs(mesh.vertices[:, 0] - 30) < 10]
    assert middle[:, 1].max() == pytest.approx(0.18, abs=0.01)
    assert middle[:, 2].max() == pytest.approx(0.75, abs=0.02)
    end = mesh.vertices[mesh.vertices[:, 0] < 0.5]
    assert end[:, 2].max() < 0.1


def test_along_is_even() -> None:
    places = along(bend(), 3.0)
    steps = np.linalg.norm(np.diff(places[:, :3], axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-2)
    np.testing.assert_allclose(places[[0, -1], :3], bend()[[0, -1]], atol=1e-9)
    assert places[-1, 3] == pytest.approx(0.5 * np.pi, abs=0.05)


def test_overpass_leaves_the_road_free() -> None:
    mesh = crossings.overpass(length=60.0, width=9.0, clearance=4.8, opening=26.0)
    assert_sound(mesh)
    above = mesh.vertices[np.abs(mesh.vertices[:, 1]) < 12.4]
    assert above[:, 2].min() == pytest.approx(4.8, abs=0.35)
    assert above[:, 2].min() >= 4.8


def test_gantry_leaves_the_road_free() -> None:
    mesh = crossings.sign_gantry(16.0, 5.2, ("gantry_0", "gantry_2"))
    assert_sound(mesh)
    assert mesh.vertices[np.abs(mesh.vertices[:, 1]) < 7.0][:, 2].min() >= 5.2 - 1e-4
    texture = [m.texture for m in mesh.materials].index("sign_gantry_0")
    left = mesh.vertices[mesh.faces[mesh.material == texture]]
    assert left[..., 1].min() > 0  # the first board hangs at the left


def test_no_texture_family_is_named_twice() -> None:
    modules = [import_module(f"avsec_gym.world.textures.{family}") for family in FAMILIES]
    names = [name for module in modules for name in module.TEXTURES]
    assert len(names) == len(set(names))


def test_materials_have_textures() -> None:
    families = {"plain": 1}
    for family in FAMILIES:
        textures = import_module(f"avsec_gym.world.textures.{family}").TEXTURES
        families |= {name: texture.variants for name, texture in textures.items()}
    meshes = [make(np.random.default_rng(seed)) for make in FURNITURE.values() for seed in range(4)]
    meshes += [make(bend()) for make, *_ in ALONG.values()] + [crossings.overpass()]
    for texture in {material.texture for mesh in meshes for material in mesh.materials}:
        family, _, variant = texture.partition("/")
        assert int(variant or 0) < families[family]
