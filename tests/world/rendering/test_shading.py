import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avsec_gym.world.material import Material
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.rendering.shading import radiance
from avsec_gym.world.rendering.surfaces import Surfaces, surfaces
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, polygon

pytestmark = pytest.mark.usefixtures("little_textures")

SQUARE = [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)]
LEAF = Material(tint=(0.5, 0.5, 0.5), translucent=0.4)


def met(material: Material, origin, target, sun, corners=SQUARE) -> Surfaces:
    """What one ray meets on a plate."""
    renderer = Renderer(
        RayScene([Thing(polygon(corners, material), Surface.FURNITURE, 0)]), Light()
    )
    direction = np.subtract(target, origin)
    direction = direction / np.linalg.norm(direction)
    rays = [np.array([vector], np.float32) for vector in (origin, direction)]
    sun = np.asarray(sun, np.float32)
    return surfaces(renderer.arrays, renderer.scene.hits(*rays), *rays, sun, 0.001)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(st.floats(-np.pi, np.pi), st.floats(-1.5, 1.5))
def test_sunlight_falls_with_the_cosine_and_on_one_side_only(
    azimuth: float, elevation: float
) -> None:
    flat = np.cos(elevation)
    sun = (flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    from_above = met(Material(), (1, 1, 3), (0, 0, 0), sun)
    from_below = met(Material(), (1, 1, -3), (0, 0, 0), sun)
    assert from_above.sunlight[0] == pytest.approx(max(0.0, np.sin(elevation)), abs=1e-4)
    assert from_below.sunlight[0] == pytest.approx(max(0.0, -np.sin(elevation)), abs=1e-4)


def test_a_leaf_lets_a_share_of_the_light_behind_it_through() -> None:
    sun = (0.6, 0.0, 0.8)
    lit = met(LEAF, (1, 1, 3), (0, 0, 0), sun)
    lit_from_behind = met(LEAF, (1, 1, -3), (0, 0, 0), sun)
    assert max(lit.sunlight[0], lit_from_behind.sunlight[0]) == pytest.approx(0.8, abs=1e-4)
    upside_down = met(LEAF, (1, 1, -3), (0, 0, 0), (0.6, 0.0, -0.8), SQUARE)
    assert upside_down.sunlight[0] > 0
    # The ray to the sun must leave on the sun's side, or the leaf would lie in its own shadow.
    assert lit.point[0, 2] > 0
    assert lit_from_behind.point[0, 2] > 0
    assert met(LEAF, (1, 1, 3), (0, 0, 0), (0.6, 0, -0.8)).sunlight[0] == pytest.approx(0.32)
    assert upside_down.point[0, 2] < 0


def test_points_lie_before_the_surface_on_the_viewers_side() -> None:
    for side in (1, -1):
        found = met(Material(), (1, 2, 3 * side), (0.5, 0.2, 0), (0, 0, 1))
        np.testing.assert_allclose(found.point[0, :2], [0.5, 0.2], atol=0.01)
        assert 0 < side * found.point[0, 2] < 0.01
        assert side * found.normal[0, 2] == pytest.approx(1.0)


def test_colour_and_glow_are_those_of_the_material() -> None:
    found = met(Material(tint=(0.2, 0.5, 0.8), glow=0.5), (1, 2, 3), (0, 0, 0), (0, 0, 1))
    np.testing.assert_allclose(found.albedo[0], [0.2, 0.5, 0.8], rtol=1e-4)
    assert found.glow[0] == pytest.approx(0.5)


def test_mirrors_are_stronger_at_grazing_angles() -> None:
    """Schlick: from the share when seen straight, with the fifth power of 1 - cos."""
    angle = np.radians([0, 45, 60, 75, 85])
    shares = [
        met(Material(mirror=0.08), (3 * np.sin(a), 0.0, 3 * np.cos(a)), (0, 0, 0), (0, 0, 1)).mirror
        for a in angle
    ]
    rise = np.array(shares)[:, 0] - 0.08
    assert rise[0] == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(
        rise / rise[-1], ((1 - np.cos(angle)) / (1 - np.cos(angle[-1]))) ** 5, atol=1e-4
    )
    assert 0.4 < 0.08 + rise[-1] < 1.0
    assert met(Material(), (3, 0, 1), (0, 0, 0), (0, 0, 1)).mirror[0] == 0.0


def test_light_is_what_the_sun_and_the_sky_leave_behind_the_haze() -> None:
    """White before the air's colour: contrast falls as exp(-distance / haze)."""
    found = Surfaces(
        np.full((4, 3), 0.5, np.float32), np.zeros((4, 3), np.float32),
        np.zeros((4, 3), np.float32), np.array([0.0, 0.7, 0.7, 0.0], np.float32),
        *(np.zeros(4, np.float32) for _ in range(4)),
    )  # fmt: skip
    distances = np.array([0.0, 0.0, 1000.0, 0.0], np.float32)
    sun, horizon = np.array([3.0, 2.0, 1.0], np.float32), np.array([1.0, 1.1, 1.2], np.float32)
    out = np.empty((4, 3), np.float32)
    sky = np.full((96, 512, 3), 0.9, np.float32)
    ambient = np.full((4, 3), 0.4, np.float32)
    up = np.tile(np.array([0.0, 0, 1], np.float32), (4, 1))
    faces, noon = np.array([0, 0, 0, -1], np.int32), np.array([0.0, 0, 1], np.float32)
    radiance(faces, distances, up, found, ambient, noon, sun, sky, horizon, np.float32(1000.0), out)
    np.testing.assert_allclose(out[0], 0.2, rtol=1e-4)
    lit = 0.5 * (sun * 0.7 + 0.4)
    np.testing.assert_allclose(out[1], lit, rtol=1e-4)
    np.testing.assert_allclose(out[2], lit / np.e + horizon * (1 - 1 / np.e), rtol=1e-3)
    assert (out[3] >= 0.89).all()


@pytest.mark.parametrize(("azimuth", "elevation"), [(2.2, 0.75), (-0.6, 0.45), (0.9, 1.0)])
def test_a_shadow_falls_where_the_sun_casts_it(look, azimuth: float, elevation: float) -> None:
    """The hull of a box's corners, moved along the sun's rays onto the ground."""
    light = Light(azimuth=azimuth, elevation=elevation, cloudiness=0.02)
    ground = polygon([(-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0)])
    body = box(4.0, 2.0, 1.5).placed(0.0, 0.0, 0.0, 0.4)
    scene = RayScene([Thing(ground, Surface.ROAD, 0), Thing(body, Surface.VEHICLE, 1)])
    camera = look((0.0, 0.0, 20.0), (0.0, 0.0, 0.0), focal_length=120.0, size=(100, 100))
    view = Renderer(scene, light).view(camera)
    corners = np.unique(body.vertices, axis=0).astype(float)
    fallen = corners - corners[:, 2:] / light.sun[2] * light.sun.astype(float)
    to_camera = np.linalg.inv(camera.to_world)

    def outline(points: np.ndarray) -> shapely.Polygon:
        x, y, z = (points @ to_camera[:3, :3].T + to_camera[:3, 3]).T
        pixels = np.stack([120 * x / z + 49.5, 120 * y / z + 49.5], axis=-1)
        return shapely.convex_hull(shapely.MultiPoint(pixels))

    u, v = np.meshgrid(np.arange(100), np.arange(100))
    on_ground = view.geometry.object_id == 0
    expected = shapely.contains_xy(outline(fallen), u, v) & on_ground
    light_on_ground = view.light.mean(axis=-1)
    level = np.median(light_on_ground[on_ground & ~expected])
    dark = (light_on_ground < 0.7 * level) & on_ground
    assert expected.sum() > 50
    assert (dark & expected).sum() / (dark | expected).sum() > 0.9


def test_varnish_shows_the_sun_where_it_mirrors_it_and_flakes_follow(look) -> None:
    sun = np.array([0.6, 0.0, 0.8])
    to_viewer = {"mirrored": sun * [-1, 1, 1], "elsewhere": np.array([0.6, 0.5, 0.6245])}

    def light(material: Material, towards: str) -> float:
        view = to_viewer[towards]
        found = met(material, 3 * view, (0, 0, 0), sun)
        out = np.empty((1, 3), np.float32)
        sky, one = np.full((96, 512, 3), 0.5, np.float32), np.ones(3, np.float32)
        ray = -(view / np.linalg.norm(view))[None].astype(np.float32)
        face, near = np.zeros(1, np.int32), np.zeros(1, np.float32)
        ambient = np.zeros((1, 3), np.float32)
        noon = sun.astype(np.float32)
        radiance(face, near, ray, found, ambient, noon, one, sky, one, np.float32(1e6), out)
        return float(out[0, 0])

    grey = (0.2, 0.2, 0.2)
    dull, varnished = Material(tint=grey), Material(tint=grey, mirror=0.045)
    metallic = Material(tint=grey, mirror=0.045, flakes=0.6)
    assert light(varnished, "mirrored") > 2.0 + light(dull, "mirrored")
    assert light(varnished, "elsewhere") == pytest.approx(light(dull, "elsewhere"), rel=0.05)
    assert light(metallic, "mirrored") > light(varnished, "mirrored") + 0.1
    assert light(metallic, "elsewhere") < 0.9 * light(varnished, "elsewhere")


def test_one_sees_through_two_panes_as_dimly_as_their_tints_say(look) -> None:
    def seen(panes: int, tint: float) -> float:
        glass = Material(tint=(tint,) * 3, clear=1.0, glass=True)
        wall = [(9, 5, -5), (9, -5, -5), (9, -5, 9), (9, 5, 9)]
        lit = Material(tint=(0.4, 0.4, 0.4), glow=0.5)
        things = [Thing(polygon(wall, lit), Surface.BUILDING)]
        for number in range(panes):
            x = 3.0 + number
            pane = [(x, 2, -2), (x, -2, -2), (x, -2, 1.6), (x, 2, 1.6)]
            things.append(Thing(polygon(pane, glass), Surface.VEHICLE, 0))
        # Seen from the shade, so that all light comes from the wall itself.
        light = Light(azimuth=0.0, cloudiness=1.0, haze=1e7)
        view = Renderer(RayScene(things), light).view(look(size=(31, 31)))
        return float(view.light[25, 15, 1] / view.light[5, 15, 1])

    whole = seen(0, 1.0)
    assert seen(1, 0.5) == pytest.approx(0.5 * whole, rel=0.2)
    assert seen(2, 0.5) == pytest.approx(0.25 * whole, rel=0.2)
