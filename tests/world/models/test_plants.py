from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.plants import (
    BUSHES,
    SPECIES,
    VARIANTS,
    bush,
    distant_woods,
    hedge,
    hills,
    ivy,
    tree,
)
from avsec_gym.world.textures.library import draw
from avsec_gym.world.textures.nature import TEXTURES

BUDGETS = {"near": 5000, "middle": 1500, "far": 400}


def check(mesh: Mesh, triangles: int) -> None:
    assert len(mesh.faces) <= triangles
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.uv).all()
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-3)
    assert mesh.material.max() < len(mesh.materials)
    for material in mesh.materials:
        assert material.texture.partition("/")[0] in TEXTURES


def leafy(mesh: Mesh) -> np.ndarray:
    """Which triangles are leaves."""
    return np.array([m.translucent > 0 for m in mesh.materials])[mesh.material]


@pytest.mark.parametrize("detail", BUDGETS)
@pytest.mark.parametrize("species", SPECIES)
def test_trees_keep_their_budget_and_stand_on_the_ground(species, detail):
    mesh = tree(species, 0, detail)
    check(mesh, BUDGETS[detail])
    low, high = SPECIES[species].heights
    assert low <= mesh.bounds[1][2] <= high
    assert mesh.bounds[0][2] == pytest.approx(0, abs=1e-6)
    wood = mesh.vertices[mesh.faces[~leafy(mesh)]].reshape(-1, 3)
    foot = wood[(wood[:, 2] < 0.05) & (np.hypot(wood[:, 0], wood[:, 1]) < 0.5)]
    assert len(foot) > 0
    assert np.allclose(foot[:, :2].mean(axis=0), 0, atol=0.1)


def test_a_tree_is_the_same_every_time():
    again = tree.__wrapped__("lime", 1, "middle")
    assert np.array_equal(again.vertices, tree("lime", 1, "middle").vertices)
    assert tree("lime", 1, "near") is tree("lime", 1, "near")


@pytest.mark.parametrize("species", SPECIES)
def test_variants_differ_and_grow(species):
    trees = [tree(species, variant, "far") for variant in range(VARIANTS)]
    heights = [float(mesh.bounds[1][2]) for mesh in trees]
    assert heights == sorted(heights)
    shapes = [mesh.vertices / mesh.bounds[1][2] for mesh in trees[:2]]
    assert shapes[0].shape != shapes[1].shape or not np.allclose(*shapes, atol=0.05)


@pytest.mark.parametrize("species", SPECIES)
def test_no_leaf_floats(species):
    """Every leaf reaches the trunk by steps from leaf to leaf or branch, none far."""
    mesh = tree(species, 1, "near")
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    grid = 0.05 * float(mesh.bounds[1][2])
    cells = {tuple(cell) for cell in np.floor(middles / grid).astype(int)}
    wood = middles[~leafy(mesh)]
    front = {tuple(cell) for cell in np.floor(wood / grid).astype(int)}
    cells -= front
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    while front:
        near = {(a + x, b + y, c + z) for a, b, c in front for x, y, z in steps}
        front = near & cells
        cells -= front
    assert not cells


@pytest.mark.parametrize("species", SPECIES)
def test_light_falls_on_a_crown_as_on_a_volume(species):
    mesh = tree(species, 2, "near")
    leaves = mesh.faces[leafy(mesh)]
    middle = mesh.vertices[leaves].mean(axis=1)
    outward = middle - middle.mean(axis=0)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    agreement = (mesh.normals[leaves].mean(axis=1) * outward).sum(axis=1)
    assert agreement.mean() > 0.4


@pytest.mark.parametrize("species", SPECIES)
def test_sprays_near_by_are_small(species):
    """5,000 triangles do not cover a great crown with smaller ones."""
    mesh = tree(species, VARIANTS - 1, "near")
    corners = mesh.vertices[mesh.faces[leafy(mesh)]]
    sides = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    assert np.sqrt(np.median(area)) < 0.28


@pytest.mark.parametrize("detail", ["middle", "far"])
@pytest.mark.parametrize("species", ["lime", "spruce", "birch"])
def test_coarse_trees_keep_the_outline(species, detail):
    fine, coarse = tree(species, 1, "near"), tree(species, 1, detail)
    size = np.subtract(*fine.bounds[::-1])
    assert np.allclose(np.subtract(*coarse.bounds[::-1]), size, rtol=0.2, atol=0.4)


def test_species_can_be_told_apart():
    """By colour, slenderness, or the share of the height that bears leaves."""
    features = []
    for kind, name in enumerate(SPECIES):
        mesh = tree(name, 1, "near")
        size = mesh.bounds[1] - mesh.bounds[0]
        crown = mesh.vertices[mesh.faces[leafy(mesh)]].reshape(-1, 3)
        bark = draw(mesh.materials[0].texture).mean(axis=(0, 1)) / 60
        colour = draw(f"leaves_{SPECIES[name].leaves}").mean(axis=(0, 1)) / 25
        shape = [3 * size[0] / size[2], 3 * np.quantile(crown[:, 2], 0.05) / size[2], size[2] / 6]
        features.append([*shape, *colour, *bark])
        assert kind == len(features) - 1
    rows = np.array(features)
    apart = np.linalg.norm(rows[:, None] - rows, axis=2) + 9 * np.eye(len(rows))
    assert apart.min() > 0.5


@pytest.mark.parametrize("variant", range(BUSHES))
def test_bushes(variant):
    mesh = bush(variant)
    check(mesh, 1500)
    assert mesh.bounds[0][2] == pytest.approx(0, abs=1e-5)
    assert 0.8 < mesh.bounds[1][2] < 2.7


@pytest.mark.parametrize("size", [(3.0, 1.0, 0.5), (12.0, 1.8, 0.8), (40.0, 1.2, 0.4)])
def test_a_hedge_fills_its_box_with_ragged_leaves(size):
    length, height, depth = size
    mesh = hedge(length, height, depth, 1)
    check(mesh, 5000)
    low, high = mesh.bounds
    assert np.allclose(low, [-length / 2, -depth / 2, 0], atol=1e-4)
    assert np.allclose(high, [length / 2, depth / 2, height], atol=1e-4)
    top = mesh.vertices[np.abs(mesh.normals[:, 2]) > 0.8, 2]
    assert 0.005 < np.std(top[top > 0.7 * height]) < 0.1
    assert np.array_equal(hedge(length, height, depth, 1).vertices, mesh.vertices)


def test_ivy_clings_to_its_wall():
    mesh = ivy(4.0, 5.0, 1)
    check(mesh, 2500)
    low, high = mesh.bounds
    assert low[0] > 0
    assert high[0] < 0.4
    assert low[2] >= 0
    assert high[2] < 5.3
    assert np.abs(mesh.vertices[:, 1]).max() < 2.3


@pytest.mark.parametrize("seed", range(3))
def test_the_horizon_is_closed(seed):
    rng = np.random.default_rng(seed)
    woods, land = distant_woods(rng, 200, 450), hills(rng)
    check(woods, 4000)
    check(land, 4000)
    for mesh, nearest, farthest in ((woods, 200, 460), (land, 370, 910)):
        distance = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1])
        assert nearest <= distance.min()
        assert distance.max() <= farthest
        assert mesh.bounds[0][2] < 0
        corners = mesh.vertices[mesh.faces]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert ((facing * mesh.normals[mesh.faces].mean(axis=1)).sum(axis=1) > 0).mean() > 0.97
    azimuth = np.arctan2(land.vertices[:, 1], land.vertices[:, 0])
    elevation = land.vertices[:, 2] / np.hypot(land.vertices[:, 0], land.vertices[:, 1])
    sector = ((azimuth + np.pi) / (2 * np.pi) * 60).astype(int) % 60
    highest = np.array([elevation[sector == number].max() for number in range(60)])
    assert highest.min() > 0.002
    assert highest.std() > 0.002


@pytest.mark.parametrize("family", ["leaves_lime", "leaves_pine", "forest_far", "bark_birch"])
def test_textures_go_on_at_their_edges(family):
    picture = draw(f"{family}/0").astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(picture, axis=axis)).mean()
        seam = np.abs(np.take(picture, 0, axis) - np.take(picture, -1, axis)).mean()
        assert seam < 1.6 * inside + 2
