import numpy as np
import pytest
import shapely
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from avsec_gym.world.mesh import merge
from avsec_gym.world.road.junction import mouths, road_height
from avsec_gym.world.road.land import land_mesh
from avsec_gym.world.road.surface import PAINTED, painted_edges, road_meshes
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Style

START, END = -30.0, 90.0


def heights(meshes, x, y):
    """What a plumb line from above meets first; NaN for nothing."""
    mesh = merge(meshes)
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices, mesh.faces)
    origins = np.stack([x, y, np.full_like(x, 50.0)], axis=-1).astype(np.float32)
    down = np.tile(np.array([0.0, 0.0, -1.0], np.float32), (len(x), 1))
    found = scene.run(origins, down, query="INTERSECT", output=True)
    return np.where(found["primID"] >= 0, 50.0 - found["tfar"], np.nan)


def places(place, count=4000, seed=0, beyond=0.0):
    rng = np.random.default_rng(seed)
    right, left = place.section.edges
    along = rng.uniform(START + 0.01, END - 0.01, count)
    across = rng.uniform(right - beyond, left + beyond, count)
    borders = np.array([right, *(strip.left for strip in place.section.strips)])
    clear = np.abs(across[:, None] - borders).min(1) > 0.02
    return along[clear], across[clear]


@pytest.mark.parametrize("style", list(Style))
@pytest.mark.parametrize("mouth", [False, True])
def test_the_surface_has_no_gaps_and_the_sections_heights(make_site, style, mouth):
    place = make_site(style, mouth=mouth)
    along, left = places(place)
    if mouth:
        # Kerbs round the corners where the section alone would have a pavement.
        area = mouths(place, START, END)[0].area.bounds
        clear = (along < area[0]) | (along > area[2]) | (left < area[1])
        along, left = along[clear], left[clear]
    x, y, _ = place.course.poses(along, left).T
    found = heights([mesh for mesh, _ in road_meshes(place, START, END)], x, y)
    expected = place.ground.height(x, y) + place.section.height(left)
    np.testing.assert_allclose(found, expected, atol=0.01)


@pytest.mark.parametrize("style", [Style.CITY, Style.RURAL])
def test_land_and_road_meet_without_gaps(make_site, style):
    place = make_site(style, mouth=True)
    along, left = places(place, beyond=25.0)
    x, y, _ = place.course.poses(along, left).T
    meshes = [mesh for mesh, _ in road_meshes(place, START, END)]
    meshes.append(land_mesh(place, START, END, np.random.default_rng(0)))
    above = heights(meshes, x, y) - place.ground.height(x, y)
    assert np.isfinite(above).all()
    assert above.min() > -0.02
    assert above.max() < 0.14
    beyond = (left < place.section.edges[0]) & (np.abs(along - 30.0) > 25.0)
    np.testing.assert_allclose(above[beyond], 0.0, atol=0.02)


def test_mouths_are_flat_and_kerbs_stand_beside_them(make_site):
    place = make_site(Style.CITY, mouth=True)
    edge = place.section.carriageway[1]
    outer = place.section.edges[1]
    left = np.linspace(edge + 0.05, outer + 1.0, 40)
    x, y, _ = place.course.poses(np.full_like(left, 30.3), left).T
    meshes = road_meshes(place, START, END)
    found = heights([mesh for mesh, _ in meshes], x, y)
    np.testing.assert_allclose(found, place.ground.height(x, y), atol=0.01)
    np.testing.assert_array_equal(road_height(place, np.full_like(left, 30.3), left), 0.0)
    kerb = next(mesh for mesh, kind in meshes if kind == Surface.KERB)
    height = kerb.vertices[:, 2] - place.ground.height(*kerb.vertices[:, :2].T)
    assert height.min() == pytest.approx(0.0, abs=0.01)
    assert height.max() == pytest.approx(0.12, abs=0.01)


def test_no_wall_stands_across_a_mouth(make_site):
    place = make_site(Style.CITY, mouth=True)
    mesh = merge([mesh for mesh, _ in road_meshes(place, START, END)])
    upright = np.abs(mesh.normals[mesh.faces[:, 0], 2]) < 0.5
    centres = mesh.vertices[mesh.faces[upright]].mean(1)
    along, left = place.course.coordinates(centres[:, 0], centres[:, 1])
    inside = mouths(place, START, END)[0].paved.buffer(-0.1)
    assert not shapely.contains_xy(inside, along, left).any()


def test_overlay_coordinates_are_road_coordinates(make_site):
    place = make_site(Style.CITY, mouth=True)
    top = painted_edges(place.section)[1]
    for mesh, kind in road_meshes(place, START, END):
        if kind not in PAINTED:
            assert mesh.overlay_uv is None
            continue
        shown = np.isfinite(mesh.overlay_uv[:, 0])
        along, left = START + mesh.overlay_uv[shown, 0], top - mesh.overlay_uv[shown, 1]
        x, y, _ = place.course.poses(along, left).T
        np.testing.assert_allclose(mesh.vertices[shown, 0], x, atol=1e-3)
        np.testing.assert_allclose(mesh.vertices[shown, 1], y, atol=1e-3)


def test_upper_sides_face_upwards(make_site):
    place = make_site(Style.RESIDENTIAL, mouth=True)
    meshes = [mesh for mesh, _ in road_meshes(place, START, END)]
    for mesh in (*meshes, land_mesh(place, START, END, np.random.default_rng(0))):
        a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
        facing = np.cross(b - a, c - a)
        agree = (facing * mesh.normals[mesh.faces[:, 0]]).sum(1)
        assert (agree >= -1e-7).all()
        assert (facing[:, 2] >= -1e-7).all()


def test_the_same_site_gives_the_same_meshes(make_site):
    one, two = (road_meshes(make_site(Style.CITY, mouth=True), START, END) for _ in range(2))
    for (mesh, kind), (other, other_kind) in zip(one, two, strict=True):
        assert kind == other_kind
        assert mesh.materials == other.materials
        np.testing.assert_array_equal(mesh.vertices, other.vertices)
    land, again = (
        land_mesh(make_site(Style.CITY), START, END, np.random.default_rng(3)) for _ in range(2)
    )
    np.testing.assert_array_equal(land.material, again.material)
