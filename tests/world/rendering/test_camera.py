import numpy as np
import pytest
import shapely

from avsec_gym.geometry import project, transform_points
from avsec_gym.rig import camera_rig
from avsec_gym.world.capture import pinhole
from avsec_gym.world.material import Material
from avsec_gym.world.rendering.camera import PinholeCamera
from avsec_gym.world.rendering.image_sensor import tone_curve
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import NOTHING, RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, ellipsoid, polygon

pytestmark = pytest.mark.usefixtures("little_textures")

RIG = camera_rig([0.0, 0.54], focal_length=200.0, centre=(118.3, 37.2), size=(240, 72))
BLACK = Material(tint=(0.0, 0.0, 0.0))


def renderer(*things: Thing, light: Light = Light()) -> Renderer:
    return Renderer(RayScene(things), light)


def plate(centre, half: float, material: Material = Material()) -> np.ndarray:
    """A square across the x axis that looks back along it."""
    x, y, z = centre
    signs = ((1, -1), (-1, -1), (-1, 1), (1, 1))
    return polygon([(x, y + i * half, z + j * half) for i, j in signs], material)


def wall(distance: float, slope: float, material: Material) -> np.ndarray:
    """A wide wall: x = distance + slope * y."""
    edges = [(distance + slope * y, y, z) for y, z in ((40, -30), (-40, -30), (-40, 30), (40, 30))]
    return polygon(edges, material)


@pytest.mark.parametrize("camera", [0, 1])
def test_things_appear_where_their_projection_says(camera: int) -> None:
    """Pixel (u, v) is the middle of column u and row v: half a pixel's error would be seen."""
    rng = np.random.default_rng(camera)
    pixels = np.stack([rng.uniform(12, 226, 40), rng.uniform(8, 62, 40)], axis=-1)
    offsets = []
    for pixel in pixels:
        depth = float(rng.uniform(5.0, 60.0))
        in_camera_0 = np.append((pixel - [118.3, 37.2]) / 200.0, 1.0) * depth
        in_camera_0[0] += camera * 0.54
        place = transform_points(RIG.camera_to_vehicle, in_camera_0)
        expected, _ = project(RIG.calibration.projection(camera), in_camera_0)
        np.testing.assert_allclose(expected, pixel, atol=1e-9)
        scene = renderer(Thing(plate(place, 3.5 * depth / 200.0), Surface.VEHICLE, 5))
        seen = scene.geometry(pinhole(RIG, camera, np.eye(4)))
        rows, columns = np.nonzero(seen.object_id == 5)
        assert len(rows) in (49, 42, 36, 56, 64)
        np.testing.assert_allclose(seen.depth[rows, columns], depth, rtol=1e-4)
        offsets.append([columns.mean() - pixel[0], rows.mean() - pixel[1]])
    assert np.abs(offsets).max() < 0.51
    np.testing.assert_allclose(np.mean(offsets, axis=0), 0.0, atol=0.15)


def test_depth_of_level_and_tilted_ground_is_analytic() -> None:
    u, v = np.meshgrid(np.arange(240), np.arange(72))
    right, down = (u - 118.3) / 200.0, (v - 37.2) / 200.0
    flat = [(-99.0, -999, 0), (999, -999, 0), (999, 999, 0), (-99, 999, 0)]
    for rise, fall in ((0.0, 0.0), (0.04, -0.1)):
        ground = polygon([(x, y, rise * x + fall * y) for x, y, _ in flat])
        seen = renderer(Thing(ground, Surface.ROAD)).geometry(pinhole(RIG, 0, np.eye(4)))
        # A ray's point t (1, -right, -down) + (0, 0, 1.65) lies on z = rise x + fall y.
        with np.errstate(divide="ignore"):
            expected = 1.65 / (down + rise - fall * right)
        ahead = (expected > 0) & (expected < 300)
        assert ahead.mean() > 0.3
        np.testing.assert_allclose(seen.depth[ahead], expected[ahead], rtol=1e-3)
        assert (seen.surface[ahead] == Surface.ROAD).all()
        assert np.isinf(seen.depth[expected < 0]).all()
        assert (seen.surface[expected < 0] == Surface.SKY).all()
    assert (seen.object_id == NOTHING).all()


def test_depth_of_a_ball_is_analytic() -> None:
    centre, radius = np.array([12.0, 1.0, 1.9]), 1.2
    ball = ellipsoid(centre, [radius] * 3, rings=120)
    seen = renderer(Thing(ball, Surface.VEHICLE, 0)).geometry(pinhole(RIG, 0, np.eye(4)))
    u, v = np.meshgrid(np.arange(240), np.arange(72))
    ray = np.stack([np.ones_like(u), (118.3 - u) / 200.0, (37.2 - v) / 200.0], axis=-1)
    middle = centre - [0, 0, 1.65]
    b, a = ray @ middle, (ray**2).sum(-1)
    root = b**2 - a * (middle @ middle - radius**2)
    depth = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
    assert np.count_nonzero(np.isfinite(depth) != np.isfinite(seen.depth)) <= 8
    both = np.isfinite(depth) & np.isfinite(seen.depth)
    assert both.sum() > 1000
    error = np.abs(seen.depth[both] - depth[both])
    assert np.median(error) < 2e-3
    assert error.max() < 0.1


@pytest.mark.parametrize(("distance", "slope"), [(9.0, 0.0), (11.0, 0.5)])
def test_matching_finds_the_disparity_of_the_geometry(distance: float, slope: float) -> None:
    """Sub-pixel correlation of the rendered images: f b / z within a tenth of a pixel."""
    scene = renderer(Thing(wall(distance, slope, Material("speckles")), Surface.BUILDING, 0))
    left, right = (scene.view(pinhole(RIG, camera, np.eye(4))) for camera in (0, 1))
    one, two = (view.light.mean(axis=-1) for view in (left, right))
    assert one.std() > 0.03
    errors = []
    for row in range(6, 66, 6):
        for column in range(60, 220, 16):
            truth = 200.0 * 0.54 / left.geometry.depth[row, column]
            window = one[row - 5 : row + 6, column - 7 : column + 8]
            around = round(float(truth))
            scores = [
                correlation(window, two[row - 5 : row + 6, column - 7 - d : column + 8 - d])
                for d in (around - 1, around, around + 1)
            ]
            if scores[1] < max(scores) or scores[1] < 0.8:
                around += int(np.argmax(scores)) - 1
                scores = [
                    correlation(window, two[row - 5 : row + 6, column - 7 - d : column + 8 - d])
                    for d in (around - 1, around, around + 1)
                ]
            peak = 0.5 * (scores[0] - scores[2]) / (scores[0] - 2 * scores[1] + scores[2])
            errors.append(around + peak - truth)
    assert abs(np.median(errors)) < 0.05
    assert np.median(np.abs(errors)) < 0.1
    assert np.percentile(np.abs(errors), 90) < 0.25


def correlation(one: np.ndarray, two: np.ndarray) -> float:
    one, two = one - one.mean(), two - two.mean()
    return float((one * two).sum() / np.sqrt((one**2).sum() * (two**2).sum()))


def test_two_cameras_see_one_world() -> None:
    """What the left camera sees at depth z, the right one sees f b / z further left."""
    rng = np.random.default_rng(0)
    things = [
        Thing(
            box(2.0, 1.5, 1.5).placed(
                rng.uniform(8, 30), rng.uniform(-6, 6), 0.0, rng.uniform(0, 6)
            ),
            Surface.VEHICLE,
            index,
        )
        for index in range(8)
    ]
    things.append(
        Thing(polygon([(0, -99, 0), (99, -99, 0), (99, 99, 0), (0, 99, 0)]), Surface.ROAD)
    )
    left, right = (renderer(*things).geometry(pinhole(RIG, i, np.eye(4))) for i in (0, 1))
    v, u = np.nonzero(np.isfinite(left.depth))
    depth = left.depth[v, u]
    there = np.round(u - 200.0 * 0.54 / depth).astype(int)
    inside = there >= 0
    v, u, there, depth = v[inside], u[inside], there[inside], depth[inside]
    nearer = right.depth[v, there] < 0.97 * depth
    same = right.object_id[v, there] == left.object_id[v, u]
    # What is hidden on the right is hidden by something nearer; the rest is the same thing.
    assert (same | nearer)[depth < 40].mean() > 0.985
    assert nearer.mean() < 0.15
    plain = same & ~nearer
    assert np.median(np.abs(right.depth[v, there] - depth)[plain] / depth[plain]) < 0.01


@pytest.mark.parametrize("turn", [0.1, 0.3, 1.1])
def test_edges_are_as_bright_as_their_share_of_white(look, turn: float) -> None:
    """The light of a white plate before black, summed, is its area in pixels."""
    half, depth = 1.0, 10.0
    angles = turn + np.pi * np.array([0.25, 0.75, 1.25, 1.75])
    corners = [(depth, 1.4 * half * np.sin(a), 1.65 - 1.4 * half * np.cos(a)) for a in angles]
    scene = renderer(
        Thing(polygon(corners), Surface.FURNITURE, 1),
        Thing(wall(30.0, 0.0, BLACK), Surface.BUILDING, 2),
        light=Light(cloudiness=0.02, azimuth=np.pi, elevation=0.5, haze=1e7),
    )
    camera = look(size=(61, 61))
    light = scene.view(camera).light[..., 1]
    inside = scene.geometry(camera).object_id == 1
    dark, level = np.median(light[~inside]), np.median(light[inside])
    light = (light - dark) / (level - dark)
    outline = shapely.Polygon(
        [(30 - 100 * y / depth, 30 - 100 * (z - 1.65) / depth) for _, y, z in corners]
    )
    assert light.sum() == pytest.approx(outline.area, rel=0.015)
    v, u = np.mgrid[:61, :61]
    share = shapely.area(
        shapely.intersection(shapely.box(u - 0.5, v - 0.5, u + 0.5, v + 0.5), outline)
    )
    np.testing.assert_allclose(light[share == 0], 0.0, atol=0.05)
    np.testing.assert_allclose(light[share > 1 - 1e-9], 1.0, atol=0.05)
    border = (share > 0) & (share < 1)
    assert np.abs(light - share)[border].mean() < 0.15


def test_exposure_brings_every_image_to_the_brightness_aimed_for(look) -> None:
    for brightness, cloudiness in ((0.30, 0.02), (0.42, 0.95)):
        light = Light(brightness=brightness, cloudiness=cloudiness)
        ground = polygon([(-9, -99, 0), (99, -99, 0), (99, 99, 0), (-9, 99, 0)])
        things = Thing(ground, Surface.ROAD), Thing(box(2, 2, 2, BLACK).placed(9, 1), Surface.KERB)
        image = tone_curve(np.clip(renderer(*things, light=light).view(look()).light, 0, 1))
        assert float(image.mean()) == pytest.approx(brightness, abs=0.015)


def test_mirrors_show_what_stands_beside(look) -> None:
    """A ball's picture in a wall mirror lies where the ball behind the mirror would."""
    mirror = polygon(
        [(2.0, 2.0, -5), (40.0, 2.0, -5), (40.0, 2.0, 9), (2.0, 2.0, 9)],
        Material(tint=(0, 0, 0), mirror=0.95),
    )  # its right side looks towards -y
    red = ellipsoid((9.0, -1.0, 1.8), (0.5, 0.5, 0.5), Material(tint=(1.0, 0, 0), glow=1.0))
    backdrop = polygon([(0, -50, -50), (0, -50, 50), (90, -50, 50), (90, -50, -50)], BLACK)
    scene = renderer(
        Thing(mirror, Surface.BUILDING, 0),
        Thing(red, Surface.VEHICLE, 1),
        Thing(backdrop, Surface.BUILDING, 2),
    )
    camera = look()
    view = scene.view(camera)
    in_mirror = view.geometry.object_id == 0
    redness = np.where(in_mirror, view.light[..., 0] - view.light[..., 2], 0.0)
    v, u = np.nonzero(redness > 0.5 * redness.max())
    x, y, z = 9.0, 2 * 2.0 + 1.0, 1.8 - 1.65
    assert u.mean() == pytest.approx(79.5 - 100 * y / x, abs=0.6)
    assert v.mean() == pytest.approx(23.5 - 100 * z / x, abs=0.6)
    assert len(v) == pytest.approx(np.pi * (100 * 0.5 / x) ** 2, rel=0.25)


def test_thin_and_flat_things_leave_no_holes_in_the_light(look) -> None:
    rng = np.random.default_rng(0)
    wires = [
        box(0.01, 0.01, 6.0).placed(*rng.uniform((3, -5, -1), (30, 5, 1)), rng.uniform(0, 3))
        for _ in range(40)
    ]
    leaf = Material(translucent=0.4, mirror=0.05)
    leaves = [
        polygon([(0, 0, 0), (0.2, 0, 0), (0.1, 0.1, 0.05)], leaf).placed(
            *rng.uniform((2, -4, 0), (9, 4, 3))
        )
        for _ in range(60)
    ]
    splinter = polygon([(5, 0, 0), (5, 1, 1), (5, 2, 2)], uv=np.zeros((3, 2)))
    things = [Thing(mesh, Surface.FURNITURE) for mesh in (*wires, *leaves, splinter)]
    view = renderer(*things).view(look())
    assert np.isfinite(view.light).all()
    assert (view.light >= 0).all()
    assert not np.isnan(view.geometry.depth).any()


def test_a_picture_is_the_same_every_time_and_from_equal_scenes(look) -> None:
    def take() -> np.ndarray:
        things = [Thing(box(2, 2, 2, Material("speckles")).placed(8, 1), Surface.VEHICLE, 0)]
        things.append(
            Thing(polygon([(0, -9, 0), (90, -9, 0), (90, 9, 0), (0, 9, 0)]), Surface.ROAD)
        )
        return renderer(*things).view(look()).light

    np.testing.assert_array_equal(take(), take())


def test_a_camera_may_look_straight_down(look) -> None:
    ground = polygon([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)])
    seen = renderer(Thing(ground, Surface.ROAD)).geometry(look((0, 0, 5.0), (0, 0, 0)))
    np.testing.assert_allclose(seen.depth, 5.0, rtol=1e-5)
    assert isinstance(look(), PinholeCamera)
