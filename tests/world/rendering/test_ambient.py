import numpy as np
import pytest

from avsec_gym.world.rendering.ambient import ambient_light
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.rendering.surfaces import surfaces
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, polygon, tube

pytestmark = pytest.mark.usefixtures("little_textures")

DARK_SUN = np.zeros(3, np.float32)
PLAIN = polygon([(-900, -900, 0), (900, -900, 0), (900, 900, 0), (-900, 900, 0)])


def arriving(meshes, panorama, spread=2.0, eye=1.0, normal=(0.0, 0.0, -1.0), count=600):
    """Ambient light on surfaces around the origin, by rays from near them, shape (count, 3)."""
    renderer = Renderer(RayScene([Thing(mesh, Surface.ROAD, 0) for mesh in meshes]), Light())
    rng = np.random.default_rng(0)
    origins = np.zeros((count, 3), np.float32)
    origins[:, :2] = rng.uniform(-spread, spread, (count, 2))
    origins[:, 2] = eye
    directions = np.tile(np.array(normal, np.float32), (count, 1))
    hits = renderer.scene.hits(origins, directions)
    sun = np.array([0, 0, 1], np.float32)
    found = surfaces(renderer.arrays, hits, origins, directions, sun, 0.001)
    hit = hits.face >= 0
    return ambient_light(renderer.scene, found, hit, panorama, DARK_SUN, 1.0)


def test_open_ground_gets_the_cosine_weighted_mean_of_the_sky() -> None:
    panorama = Light(cloudiness=0.3, azimuth=0.5, elevation=0.6, seed=3).panorama
    # Rows are even in the sine of the elevation h, hence in solid angle; the cosine is h.
    height = (np.arange(96) + 0.5) / 96
    expected = (panorama * height[:, None, None]).sum(axis=(0, 1)) / (512 * height.sum())
    found = arriving([PLAIN], panorama)
    np.testing.assert_allclose(found.mean(axis=0), expected, rtol=0.03)
    assert (np.abs(found / expected - 1) < 0.5).all()


def test_an_upright_wall_gets_half_a_sky() -> None:
    """Under an even sky: one half from above, from below what open ground brings back."""
    even = np.ones((96, 512, 3), np.float32)
    wall = polygon([(0, 40, -5), (0, -40, -5), (0, -40, 50), (0, 40, 50)])
    closed = arriving([box(9, 9, 9).placed(0, 0, -4.0)], even).mean()
    rays = arriving([wall.placed(3.0, 0.0)], even, 0.1, 1.0, (1.0, 0.0, 0.0))
    assert rays.mean() == pytest.approx(0.5 + 0.5 * closed, rel=0.03)


def test_a_closed_room_gets_only_what_comes_back_from_its_walls() -> None:
    even = np.ones((96, 512, 3), np.float32)
    inside = arriving([box(9, 9, 9).placed(0, 0, -4.0)], even)
    assert np.ptp(inside) == 0
    assert 0.02 < inside.mean() < 0.5


@pytest.mark.parametrize("depth", [1.0, 3.0])
def test_the_bottom_of_a_shaft_gets_the_share_of_the_sky_that_it_sees(depth: float) -> None:
    """r^2 / (r^2 + depth^2) of the light at the middle of a round shaft's bottom."""
    even = np.ones((96, 512, 3), np.float32)
    shaft = tube([(0, 0, -0.5), (0, 0, depth)], 1.0, sides=60, capped=False)
    closed = arriving([box(9, 9, 9).placed(0, 0, -4.0)], even).mean()
    found = arriving([PLAIN, shaft], even, 0.02, 0.5).mean()
    share = 1.0 / (1.0 + depth**2)
    assert found == pytest.approx(share + (1 - share) * closed, abs=0.03)


def test_where_nothing_is_hit_there_is_no_light_to_find() -> None:
    even = np.ones((96, 512, 3), np.float32)
    assert (arriving([PLAIN], even, normal=(0.0, 0.0, 1.0)) == 0).all()


def test_corners_are_darker_than_open_ground_in_a_picture(look) -> None:
    """A yard between high walls, and the plain beside it, in the shade of an overcast sky."""
    walls = [box(8.0, 0.3, 9.0).placed(14.0, y) for y in (1.0, 7.0)]
    walls.append(box(0.3, 6.0, 9.0).placed(18.0, 4.0))
    things = [Thing(mesh, Surface.BUILDING, 1) for mesh in walls] + [Thing(PLAIN, Surface.ROAD, 0)]
    scene = Renderer(RayScene(things), Light(cloudiness=1.0, haze=1e6))
    camera = look((0, 0, 12.0), (14.0, 0.0, 0.0), focal_length=90.0)
    view = scene.view(camera)
    assert np.isfinite(view.light).all()
    v, u = np.nonzero(view.geometry.object_id == 0)
    depth = view.geometry.depth[v, u]
    rays = np.stack([(u - 79.5) / 90 * depth, (v - 23.5) / 90 * depth, depth], axis=-1)
    x, y, _ = (rays @ camera.to_world[:3, :3].T + camera.to_world[:3, 3]).T
    brightness = view.light.mean(axis=-1)[v, u]
    yard = (x > 15.0) & (x < 17.5) & (y > 1.6) & (y < 6.4)
    plain = (y < -6.0) & (x > 8.0)
    assert yard.sum() > 20
    assert np.median(brightness[yard]) < 0.7 * np.median(brightness[plain])
