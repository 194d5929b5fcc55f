import numpy as np
import pytest
import shapely

from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import NOTHING, RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.rendering.silhouettes import silhouettes
from avsec_gym.world.section import Surface
from avsec_gym.world.shapes import box, ellipsoid

pytestmark = pytest.mark.usefixtures("little_textures")

PLACES = {
    "ahead": (12.0, 0.5, 0.0, 0.4),
    "far": (60.0, -9.0, 0.0, 1.0),
    "cut on the left": (6.0, 5.0, 0.0, 0.0),
    "cut on the right and below": (4.0, -3.0, -0.5, 0.7),
    "outside": (5.0, 20.0, 0.0, 0.0),
}


def outline(mesh, camera) -> shapely.Polygon:
    to_camera = np.linalg.inv(camera.to_world)
    x, y, z = (np.unique(mesh.vertices, axis=0) @ to_camera[:3, :3].T + to_camera[:3, 3]).T
    u, v = camera.focal_length * np.stack([x, y]) / z + np.array(camera.centre)[:, None]
    return shapely.convex_hull(shapely.multipoints(np.stack([u, v], axis=-1)))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("kind", ["box", "ball"])
def test_area_and_extent_are_those_of_the_projected_hull(look, place: str, kind: str) -> None:
    """Pixels whose middle lies in the hull; the hull's bounds, beyond the image too."""
    mesh = box(4.0, 1.8, 1.5) if kind == "box" else ellipsoid((0, 0, 1), (2.0, 1.0, 0.8))
    x, y, z, yaw = PLACES[place]
    mesh = mesh.placed(x, y, z, yaw)
    camera = look()
    found = silhouettes(RayScene([Thing(mesh, Surface.VEHICLE, 0)]), camera, 1)
    hull = outline(mesh, camera)
    np.testing.assert_allclose(found.extent[0], hull.bounds, atol=2e-3)
    u, v = np.meshgrid(np.arange(160), np.arange(48))
    expected = shapely.contains_xy(hull, u, v).sum()
    # Pixels whose middle lies on an edge may fall either way.
    assert abs(int(found.area[0]) - int(expected)) <= 2


def test_each_object_is_drawn_as_if_alone(look) -> None:
    """One car behind another, and scenery before both, which is no object."""
    camera = look()
    cars = [box(4.0, 1.8, 1.5).placed(x, 0.3 * x - 2) for x in (9.0, 12.0, 30.0)]
    wall = box(0.2, 9.0, 3.0).placed(5.0, 0.0)
    scene = RayScene(
        [Thing(wall, Surface.BUILDING, NOTHING)]
        + [Thing(mesh, Surface.VEHICLE, index) for index, mesh in enumerate(cars)]
    )
    found = silhouettes(scene, camera, 4)
    for index, mesh in enumerate(cars):
        alone = silhouettes(RayScene([Thing(mesh, Surface.VEHICLE, 0)]), camera, 1)
        assert found.area[index] == alone.area[0]
        np.testing.assert_array_equal(found.extent[index], alone.extent[0])
    assert found.area[3] == 0
    assert np.isnan(found.extent[3]).all()


def test_pixels_of_several_parts_are_counted_once(look) -> None:
    """Parts of one object that are hidden by its other parts add nothing."""
    camera = look()
    whole = box(4.0, 1.8, 1.5).placed(10.0, 0.0)
    parts = [whole, box(1.0, 1.0, 1.0).placed(10.0, 0.0, 0.2)]
    found = silhouettes(RayScene([Thing(mesh, Surface.VEHICLE, 0) for mesh in parts]), camera, 1)
    alone = silhouettes(RayScene([Thing(whole, Surface.VEHICLE, 0)]), camera, 1)
    assert found.area[0] == alone.area[0]


def test_what_lies_behind_has_no_silhouette(look) -> None:
    behind = box(4.0, 1.8, 1.5).placed(-8.0, 0.0)
    found = silhouettes(RayScene([Thing(behind, Surface.VEHICLE, 0)]), look(), 1)
    assert found.area[0] == 0
    assert np.isnan(found.extent).all()


@pytest.mark.parametrize("x", [1.5, 0.0, 3.0])
def test_what_reaches_behind_the_camera_keeps_what_is_seen_of_it(look, x: float) -> None:
    """A car beside the camera fills the pixels that the renderer shows of it."""
    beside = box(5.0, 1.8, 1.5).placed(x, 1.6)
    camera = look(focal_length=80.0)
    scene = RayScene([Thing(beside, Surface.VEHICLE, 0)])
    found = silhouettes(scene, camera, 1)
    seen = Renderer(scene, Light()).geometry(camera).object_id == 0
    assert abs(int(found.area[0]) - int(seen.sum())) <= 0.02 * seen.sum() + 3
    rows, columns = np.nonzero(seen)
    left, top, right, bottom = found.extent[0]
    assert left <= columns.min()
    assert top <= rows.min()
    assert right >= columns.max()
    assert bottom >= rows.max()
