import numpy as np
import pytest
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from avsec_gym.world.layouts.dimensions import CATEGORIES, draw_dimensions
from avsec_gym.world.models.vehicles import body_designs, make_ego_vehicle, make_vehicle
from avsec_gym.world.models.vehicles.body_design import draw_design
from avsec_gym.world.models.vehicles.designs import body_design, choose_design
from avsec_gym.world.models.vehicles.lower_body import lower_skin
from avsec_gym.world.textures import cars, vehicles

KINDS = ("Car", "Van", "Truck", "Misc", "Tram")


def some_vehicle(category, appearance):
    rng = np.random.default_rng(appearance)
    if category == "Tram":
        size = rng.uniform([2.9, 2.0, 11.0], [3.9, 2.8, 36.0])
    else:
        code = CATEGORIES.tolist().index(category)
        size = draw_dimensions(rng, np.array([code]))[0]
    dimensions = (float(size[0]), float(size[1]), float(size[2]))
    return make_vehicle(category, dimensions, appearance), dimensions


def scene_of(mesh):
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(mesh.vertices[mesh.faces]))
    return scene


@pytest.mark.parametrize("category", KINDS)
def test_every_appearance_fills_its_box_with_sound_surfaces(category):
    for appearance in range(50):
        mesh, (height, width, length) = some_vehicle(category, appearance)
        low, high = mesh.bounds
        np.testing.assert_allclose(low, [-0.5 * length, -0.5 * width, 0.0], atol=1e-3)
        np.testing.assert_allclose(high, [0.5 * length, 0.5 * width, height], atol=1e-3)
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-3)
        corners = mesh.vertices[mesh.faces]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        shading = mesh.normals[mesh.faces].sum(axis=1)
        area = np.linalg.norm(facing, axis=1)
        agree = np.einsum("ij,ij->i", facing, shading) > 0
        assert area[agree].sum() > 0.99 * area.sum()
        assert agree.mean() > 0.95


@pytest.mark.parametrize("category", ["Car", "Van", "Misc"])
def test_triangles_are_few(category):
    for appearance in range(30):
        assert len(some_vehicle(category, appearance)[0].faces) <= 7500  # smooth at 8 m


@pytest.mark.parametrize("category", ["Car", "Van", "Truck", "Tram"])
def test_no_ray_towards_the_middle_passes_through(category):
    rng = np.random.default_rng(0)
    directions = rng.standard_normal((4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for appearance in range(5):
        mesh, (height, _, _) = some_vehicle(category, appearance)
        middle = np.array([0.0, 0.0, 0.4 * height])
        origins = (middle - 40.0 * directions).astype(np.float32)
        hits = scene_of(mesh).run(origins, directions.astype(np.float32), output=True)
        assert (hits["primID"] >= 0).all()
        # Above the bed of an open platform lorry the middle is in the air.
        assert category == "Truck" or (hits["tfar"] < 40.0).all()


def test_there_is_air_under_a_car_and_one_cannot_look_up_into_it():
    mesh = make_vehicle("Car", (1.5, 1.7, 4.2), 5)
    scene = scene_of(mesh)
    across = np.array([[x, -5.0, 0.10] for x in np.linspace(-0.6, 0.6, 20)], np.float32)
    hits = scene.run(across, np.tile(np.float32([0, 1, 0]), (20, 1)), output=True)
    assert (hits["primID"] < 0).all()
    grid = [[x, y, 0.01] for x in np.linspace(-1.8, 1.8, 30) for y in (-0.4, 0.0, 0.4)]
    below = np.array(grid, np.float32)
    hits = scene.run(below, np.tile(np.float32([0, 0, 1]), (len(below), 1)), output=True)
    assert (hits["primID"] >= 0).all()
    assert hits["tfar"].max() < 0.6


@pytest.mark.parametrize("category", ["Car", "Van", "Truck"])
def test_plates_front_and_rear_read_from_left_to_right(category):
    for appearance in range(20):
        mesh, (_, _, length) = some_vehicle(category, appearance)
        seen = set()
        for code, material in enumerate(mesh.materials):
            if not material.texture.startswith("plate/"):
                continue
            assert material.infrared == 1.0
            for face in mesh.faces[mesh.material == code]:
                points, normal = mesh.vertices[face], mesh.normals[face[0]]
                to_the_right = np.cross(-normal, [0.0, 0.0, 1.0])
                along, down = points @ to_the_right, -points[:, 2]
                assert np.polyfit(along, mesh.uv[face, 0], 1)[0] > 0
                assert np.polyfit(down, mesh.uv[face, 1], 1)[0] > 0
                assert abs(points[:, 0].mean()) > 0.4 * length
                seen.add(np.sign(normal[0]))
        assert seen == {-1.0, 1.0}


def test_lettering_on_lorries_reads_from_left_to_right_on_both_sides():
    found = 0
    for appearance in range(30):
        mesh, _ = some_vehicle("Truck", appearance)
        for code, material in enumerate(mesh.materials):
            if material.texture.startswith("cargo_side"):
                for face in mesh.faces[mesh.material == code]:
                    points, normal = mesh.vertices[face], mesh.normals[face[0]]
                    along = points @ np.cross(-normal, [0.0, 0.0, 1.0])
                    assert np.polyfit(along, mesh.uv[face, 0], 1)[0] > 0
                    found += 1
    assert found > 20


def test_one_seed_gives_one_vehicle_and_seeds_differ():
    first = make_vehicle("Car", (1.45, 1.65, 4.1), 7)
    again = make_vehicle("Car", (1.45, 1.65, 4.1), 7)
    np.testing.assert_array_equal(first.vertices, again.vertices)
    assert first.materials == again.materials
    others = [make_vehicle("Car", (1.45, 1.65, 4.4), seed) for seed in range(12)]
    paints = {
        material.tint
        for mesh in others
        for material in mesh.materials
        if material.texture.startswith("car_side")
    }
    assert len(paints) > 3
    assert len({side_view(mesh).tobytes() for mesh in others}) > 6


def side_view(mesh):
    """Heights of the outline seen from the side, every 10 cm, in steps of 2 cm."""
    x = np.arange(-2.1, 2.1, 0.1)
    origins = np.column_stack([x, np.full_like(x, 0.01), np.full_like(x, 5.0)]).astype(np.float32)
    down = np.tile(np.float32([0, 0, -1]), (len(x), 1))
    return np.round((5.0 - scene_of(mesh).run(origins, down, output=True)["tfar"]) / 0.02)


def test_windows_let_pulses_pass_to_something_inside():
    mesh = make_vehicle("Car", (1.5, 1.7, 4.2), 1)
    glass = np.array([material.glass for material in mesh.materials])[mesh.material]
    assert 0.01 < glass.mean() < 0.3
    without = scene_of(
        type(mesh)(
            mesh.vertices,
            mesh.normals,
            mesh.uv,
            mesh.faces[~glass],
            mesh.material[~glass],
            mesh.materials,
        )
    )
    origins = np.array([[6.0, y, 1.6] for y in np.linspace(-0.4, 0.4, 9)], np.float32)
    direction = np.float32([0.0, 0.0, 1.15]) - origins
    hits = without.run(origins, direction, output=True)
    assert (hits["primID"] >= 0).all()
    assert (np.abs(hits["tfar"]) < 1.4).all()


def test_every_texture_exists():
    names = {"plain"}
    for family, texture in (cars.TEXTURES | vehicles.TEXTURES).items():
        several = texture.variants > 1
        names |= {f"{family}/{i}" for i in range(texture.variants)} if several else {family}
    for category in KINDS:
        for appearance in range(15):
            mesh, _ = some_vehicle(category, appearance)
            assert {material.texture for material in mesh.materials} <= names


def test_the_ego_vehicle_is_an_estate_with_sensors_above_its_roof():
    low, high = make_ego_vehicle().bounds
    np.testing.assert_allclose((high - low)[:2], [4.7, 1.8], atol=1e-3)
    assert 1.7 < high[2] < 2.0


def test_an_unknown_category_is_refused():
    with pytest.raises(ValueError, match="Pedestrian"):
        make_vehicle("Pedestrian", (1.8, 0.5, 0.5), 0)


def test_body_designs_have_names_and_shapes_of_their_own():
    designs = body_designs()
    assert len(body_designs("Car")) >= 24
    assert len({design.name for design in designs}) == len(designs)
    assert all(body_design(design.name) is design for design in designs)
    kinds = {design.kind for design in body_designs("Car")}
    assert {"city car", "hatchback", "saloon", "estate", "coupé", "off-roader", "pick-up"} <= kinds
    with pytest.raises(ValueError, match="hovercraft"):
        body_design("hovercraft")
    # Cut to the same box they still differ by centimetres.
    skins = [
        lower_skin(draw_design(np.random.default_rng(0), design, 1.5, 1.7, 4.2)).left
        for design in body_designs("Car")
    ]
    for i, one in enumerate(skins):
        for other in skins[i + 1 :]:
            assert one.shape != other.shape or np.abs(one - other).max() > 0.01


def test_a_box_gets_a_design_of_about_its_size():
    rng = np.random.default_rng(0)
    chosen = {
        size: {choose_design(rng, body_designs("Car"), *size).kind for _ in range(60)}
        for size in ((1.42, 4.4), (1.75, 4.4), (1.5, 3.4))
    }
    assert "saloon" in chosen[1.42, 4.4]
    assert "off-roader" not in chosen[1.42, 4.4]
    assert "off-roader" in chosen[1.75, 4.4]
    assert not chosen[1.75, 4.4] & {"saloon", "coupé"}
    assert "city car" in chosen[1.5, 3.4]
    assert not chosen[1.5, 3.4] & {"saloon", "off-roader", "pick-up"}


def test_flanks_bend_without_facets():
    """From column to column normals turn little, but round the corners of boxy bodies."""
    for design in body_designs("Car"):
        skin = lower_skin(draw_design(np.random.default_rng(0), design, 1.5, 1.7, 4.2))
        between = np.abs(skin.points[1:, 6, 0]) < 1.2
        normals = skin.normals[:, 5:9]
        alike = (normals[1:] * normals[:-1]).sum(axis=-1)[between]
        np.testing.assert_array_less(0.92, alike)
