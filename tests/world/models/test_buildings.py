import numpy as np
import pytest
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from avsec_gym.errors import ConfigurationError
from avsec_gym.world.models.buildings import (
    FRONT_OVERHANG,
    KINDS,
    SIDE_OVERHANG,
    garden_wall,
    make_building,
    picket_fence,
)
from avsec_gym.world.textures.walls import TEXTURES

SIZES = {
    "detached": (11.0, 9.0),
    "terrace": (12.0, 12.0),
    "apartment": (20.0, 11.0),
    "shop": (13.0, 12.0),
    "garage": (15.0, 6.0),
    "campus": (36.0, 14.0),
    "hall": (28.0, 18.0),
}
CASES = [(kind, seed) for kind in KINDS for seed in range(6)]


def building(kind, seed):
    return make_building(kind, *SIZES[kind], np.random.default_rng(seed))


def first_hits(mesh, origins, directions):
    """Index of the face that each ray meets first (-1 for none), and its distance."""
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, mesh.vertices[mesh.faces].astype(np.float32))
    origins, directions = np.float32(origins), np.float32(directions)
    hit = scene.run(origins, directions, output=True)
    distance = np.where(hit["geomID"] >= 0, hit["tfar"], np.inf)
    return np.where(hit["geomID"] >= 0, hit["primID"], -1), distance


def face_normals(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_walls_close_the_house_all_round(kind, seed):
    mesh = building(kind, seed)
    width, depth = SIZES[kind]
    x, z = np.meshgrid(np.linspace(-0.48, 0.48, 37) * width, np.linspace(-0.5, 2.0, 17))
    y = (0.5 + np.linspace(-0.48, 0.48, 37)) * depth
    y = np.broadcast_to(y, x.shape)
    normals = face_normals(mesh)
    for origin, direction, plane in (
        ((x, x * 0 - 30, z), (0, 1, 0), 30.0),
        ((x, x * 0 + depth + 30, z), (0, -1, 0), 30.0),
        ((x * 0 - width, y, z), (1, 0, 0), 0.5 * width),
        ((x * 0 + width, y, z), (-1, 0, 0), 0.5 * width),
    ):
        origins = np.stack(origin, axis=-1).reshape(-1, 3)
        face, distance = first_hits(mesh, origins, np.tile(direction, (len(origins), 1)))
        assert (distance < plane + 0.4).all(), "an opening in the wall"
        assert (normals[face] @ direction < 1e-3).all(), "a wall seen from behind"


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_no_light_leaks_in(kind, seed):
    mesh = building(kind, seed)
    width, depth = SIZES[kind]
    rng = np.random.default_rng(0)
    inside = rng.uniform((-0.4, 0.1, 1.0), (0.4, 0.9, 1.5), (4000, 3)) * (width, depth, 1.0)
    upwards = rng.normal(size=(4000, 3))
    upwards[:, 2] = np.abs(upwards[:, 2])
    face, _ = first_hits(mesh, inside, upwards)
    assert (face >= 0).all(), "a hole in the roof or below it"


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_roof_covers_the_house(kind, seed):
    mesh = building(kind, seed)
    width, depth = SIZES[kind]
    x, y = np.meshgrid(np.linspace(-0.49, 0.49, 61) * width, np.linspace(0.01, 0.99, 61) * depth)
    above = np.stack([x, y, np.full_like(x, 60.0)], axis=-1).reshape(-1, 3)
    face, distance = first_hits(mesh, above, np.tile((0.0, 0.0, -1.0), (len(above), 1)))
    assert (distance < 60.0 - 2.2).all()
    assert (face_normals(mesh)[face, 2] > -1e-3).all(), "a roof seen from below"


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_building_keeps_to_its_plot(kind, seed):
    low, high = building(kind, seed).bounds
    width, depth = SIZES[kind]
    side = 0.5 * width + SIDE_OVERHANG[kind] + 1e-4
    assert -side <= low[0]
    assert high[0] <= side
    assert -FRONT_OVERHANG <= low[1] <= 0.0
    assert high[1] <= depth + FRONT_OVERHANG
    assert low[2] == pytest.approx(-0.6, abs=0.05)
    assert 2.0 < high[2] < 30.0


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_mesh_is_sound_and_cheap(kind, seed):
    mesh = building(kind, seed)
    assert len(mesh.faces) <= 1700
    assert np.isfinite(mesh.uv).all()
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
    assert ((face_normals(mesh)[:, None] * mesh.normals[mesh.faces]).sum(axis=-1) > 0.99).all()
    for material in mesh.materials:
        family, _, variant = material.texture.partition("/")
        assert family == "plain" or int(variant or 0) < TEXTURES[family].variants


@pytest.mark.parametrize("kind", KINDS)
def test_same_chance_same_building(kind):
    first, second, other = building(kind, 3), building(kind, 3), building(kind, 4)
    assert np.array_equal(first.vertices, second.vertices)
    assert first.materials == second.materials
    assert (
        first.materials != other.materials
        or first.vertices.shape != other.vertices.shape
        or not np.array_equal(first.vertices, other.vertices)
    )


def test_kinds_differ():
    shapes = {len(building(kind, 0).faces) for kind in KINDS}
    assert len(shapes) == len(KINDS)


def test_unknown_kind():
    with pytest.raises(ConfigurationError, match="castle"):
        make_building("castle", 10.0, 10.0, np.random.default_rng(0))


@pytest.mark.parametrize("make", [garden_wall, picket_fence])
@pytest.mark.parametrize("seed", range(6))
def test_fences_fill_their_line(make, seed):
    mesh = make(7.5, np.random.default_rng(seed))
    low, high = mesh.bounds
    assert low[0] == pytest.approx(-3.75, abs=0.25)
    assert high[0] == pytest.approx(3.75, abs=0.25)
    assert -0.25 <= low[1] < high[1] <= 0.25
    assert low[2] == pytest.approx(-0.6)
    assert 0.4 < high[2] < 2.0
    assert len(mesh.faces) < 1500


@pytest.mark.parametrize(
    "family", [name for name, texture in TEXTURES.items() if texture.size != (1.0, 1.0)]
)
def test_textures_repeat_without_a_seam(family):
    texture = TEXTURES[family]
    for variant in range(texture.variants):
        picture = texture.make(variant, np.random.default_rng(variant)).astype(float)
        assert max(picture.shape) <= 512
        step = np.abs(np.diff(picture, axis=1)).mean(axis=(0, 2))
        seam = np.abs(picture[:, 0] - picture[:, -1]).mean()
        assert seam <= step.max() + 2.0
