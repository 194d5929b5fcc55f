import numpy as np
import pytest

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import merge
from avsec_gym.world.rendering.ray_scene import NO_OVERLAY, NOTHING, RayScene, Thing
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, grid

pytestmark = pytest.mark.usefixtures("little_textures")


def rays(origins, directions) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.ascontiguousarray(origins, np.float32),
        np.ascontiguousarray(directions, np.float32),
    )


def test_rays_meet_the_nearest_thing_and_know_what_it_is() -> None:
    red = Material(tint=(1.0, 0.0, 0.0))
    scene = RayScene(
        [
            Thing(box(2.0, 2.0, 2.0).placed(10.0, 0.0), Surface.BUILDING),
            Thing(box(1.0, 1.0, 2.0, red).placed(5.0, 0.0), Surface.VEHICLE, 7),
        ]
    )
    hits = scene.hits(*rays([[0, 0, 1], [0, 0.8, 1], [0, 0, 3]], [[1, 0, 0]] * 3))
    np.testing.assert_allclose(hits.distance[:2], [4.5, 9.0], rtol=1e-5)
    assert hits.distance[2] > 1e30
    assert (hits.face[:2] >= 0).all()
    assert hits.face[2] == -1
    assert scene.object_id[hits.face[:2]].tolist() == [7, NOTHING]
    assert scene.surface[hits.face[:2]].tolist() == [Surface.VEHICLE, Surface.BUILDING]
    tints = scene.materials.tint[scene.material[hits.face[:2]]]
    np.testing.assert_allclose(tints, [[1, 0, 0], [1, 1, 1]])


def test_barycentric_coordinates_lead_to_the_point_that_was_hit() -> None:
    rng = np.random.default_rng(0)
    scene = RayScene([Thing(box(3.0, 2.0, 1.0).placed(6.0, 0.5, 0.2, 0.7), Surface.VEHICLE, 0)])
    aims = rng.normal((6.0, 0.5, 0.7), 0.4, (200, 3))
    directions = aims / np.linalg.norm(aims, axis=1, keepdims=True)
    origins, directions = rays(np.zeros((200, 3)), directions)
    hits = scene.hits(origins, directions)
    met = hits.face >= 0
    assert met.sum() > 100
    a, b, c = np.moveaxis(scene.vertices[scene.faces[hits.face[met]]], 1, 0)
    u, v = hits.u[met, None], hits.v[met, None]
    np.testing.assert_allclose(
        (1 - u - v) * a + u * b + v * c, directions[met] * hits.distance[met, None], atol=1e-4
    )
    np.testing.assert_array_equal(scene.blocked(origins, directions), met)


def test_no_rays_meet_nothing() -> None:
    scene = RayScene([Thing(box(1.0, 1.0, 1.0), Surface.VEHICLE, 0)])
    none = np.zeros((0, 3), np.float32)
    assert len(scene.hits(none, none).face) == 0
    assert scene.blocked(none, none).shape == (0,)


def test_what_has_no_overlay_is_marked_for_the_kernels() -> None:
    x, y = np.meshgrid([0.0, 1.0], [0.0, 1.0], indexing="ij")
    road = grid(np.stack([x, y, 0 * x], -1), overlay_uv=np.stack([x, y], -1))
    plain = RayScene([Thing(box(1.0, 1.0, 1.0), Surface.ROAD)])
    assert len(plain.overlay_uv) == 0
    both = RayScene([Thing(road, Surface.ROAD), Thing(box(1.0, 1.0, 1.0), Surface.VEHICLE, 0)])
    assert np.isfinite(both.overlay_uv).all()
    np.testing.assert_array_equal(both.overlay_uv[:4], road.overlay_uv)
    assert (both.overlay_uv[4:] == NO_OVERLAY).all()


def test_materials_come_to_the_kernels_as_they_are() -> None:
    leaf = Material(
        "speckles", (0.1, 0.2, 0.3), mirror=0.05, translucent=0.4, infrared=0.6, glow=0.7
    )
    pane = Material(glass=True)
    scene = RayScene([Thing(merge([box(1, 1, 1, leaf), box(2, 2, 2, pane)]), Surface.VEGETATION)])
    table, rows = scene.materials, scene.material[[0, -1]]
    np.testing.assert_allclose(table.tint[rows[0]], [0.1, 0.2, 0.3], rtol=1e-6)
    for name, (first, last) in {
        "texture": (1, 0), "mirror": (0.05, 0.0), "glass": (False, True),
        "translucent": (0.4, 0.0), "infrared": (0.6, -1.0), "glow": (0.7, 0.0),
    }.items():  # fmt: skip
        np.testing.assert_allclose(getattr(table, name)[rows], [first, last], rtol=1e-6)
